//! Implements the simulator's [`Plant`] interface for the crawler.

use super::Crawler;
use super::track::CELLS;
use crate::world::Plant;
use crate::world::truth::{BodyPose, BodyShape, Part, Sketch, Strip, Truth};
use rapier3d_f64::math::Vector;
use std::f64::consts::{FRAC_PI_2, PI};
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
            size: [p.contact_length, p.track_width, 1.7 * p.sprocket_radius],
        };
        let sprocket = |(end, side): (f64, f64)| Part::Wheel {
            centre: [
                end * p.contact_length,
                side * p.track_spacing,
                p.sprocket_radius,
            ],
            radius: p.sprocket_radius,
            width: p.track_width,
        };
        let ends = [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)];
        let hull = Part::Box {
            centre: [0.0, 0.0, p.cog[2]],
            size: [p.extent[0], p.track_spacing - p.track_width, p.extent[2]],
        };
        vec![BodyShape {
            name: "body",
            parts: [hull, track(0.5), track(-0.5)]
                .into_iter()
                .chain(ends.map(sprocket))
                .collect(),
        }]
    }

    fn forces(&self) -> Vec<[[f64; 3]; 2]> {
        let length = self.parameters.contact_length;
        let cells = self.tracks.iter().flat_map(|track| {
            let loaded = (0..CELLS).filter(|cell| track.loaded[*cell]);
            loaded.map(|cell| (track.cell(cell, length), track.forces[cell]))
        });
        cells
            .map(|(place, force)| [self.body.place(place).to_array(), force.to_array()])
            .collect()
    }

    fn belts(&self) -> Vec<Strip> {
        /// Number of pieces of a half turn.
        const PIECES: u32 = 12;
        let p = &self.parameters;
        let (half, radius) = (0.5 * p.contact_length, p.sprocket_radius);
        let strip = |side: f64| {
            let ends = [(half, -FRAC_PI_2), (-half, FRAC_PI_2)];
            let points = ends.into_iter().flat_map(|(end, from)| {
                (0..=PIECES).map(move |piece| {
                    let angle = from + PI * f64::from(piece) / f64::from(PIECES);
                    let (sine, cosine) = libm::sincos(angle);
                    let (x, z) = (end + radius * cosine, radius + radius * sine);
                    Vector::new(x, side * p.track_spacing, z)
                })
            });
            Strip {
                width: p.track_width,
                points: points.map(|at| self.body.place(at).to_array()).collect(),
            }
        };
        vec![strip(0.5), strip(-0.5)]
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
