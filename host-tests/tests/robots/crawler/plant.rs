//! Tests of the crawler's plant against equilibrium and hand calculation.

use crate::crawler::driven::{Driven, loaded, slope};
use core::f64::consts::{PI, TAU};
use tautrack_host_tests::robots::crawler::plant::{Crawler, CrawlerParameters, Profile};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::load::Load;

const GRAVITY: f64 = 9.81;

/// Slip at which a track carries half of the weight's component along a slope. The pressure grows
/// linearly towards the lower end, as the moments about the middle require. The force is summed
/// over 20000 strips, and the slip is found by bisection.
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
        // Downhill, the ground brakes the robot, and the lower end of the track is its front.
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

/// Slip like that of [`equilibrium`], with the lower end in front.
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

#[test]
fn the_same_drive_ends_in_the_same_bits_and_another_seed_does_not() {
    let bits = |seed| {
        let p = CrawlerParameters::nominal();
        let mut driven = Driven::new(&p, &slope(15.0));
        driven.plant = Crawler::new(&p, &slope(15.0), seed);
        driven.drive([0.2, 0.1], 1.0);
        let mut bits = Vec::new();
        driven
            .plant
            .truth_bits(&mut |bytes| bits.extend_from_slice(bytes));
        bits
    };
    assert_eq!(bits(1), bits(1));
    assert_ne!(bits(1), bits(2));
}

#[test]
fn a_load_put_on_later_weighs_and_sinks_no_robot_off_its_place() {
    let mut p = loaded(2.0, 0.25);
    p.payload = p.payload.map(|payload| Load {
        from_time_s: 1.0,
        ..payload
    });
    let mut driven = Driven::new(&p, &Profile::default());
    driven.drive([0.0; 2], 0.9);
    let before = driven.plant.truth().cog;
    driven.drive([0.0; 2], 2.0);
    let after = driven.plant.truth().cog;
    let height = (5.0 * 0.045 + 2.0 * 0.25) / 7.0;
    assert!((before[2] - 0.045).abs() < 2e-4, "{before:?}");
    assert!((after[2] - height).abs() < 2e-4, "{after:?} {height}");
    assert!(after[0].hypot(after[1]) < 1e-4, "{after:?}");
}
