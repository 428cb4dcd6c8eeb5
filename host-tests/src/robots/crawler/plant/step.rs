//! Runs one step of the plant: moves belts, body and ground, and reads the sensors.

use super::body::{Body, MassProperties};
use super::ground::Ground;
use super::track::Track;
use super::{Crawler, CrawlerParameters};
use crate::world::sensing::BodyMotion;
use rapier3d_f64::math::Vector;
use tautrack::link::Shaft;

/// Length of a step, s.
pub(super) const DT: f64 = 1e-3;
/// Number of substeps in which body and ground are integrated, because the ground is stiff.
const SUBSTEPS: usize = 4;

impl Crawler {
    /// Advances by one millisecond under the motion of the two sprockets, left and right; `None`
    /// means that the node is dead.
    pub fn advance(&mut self, sprockets: [Option<&Shaft>; 2]) {
        let p = &self.parameters;
        let due = p
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if self.payload.is_none() && due.is_some() {
            self.payload = due;
            self.body.load(MassProperties::new(p, due));
        }
        self.step += 1;
        for (track, shaft) in self.tracks.iter_mut().zip(sprockets) {
            track.drive(shaft, p, DT);
        }
        // A robot that has toppled stays where it is; its further motion is not simulated.
        if !self.truth.toppled {
            let mut traction = [0.0; 2];
            for _ in 0..SUBSTEPS {
                let part = integrate(p, &self.ground, &mut self.body, &mut self.tracks);
                traction = [0, 1].map(|side: usize| traction[side] + part[side] / SUBSTEPS as f64);
            }
            for (track, traction) in self.tracks.iter_mut().zip(traction) {
                track.pull(traction, DT);
            }
        }
        self.observe();
        if self.truth.toppled {
            (self.body.velocity, self.body.spin) = (Vector::ZERO, Vector::ZERO);
            self.tracks
                .iter_mut()
                .for_each(|track| track.traction = 0.0);
        }
        let sensors = &self.parameters.body_sensors;
        let place = self
            .body
            .place(Vector::from_array(sensors.accelerometer_place));
        let motion = BodyMotion {
            rotation: self.body.rotation,
            velocity: self.body.velocity_at(place),
        };
        self.sensing.update(sensors, &motion, self.step);
        let antenna = self
            .body
            .place(Vector::from_array(self.parameters.receiver.antenna));
        self.receiver.update(
            antenna.to_array(),
            self.body.velocity_at(antenna).to_array(),
            self.step,
        );
    }
}

/// Advances body and ground by one substep. Returns the traction of each track, N.
pub(super) fn integrate(
    parameters: &CrawlerParameters,
    ground: &Ground,
    body: &mut Body,
    tracks: &mut [Track; 2],
) -> [f64; 2] {
    let dt = DT / SUBSTEPS as f64;
    let [left, right] = tracks
        .each_mut()
        .map(|track| track.act(parameters, ground, body, dt));
    body.step(left.force + right.force, left.moment + right.moment, dt);
    [left.traction, right.traction]
}
