//! The crawler's plant against equilibrium and hand calculation, and the body controller that drives it.
//!
//! The motors here are ideal: the sprockets turn as they are told.

use core::f64::consts::{PI, TAU};
use tautrack::link::Shaft;
use tautrack::robots::crawler::{
    BodyVelocity, Configuration, Controller, Observation, parameters as model,
};
use tautrack_host_tests::plant::Plant;
use tautrack_host_tests::plant::b2p2::Payload;
use tautrack_host_tests::plant::crawler::{Crawler, CrawlerParameters, Profile, Soil};

const DT: f64 = 1e-3;
const GRAVITY: f64 = 9.81;
/// Period of SYNC, and so of the body controller, in milliseconds.
const SYNC: usize = 4;

/// Sprockets that turn as they are told, with a limit to their acceleration.
struct Driven {
    plant: Crawler,
    radius: f64,
    speeds: [f64; 2],
    angles: [f64; 2],
    /// Acceleration of the belts, m/s^2.
    acceleration: f64,
}

impl Driven {
    fn new(parameters: &CrawlerParameters, profile: &Profile) -> Self {
        Self {
            plant: Crawler::new(parameters, profile, 1),
            radius: parameters.sprocket_radius,
            speeds: [0.0; 2],
            angles: [0.0; 2],
            acceleration: 0.5,
        }
    }

    /// One millisecond towards these belt speeds, m/s.
    fn step(&mut self, belts: [f64; 2]) {
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

    /// Drives for `seconds` or until it has turned over.
    fn drive(&mut self, belts: [f64; 2], seconds: f64) {
        for _ in 0..(seconds / DT).round() as usize {
            if !self.plant.truth().toppled {
                self.step(belts);
            }
        }
    }
}

fn slope(degrees: f64) -> Profile {
    Profile {
        slope: degrees.to_radians(),
        ..Profile::default()
    }
}

/// Slip at which a track bears half of the weight's part along a slope: pressure grows linearly towards the lower end, as the moments
/// about the middle ask for; the force is summed over 20000 strips and the slip found by halving.
fn equilibrium(p: &CrawlerParameters, slope: f64) -> f64 {
    let (length, width) = (p.contact_length, p.track_width);
    let weight = p.mass * GRAVITY;
    let mean = 0.5 * weight * slope.cos() / (length * width);
    let centre = p.cog[0] - p.cog[2] * slope.tan();
    let strips = 20_000;
    let force = |slip: f64| -> f64 {
        (0..strips)
            .map(|strip| {
                let from_front = (f64::from(strip) + 0.5) / f64::from(strips) * length;
                let forward = 0.5 * length - from_front;
                let pressure = mean * (1.0 + 12.0 * centre * forward / (length * length));
                let strength = p.soil.cohesion + pressure * p.soil.friction_angle.tan();
                let u = p.soil.k1 * slip * from_front;
                strength * u * (1.0 - u).exp() * width * length / f64::from(strips)
            })
            .sum()
    };
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if force(middle) < 0.5 * weight * slope.sin() {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[test]
fn on_level_ground_without_load_the_robot_goes_as_fast_as_its_belts() {
    for speed in [0.15, -0.3] {
        let mut driven = Driven::new(&CrawlerParameters::nominal(), &Profile::default());
        driven.drive([speed; 2], 4.0);
        let truth = driven.plant.truth();
        assert!(
            (truth.ground_speed - speed).abs() < 1e-5,
            "{}",
            truth.ground_speed
        );
        assert!(
            truth.pitch.abs() < 1e-4 && truth.roll.abs() < 1e-4,
            "{truth:?}"
        );
    }
}

#[test]
fn slip_on_a_slope_solves_the_equilibrium_of_the_track() {
    for (degrees, speed) in [
        (20.0, 0.15),
        (20.0, 0.05),
        (10.0, 0.3),
        (25.0, 0.1),
        (-15.0, 0.15),
    ] {
        let p = CrawlerParameters::nominal();
        let mut driven = Driven::new(&p, &slope(degrees));
        driven.drive([speed; 2], 12.0);
        let slip = driven.plant.slip();
        // Downhill the ground holds back, and the rear of the track is the lower end no more.
        let want = if degrees > 0.0 {
            equilibrium(&p, degrees.to_radians())
        } else {
            let mirrored = equilibrium_downhill(&p, -degrees.to_radians());
            -mirrored
        };
        println!("{degrees} degrees at {speed} m/s: slip {slip:.5?}, equilibrium {want:.5}");
        for slip in slip {
            assert!(
                (slip - want).abs() < 0.002,
                "{degrees} {speed}: {slip} {want}"
            );
        }
    }
}

/// As [`equilibrium`], the lower end in front.
fn equilibrium_downhill(p: &CrawlerParameters, slope: f64) -> f64 {
    let mut mirrored = *p;
    mirrored.cog[0] = p.cog[0] + 2.0 * p.cog[2] * slope.tan();
    equilibrium(&mirrored, slope)
}

#[test]
fn a_parked_robot_stays_on_the_slope() {
    let mut driven = Driven::new(&CrawlerParameters::nominal(), &slope(20.0));
    driven.drive([0.0; 2], 3.0);
    let start = driven.plant.truth().cog;
    driven.drive([0.0; 2], 20.0);
    let end = driven.plant.truth().cog;
    let crept = (end[0] - start[0]).hypot(end[2] - start[2]);
    assert!(crept < 1e-4, "{crept}");
}

#[test]
fn a_dead_robot_holds_by_the_friction_of_its_gears() {
    let mut driven = Driven::new(&CrawlerParameters::nominal(), &slope(20.0));
    driven.drive([0.15; 2], 2.0);
    for _ in 0..3_000 {
        driven.plant.advance([None, None]);
    }
    assert!(driven.plant.truth().ground_speed.abs() < 1e-4);
    assert_eq!(driven.plant.truth().belt_speed, [0.0; 2]);
}

#[test]
fn shafts_carry_the_weight_s_part_along_the_slope() {
    let p = CrawlerParameters::nominal();
    let mut driven = Driven::new(&p, &slope(20.0));
    driven.drive([0.15; 2], 8.0);
    let torque: f64 = [0, 1]
        .map(|side| f64::from(driven.plant.sensors(side).shaft_torque))
        .iter()
        .sum();
    let want = p.mass * GRAVITY * 20f64.to_radians().sin() * p.sprocket_radius;
    assert!((torque - want).abs() < 2e-3 * want, "{torque} {want}");
}

#[test]
fn tracks_against_each_other_turn_the_robot_on_the_spot_slower_than_without_slip() {
    let p = CrawlerParameters::nominal();
    let mut driven = Driven::new(&p, &Profile::default());
    driven.drive([-0.05, 0.05], 3.0);
    let before = driven.plant.truth().yaw;
    driven.drive([-0.05, 0.05], 1.0);
    let rate = (driven.plant.truth().yaw - before + PI).rem_euclid(TAU) - PI;
    let without = 0.1 / p.track_spacing;
    println!("turns at {rate:.3} rad/s of {without:.3}");
    assert!(
        rate > 0.4 * without && rate < 0.98 * without,
        "{rate} of {without}"
    );
    let [x, y, _] = driven.plant.truth().cog;
    assert!(x.hypot(y) < 0.01, "{x} {y}");
}
