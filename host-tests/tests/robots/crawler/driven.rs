//! The crawler's plant with ideal motors: the sprockets turn as commanded.

use core::f64::consts::TAU;
use tautrack::link::Shaft;
use tautrack_host_tests::robots::crawler::plant::{Crawler, CrawlerParameters, Profile, Soil};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::load::Load;

/// Length of a step, s.
pub const DT: f64 = 1e-3;

/// Plant whose sprockets turn as commanded, with limited acceleration.
pub struct Driven {
    pub plant: Crawler,
    pub radius: f64,
    pub speeds: [f64; 2],
    pub angles: [f64; 2],
    /// Maximum acceleration of the belts, m/s^2.
    pub acceleration: f64,
}

impl Driven {
    pub fn new(parameters: &CrawlerParameters, profile: &Profile) -> Self {
        Self {
            plant: Crawler::new(parameters, profile, 1),
            radius: parameters.sprocket_radius,
            speeds: [0.0; 2],
            angles: [0.0; 2],
            acceleration: 0.5,
        }
    }

    /// Runs one millisecond towards these belt speeds, m/s.
    pub fn step(&mut self, belts: [f64; 2]) {
        let most = self.acceleration / self.radius * DT;
        let shafts = [0, 1].map(|side: usize| {
            let change = belts[side] / self.radius - self.speeds[side];
            self.speeds[side] += change.clamp(-most, most);
            self.angles[side] += self.speeds[side] * DT;
            Shaft {
                position: (self.angles[side] / TAU * 4_294_967_296.0) as i64,
                velocity: self.speeds[side] as f32,
            }
        });
        self.plant.advance([Some(&shafts[0]), Some(&shafts[1])]);
    }

    /// Drives for `seconds`, or until the robot has toppled.
    pub fn drive(&mut self, belts: [f64; 2], seconds: f64) {
        for _ in 0..(seconds / DT).round() as usize {
            if !self.plant.truth().toppled {
                self.step(belts);
            }
        }
    }
}

pub fn slope(degrees: f64) -> Profile {
    Profile {
        slope: degrees.to_radians(),
        ..Profile::default()
    }
}

/// Parameters of a crawler with a load high above its body, on firm ground.
pub fn loaded(mass: f64, up: f64) -> CrawlerParameters {
    CrawlerParameters {
        soil: Soil::firm(),
        payload: Some(Load {
            mass,
            place: [0.0, 0.0, up],
            from_time_s: 0.0,
        }),
        ..CrawlerParameters::nominal()
    }
}
