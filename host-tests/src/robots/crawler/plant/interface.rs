//! Implements the simulator's [`Plant`] interface for the crawler.

use super::Crawler;
use crate::world::Plant;
use crate::world::truth::{BodyPose, BodyShape, Part, Sketch, Truth};
use rapier3d_f64::math::Vector;
use tautrack::link::{BodyMeasurands, Sensors, Shaft};

impl Plant for Crawler {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        self.advance([0, 1].map(|motor: usize| shafts.get(motor).and_then(Option::as_ref)));
    }

    fn sensors(&self, motor: usize) -> Sensors {
        let radius = self.parameters.sprocket_radius;
        let torque = self
            .tracks
            .get(motor)
            .map(|track| track.shaft_torque(radius));
        Sensors {
            shaft_torque: torque.unwrap_or(0.0) as f32,
            supply_voltage: self.parameters.supply_voltage as f32,
            ..Sensors::default()
        }
    }

    fn body_sensors(&self) -> BodyMeasurands {
        self.sensing.reading()
    }

    fn serial(&self) -> &[u8] {
        self.receiver.sent()
    }

    fn sketch(&self) -> Sketch {
        let r = self.parameters.sprocket_radius;
        Sketch {
            circles: vec![(0, r), (1, r)],
            lines: vec![
                vec![2, 3],
                vec![4, 5],
                vec![6, 7, 8, 9, 6],
                vec![10, 6],
                vec![10, 7],
            ],
        }
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let p = &self.parameters;
        let track = |side: f64| Part::Box {
            centre: [0.0, side * p.track_spacing, p.sprocket_radius],
            size: [
                p.contact_length + 2.0 * p.sprocket_radius,
                p.track_width,
                2.0 * p.sprocket_radius,
            ],
        };
        let hull = Part::Box {
            centre: [0.0, 0.0, p.cog[2]],
            size: p.extent,
        };
        vec![BodyShape {
            name: "body",
            parts: vec![hull, track(0.5), track(-0.5)],
        }]
    }

    fn poses(&self) -> Vec<BodyPose> {
        vec![BodyPose {
            place: self.body.place(Vector::ZERO).to_array(),
            rotation: self.body.rotation.to_array(),
        }]
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.ground.surface(place)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        let body = &self.body;
        body.rotation.to_array().into_iter().for_each(&mut put);
        for vector in [body.cog, body.velocity, body.spin] {
            vector.to_array().into_iter().for_each(&mut put);
        }
        for track in &self.tracks {
            [track.speed, track.traction].into_iter().for_each(&mut put);
            track.shear.into_iter().flatten().for_each(&mut put);
        }
        self.sensing.bits(&mut put);
        self.receiver.wander().into_iter().for_each(&mut put);
        put(self.truth.slip);
    }
}
