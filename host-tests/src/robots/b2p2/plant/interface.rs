//! Implements the simulator's [`Plant`] interface for B2P2.

use super::B2p2;
use super::belt::Belt;
use super::robot::MARKS;
use crate::world::hand::Held;
use crate::world::truth::{BodyPose, BodyShape, Part, Strip, Truth};
use crate::world::{Plant, TrackFault, physics as world};
use rapier3d_f64::math::Vector;
use tautrack::link::{BodyMeasurands, Sensors, Shaft};

impl Plant for B2p2 {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        self.advance(shafts);
    }

    fn hold(&mut self, held: Option<&Held>) {
        let body = &mut self.world.bodies[self.robot.bodies[0]];
        self.grip.hold(body, held);
    }

    fn set_track_fault(&mut self, motor: usize, fault: TrackFault) {
        let Some(track) = self.track_faults.get_mut(motor) else {
            return;
        };
        if core::mem::replace(track, fault) == fault {
            return;
        }
        let friction = fault.friction.min(self.parameters.friction);
        for (_, collider) in self.world.colliders.iter_mut() {
            if collider.user_data == MARKS[motor + 1] {
                collider.set_friction(friction);
            }
        }
    }

    fn sensors(&self, motor: usize) -> Sensors {
        self.shaft_sensors(motor)
    }

    fn body_sensors(&self) -> BodyMeasurands {
        self.body_sensing.reading()
    }

    fn serial(&self) -> &[u8] {
        self.receiver.sent()
    }

    fn forces(&self) -> Vec<[[f64; 3]; 2]> {
        let forces = self.support.forces(self.step);
        forces
            .map(|(place, force)| [place.to_array(), force.to_array()])
            .collect()
    }

    fn belts(&self) -> Vec<Strip> {
        let p = &self.parameters;
        let left = self.world.bodies[self.robot.bodies[0]].position().rotation * Vector::Y;
        let strip = |belt: &Belt| Strip {
            width: p.belt_width,
            points: belt.drawn(left, p.pulley_radius),
        };
        self.belts.sides.iter().map(strip).collect()
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let p = &self.parameters;
        let bar = |length: f64| Part::Box {
            centre: [0.5 * length, 0.0, 0.0],
            size: [length, p.width - 2.0 * p.belt_width, 0.6 * p.pulley_radius],
        };
        let pulley = |x: f64| Part::Wheel {
            centre: [x, 0.0, 0.0],
            radius: p.pulley_radius,
            width: p.width,
        };
        let body = |name, parts| BodyShape { name, parts };
        vec![
            body("body_1", vec![bar(p.l1), pulley(0.0), pulley(p.l1)]),
            body("body_2", vec![bar(p.l2)]),
            body("body_3", vec![pulley(0.0)]),
        ]
    }

    fn poses(&self) -> Vec<BodyPose> {
        let pose = |handle| world::pose(&self.world.bodies[handle]);
        self.robot.bodies.map(pose).to_vec()
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.terrain.height(place, self.up)
    }

    fn ground_edges(&self, from: [f64; 2], direction: [f64; 2]) -> Vec<f64> {
        self.terrain.edges(from, direction)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        for handle in self.robot.bodies {
            let body = &self.world.bodies[handle];
            body.position()
                .rotation
                .to_array()
                .into_iter()
                .for_each(&mut put);
            for vector in [body.position().translation, body.linvel(), body.angvel()] {
                vector.to_array().into_iter().for_each(&mut put);
            }
        }
        for belt in &self.sprockets {
            [belt.speed, belt.traction, belt.slip_speed]
                .into_iter()
                .for_each(&mut put);
        }
        self.body_sensing.bits(&mut put);
        self.receiver.wander().into_iter().for_each(&mut put);
        put(self.truth.slip);
    }
}
