//! Implements the simulator's [`Plant`] interface for Hylos.

use super::{Hylos, LEGS, MOTORS};
use crate::world::Plant;
use crate::world::physics::pose;
use crate::world::sensing::BodyMotion;
use crate::world::truth::{BodyPose, BodyShape, Part, Sketch, Truth};
use tautrack::link::{BodyMeasurands, Sensors, Shaft};

/// Names of the bodies in pictures: the platform, and the wheels in the order of the legs.
const BODIES: [&str; 1 + LEGS] = [
    "platform",
    "front_left_wheel",
    "front_right_wheel",
    "rear_left_wheel",
    "rear_right_wheel",
];
/// Height of the platform and width of the tyres in pictures, m. The paper gives neither.
const PLATFORM_HEIGHT: f64 = 0.06;
const TYRE_WIDTH: f64 = 0.05;

impl Plant for Hylos {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        let (legs, _) = shafts.as_chunks::<4>();
        assert_eq!(
            (legs.len(), shafts.len()),
            (LEGS, MOTORS),
            "one shaft for each motor"
        );
        for (leg, shafts) in legs.iter().enumerate() {
            self.drive_leg(leg, shafts);
        }
        self.world.step();
        self.step += 1;
        for leg in 0..LEGS {
            self.leg_torques[leg] = self.torques(leg);
        }
        self.observe();
        let sensors = &self.parameters.body_sensors;
        let motion = BodyMotion::of(&self.world.bodies[self.robot.platform], sensors);
        self.body_sensing.update(sensors, &motion, self.step);
    }

    fn sensors(&self, motor: usize) -> Sensors {
        self.shaft_sensors(motor)
    }

    fn body_sensors(&self) -> BodyMeasurands {
        self.body_sensing.reading()
    }

    /// Draws wheels and legs, and the platform as the line through its hips.
    fn sketch(&self) -> Sketch {
        let p = &self.parameters;
        let mut lines: Vec<_> = (0..LEGS)
            .map(|leg| (3 * leg..3 * leg + 3).collect())
            .collect();
        lines.push([0, 1, 3, 2, 0].map(|leg| 3 * leg).to_vec());
        Sketch {
            circles: (0..LEGS)
                .map(|leg| (3 * leg + 2, p.measures.wheel_radius))
                .collect(),
            lines,
        }
    }

    fn forces(&self) -> Vec<[[f64; 3]; 2]> {
        let forces = self
            .detail
            .contacts
            .into_iter()
            .zip(self.detail.wheel_forces);
        let normal = |place: [f64; 3]| self.hillside.normal([place[0], place[1]]);
        forces
            .map(|(place, force)| [place, normal(place).map(|part| part * force)])
            .collect()
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let m = &self.parameters.measures;
        let platform = Part::Box {
            centre: [0.0; 3],
            size: [2.0 * m.hip[0], 2.0 * m.hip[1], PLATFORM_HEIGHT],
        };
        let wheel = Part::Wheel {
            centre: [0.0; 3],
            radius: m.wheel_radius,
            width: TYRE_WIDTH,
        };
        let parts = std::iter::once(platform).chain([wheel; LEGS]);
        BODIES
            .into_iter()
            .zip(parts)
            .map(|(name, part)| BodyShape {
                name,
                parts: vec![part],
            })
            .collect()
    }

    fn poses(&self) -> Vec<BodyPose> {
        std::iter::once(self.robot.platform)
            .chain(self.robot.wheels)
            .map(|handle| pose(&self.world.bodies[handle]))
            .collect()
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.hillside.height(place)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        let handles = [self.robot.platform]
            .into_iter()
            .chain(self.robot.carriers)
            .chain(self.robot.wheels);
        for handle in handles {
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
        self.leg_torques
            .as_flattened()
            .iter()
            .copied()
            .for_each(&mut put);
        self.body_sensing.bits(&mut put);
    }
}
