//! Implements the simulator's [`Plant`] interface for RT-Mover.

use super::{RtMover, robot};
use crate::world::Plant;
use crate::world::physics::pose;
use crate::world::truth::{BodyPose, BodyShape, Sketch, Truth};
use tautrack::link::{BodyMeasurands, Sensors, Shaft};

impl Plant for RtMover {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        self.advance(shafts);
    }

    fn sensors(&self, motor: usize) -> Sensors {
        self.shaft_sensors(motor)
    }

    fn body_sensors(&self) -> BodyMeasurands {
        self.sensing.reading()
    }

    fn sketch(&self) -> Sketch {
        let radius = self.parameters.lengths.wheel_radius;
        Sketch {
            circles: (0..4).map(|wheel| (wheel, radius)).collect(),
            lines: vec![vec![0, 4, 1], vec![2, 5, 3], vec![4, 6, 5], vec![6, 7]],
        }
    }

    fn forces(&self) -> Vec<[[f64; 3]; 2]> {
        let forces = self.wheels().into_iter().zip(self.loads());
        forces
            .map(|(place, load)| [place, [0.0, 0.0, load]])
            .collect()
    }

    fn bodies(&self) -> Vec<BodyShape> {
        robot::shapes(&self.parameters)
    }

    fn poses(&self) -> Vec<BodyPose> {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        bodies.map(pose).to_vec()
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
        self.sensing.bits(&mut put);
    }
}
