//! Creates the crawler and lets it settle on its ground before a run.

use super::body::{Body, MassProperties};
use super::ground::Ground;
use super::step::integrate;
use super::track::Track;
use super::{Crawler, CrawlerParameters, Profile};
use crate::world::gnss::Receiver;
use crate::world::noise::Noise;
use crate::world::physics::turn;
use crate::world::sensing::BodySensing;
use crate::world::truth::Truth;
use rapier3d_f64::math::Vector;

/// Number of substeps in which the robot settles before a run, and the factor by which each reduces
/// its speed.
const SETTLING: (usize, f64) = (8_000, 0.98);

impl Crawler {
    /// Creates the robot at rest at the origin of the ground; `seed` is the seed of the sensor
    /// noise.
    pub fn new(parameters: &CrawlerParameters, profile: &Profile, seed: u64) -> Self {
        let p = *parameters;
        let ground = Ground::new(profile);
        let [heading, left] = p.initial_heading_and_y;
        let payload = p.payload.filter(|payload| payload.from_time_s <= 0.0);
        let properties = MassProperties::new(&p, payload);
        let start = ground.start();
        let mut body = Body::at_rest(
            properties,
            start * Vector::new(0.0, left, 0.0),
            start * turn(Vector::Z, heading),
        );
        let mut tracks = [0.5, -0.5].map(|side: f64| Track::new(side * p.track_spacing));
        let (substeps, left_over) = SETTLING;
        for _ in 0..substeps {
            integrate(&p, &ground, &mut body, &mut tracks);
            body.velocity *= left_over;
            body.spin *= left_over;
        }
        (body.velocity, body.spin) = (Vector::ZERO, Vector::ZERO);
        let mut plant = Self {
            ground,
            body,
            tracks,
            sensing: BodySensing::new(&p.body_sensors, Noise::new(seed), body.rotation),
            receiver: Receiver::new(p.receiver, Noise::new(seed)),
            step: 0,
            payload,
            truth: Truth::default(),
            parameters: p,
        };
        plant.observe();
        plant
    }
}
