//! Runs one step of the plant: moves the gears, integrates the physics, and reads contacts and
//! sensors.

use super::contact::RunningBelts;
use super::{B2p2, contact, robot};
use crate::world::gear::Drive;
use crate::world::physics::DT;
use crate::world::sensing::BodyMotion;
use rapier3d_f64::math::{Rotation, Vector};
use rapier3d_f64::prelude::*;
use tautrack::link::Shaft;

impl B2p2 {
    /// Advances by one millisecond under the motion of the four shafts; `None` means that the node
    /// is dead.
    pub(super) fn advance(&mut self, shafts: &[Option<Shaft>]) {
        let p = self.parameters;
        let [left, right, joint, screw] =
            core::array::from_fn(|motor| shafts.get(motor).and_then(Option::as_ref));
        let [theta, _] = self.robot.chassis_joint(&self.world);
        let [extension, _] = self.robot.extension(&self.world, &p);
        self.put_payload_on();
        for (side, shaft) in [left, right].into_iter().enumerate() {
            let off = self.track_faults[side].belt_off;
            let resistance = if off {
                p.loose_belt_friction
            } else {
                p.dead_track_friction
            };
            let shaft = shaft.filter(|_| !off);
            self.sprockets[side].drive(shaft, p.pulley_radius, p.track_inertia, resistance);
        }
        let friction = self
            .track_faults
            .map(|fault| fault.friction.min(p.friction));
        // The engine knows the masses only from its second step on.
        if self.step > 0 {
            let speeds = self.sprockets.map(|belt| belt.speed);
            self.belts
                .pull(&mut self.world, &self.robot, &p, speeds, friction);
        }
        let mut joint = self.joint.drive(joint, theta);
        // The engine counts from the middle of the travel.
        joint.place -= p.joint_middle();
        let screw = self.screw.drive(screw, extension);
        self.drive_joint(self.robot.joint, JointAxis::AngX, joint);
        self.drive_joint(self.robot.screw, JointAxis::LinX, screw);

        let axle: Rotation = self.world.bodies[self.robot.bodies[0]].position().rotation;
        let running = RunningBelts {
            speed: self.sprockets.map(|belt| belt.surface_speed(p.belt_creep)),
            left: axle * Vector::Y,
        };
        self.world.step_with_events(&running, &());
        self.step += 1;
        let [now, _] = self.robot.chassis_joint(&self.world);
        let [length, _] = self.robot.extension(&self.world, &p);
        self.rates = [(now - theta) / DT, (length - extension) / DT];

        self.ground = contact::read(&self.world, &running, self.step, &mut self.support);
        contact::add_corners(&mut self.ground, &self.belts, self.step, &mut self.support);
        for (side, belt) in self.sprockets.iter_mut().enumerate() {
            belt.load(
                self.ground.traction[side],
                self.ground.slip[side],
                p.belt_creep,
            );
        }
        for (side, name) in ["left track", "right track"].into_iter().enumerate() {
            if self.belts.sides[side].comes_off(self.ground.side[side]) {
                self.truth.came_off.get_or_insert(name);
            }
        }
        self.observe();
        let body = &self.world.bodies[self.robot.bodies[0]];
        let motion = BodyMotion::of(body, &p.body_sensors);
        self.body_sensing
            .update(&p.body_sensors, &motion, self.step);
        let antenna = body
            .position()
            .transform_point(Vector::from_array(p.receiver.antenna));
        self.receiver.update(
            antenna.to_array(),
            body.velocity_at_point(antenna).to_array(),
            self.step,
        );
    }

    fn put_payload_on(&mut self) {
        let due = self
            .parameters
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if self.payload.is_none() && due.is_some() {
            self.payload = due;
            let loaded = robot::mass_properties(&self.parameters, 0, due);
            self.robot.masses[0] = loaded;
            let body = &mut self.world.bodies[self.robot.bodies[0]];
            body.set_additional_mass_properties(loaded, true);
        }
    }

    fn drive_joint(&mut self, handle: ImpulseJointHandle, axis: JointAxis, drive: Drive) {
        // Always present: the handle is valid as long as the world exists.
        if let Some(joint) = self.world.impulse_joints.get_mut(handle, false) {
            let [stiffness, damping] = drive.stiffness;
            joint
                .data
                .set_motor(axis, drive.place, drive.speed, stiffness, damping);
            joint.data.set_motor_max_force(axis, drive.limit);
        }
    }
}
