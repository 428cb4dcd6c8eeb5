//! Runs one step of the plant: moves the gears, integrates the physics, and reads the sensors.

use super::robot::SEAT;
use super::{RtMover, robot};
use crate::world::gear::Drive;
use crate::world::physics::DT;
use crate::world::sensing::BodyMotion;
use rapier3d_f64::prelude::*;
use tautrack::link::Shaft;

impl RtMover {
    /// Advances by one millisecond under the motion of the nine shafts; `None` means that the node
    /// is dead.
    pub(super) fn advance(&mut self, shafts: &[Option<Shaft>]) {
        self.put_payload_on();
        let before = self.robot.shafts.map(|shaft| shaft.angle(&self.world));
        for (motor, place) in before.into_iter().enumerate() {
            let shaft = shafts.get(motor).and_then(Option::as_ref);
            let drive = self.gears[motor].drive(shaft, place);
            self.drive(self.robot.shafts[motor].handle, drive);
        }
        self.world.step();
        self.step += 1;
        self.rates = self.robot.shafts.map(|shaft| shaft.rate(&self.world));
        self.observe();
        let p = &self.parameters.body_sensors;
        let seat = BodyMotion::of(&self.world.bodies[self.robot.bodies[SEAT]], p);
        self.sensing.update(p, &seat, self.step);
    }

    fn put_payload_on(&mut self) {
        let due = self
            .parameters
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if let (None, Some(load)) = (self.payload, due) {
            self.payload = due;
            let loaded = robot::seat(&self.parameters).with_load(&load);
            let seat = &mut self.world.bodies[self.robot.bodies[SEAT]];
            seat.set_additional_mass_properties(loaded.properties(), true);
        }
    }

    fn drive(&mut self, handle: ImpulseJointHandle, drive: Drive) {
        // Always present: the handle is valid as long as the world exists.
        if let Some(joint) = self.world.impulse_joints.get_mut(handle, false) {
            let [stiffness, damping] = drive.stiffness;
            let axis = JointAxis::AngX;
            joint
                .data
                .set_motor(axis, drive.place, drive.speed, stiffness, damping);
            joint.data.set_motor_max_force(axis, drive.limit);
        }
    }
}
