//! Tests the plane against the ellipsoid, and which fixes a position believes.

use crate::ellipsoid::{ANGERS, geodetic};
use crate::tilted;
use std::f64::consts::PI;
use tautrack::estimate::nmea::{Gga, Place, Rmc, Sentence};
use tautrack::estimate::position::{
    DILUTION_LIMIT, FIRST_FIXES, Fix, GATE, JUMP_FIXES, LEAST_GAIN, Plane, Position, Verdict,
};
use tautrack::units::Angle;

#[test]
fn the_plane_keeps_its_error_against_the_ellipsoid() {
    for (latitude, longitude) in [
        (47.48, -0.56),
        (-33.9, 151.2),
        (0.0, 179.9999),
        (65.0, 25.0),
        (-65.0, -180.0),
    ] {
        let site = [latitude, longitude, 0.0];
        let place = |metres: [f64; 3]| {
            let [latitude, longitude, _] = geodetic(site, metres);
            Place {
                latitude: (latitude * 1e7).round() as i32,
                longitude: (longitude * 1e7).round() as i32,
            }
        };
        let plane = Plane::new(place([0.0; 3]));
        for (reach, bound) in [(100.0, 0.015), (1_000.0, 0.38)] {
            for step in 0..64 {
                let turn = f64::from(step) / 32.0 * PI;
                let scale = reach / turn.cos().abs().max(turn.sin().abs());
                let (north, west) = (scale * turn.cos(), scale * turn.sin());
                let [got_north, got_east] = plane.metres(place([north, west, 0.0])).map(f64::from);
                let error = (got_north - north).hypot(got_east + west);
                assert!(error <= bound, "{latitude}, {reach} m, {turn}: {error} m");
            }
        }
    }
}

/// Returns a fix at this distance (north, east, up; m) from a site, and its time, us. There are
/// five fixes per second.
fn fix(number: u32, [north, east, up]: [f64; 3]) -> (Fix, u64) {
    let [latitude, longitude, height] = geodetic(ANGERS, [north, -east, up]);
    let fix = Fix {
        time_ms: number * 200,
        place: Place {
            latitude: (latitude * 1e7).round() as i32,
            longitude: (longitude * 1e7).round() as i32,
        },
        altitude_mm: Some((height * 1e3).round() as i32),
    };
    (fix, u64::from(number) * 200_000)
}

#[test]
fn a_position_begins_with_three_fixes_that_agree() {
    let mut position = Position::new(0.45);
    for (number, north) in [(1, 0.0), (2, 5_000.0), (3, 0.0), (4, 1.0)] {
        let (fix, now) = fix(number, [north, 0.0, 0.0]);
        assert_eq!(position.fix(&fix, now), Verdict::Doubted);
        assert_eq!((position.fixed_us(), position.origin()), ([None; 2], None));
    }
    assert_eq!(FIRST_FIXES, 3);
    let (fix, now) = fix(5, [2.0, -1.0, 0.5]);
    assert_eq!(position.fix(&fix, now), Verdict::Believed);
    assert_eq!(position.fix(&fix, now), Verdict::Known);
    let metres = position.metres();
    for (got, expected) in metres.iter().zip([2.0, -1.0, 0.5]) {
        assert!((got - expected).abs() < 0.02, "{metres:?}");
    }
}

#[test]
fn a_jump_is_believed_only_after_ten_fixes_that_agree_with_each_other() {
    let mut position = Position::new(0.45);
    let mut take = |number: u32, north: f64| {
        let (fix, now) = fix(number, [north, 0.0, 0.0]);
        (position.fix(&fix, now), position.metres()[0])
    };
    for number in 1..=20 {
        take(number, 0.0);
    }
    // Fixes that alternate between two places never agree.
    for number in 21..=60 {
        let (verdict, north) = take(number, if number % 2 == 0 { 60.0 } else { -60.0 });
        assert!(verdict == Verdict::Doubted && north.abs() < 0.01, "{north}");
    }
    for number in 61..61 + JUMP_FIXES - 1 {
        let (verdict, north) = take(number, 200.0);
        assert!(verdict == Verdict::Doubted && north.abs() < 0.01, "{north}");
    }
    let (verdict, north) = take(61 + JUMP_FIXES, 200.0);
    assert!(
        verdict == Verdict::Believed && (north - 200.0).abs() < 0.05,
        "{north}"
    );
    // Within the gate, a fix moves the estimate by no more than its gain.
    let (_, north) = take(62 + JUMP_FIXES, 200.0 + f64::from(GATE) - 1.0);
    assert!(
        (north - 204.5).abs() < 0.05,
        "the second one's gain is a half: {north}"
    );
}

#[test]
fn settled_the_gain_is_one_part_in_a_hundred() {
    let mut position = Position::new(0.45);
    for number in 1..=LEAST_GAIN + 50 {
        let (fix, now) = fix(number, [0.0; 3]);
        position.fix(&fix, now);
    }
    let before = position.metres()[1];
    let (fix, now) = fix(LEAST_GAIN + 51, [0.0, 5.0, 0.0]);
    position.fix(&fix, now);
    let step = position.metres()[1] - before;
    assert!((step - 0.05).abs() < 2e-4, "{step}");
}

#[test]
fn small_steps_add_up_far_from_the_origin() {
    let mut position = Position::new(0.45);
    for number in 1..=3 {
        let (fix, now) = fix(number, [0.0; 3]);
        position.fix(&fix, now);
    }
    let axes = tilted(0.1, 0.6).level_axes();
    let heading = Angle::from_degrees(150.0);
    // 3 km in steps of 0.52 mm, nose up by 0.6 rad.
    let steps = 5_769_231_u32;
    for _ in 0..steps {
        position.advance(520, heading, &axes);
    }
    let way = f64::from(steps) * 520e-6;
    let (forward, left, up) = (
        way * 0.6_f64.cos(),
        -way * 0.6_f64.sin() * 0.1_f64.sin(),
        way * 0.6_f64.sin() * 0.1_f64.cos(),
    );
    let (sine, cosine) = 150.0_f64.to_radians().sin_cos();
    let expected = [
        forward * cosine - left * sine,
        -(forward * sine + left * cosine),
        up,
    ];
    for (got, expected) in position.metres().iter().zip(expected) {
        assert!(
            (f64::from(*got) - expected).abs() < 0.02,
            "{got} {expected}"
        );
    }
}

/// A position that has settled at the origin.
fn settled() -> Position {
    let mut position = Position::new(0.45);
    for number in 1..=20 {
        let (fix, now) = fix(number, [0.0; 3]);
        position.fix(&fix, now);
    }
    position
}

/// Ten seconds after the last fix, a robot of 0.45 m/s may be 14.5 m away. Heights count half.
#[test]
fn a_fix_is_believed_where_the_robot_can_be() {
    for (metres, verdict) in [
        ([14.3, 0.0, 0.0], Verdict::Believed),
        ([14.7, 0.0, 0.0], Verdict::Doubted),
        ([0.0, -14.3, 0.0], Verdict::Believed),
        ([0.0, 14.7, 0.0], Verdict::Doubted),
        ([0.0, 0.0, 28.6], Verdict::Believed),
        ([0.0, 0.0, -29.4], Verdict::Doubted),
        ([10.0, 10.0, 0.0], Verdict::Believed),
        ([-10.5, 10.5, 0.0], Verdict::Doubted),
        ([10.0, 0.0, 20.0], Verdict::Believed),
        ([0.0, 10.5, 21.0], Verdict::Doubted),
    ] {
        let (fix, now) = fix(70, metres);
        assert_eq!(settled().fix(&fix, now), verdict, "{metres:?}");
    }
}

#[test]
fn a_fix_without_a_height_moves_north_and_east_alone() {
    let mut position = settled();
    let (mut fix, now) = fix(21, [2.1, -4.2, 6.0]);
    fix.altitude_mm = None;
    assert_eq!(position.fix(&fix, now), Verdict::Believed);
    let [north, east, up] = position.metres();
    // The 18 fixes before weigh as much each: the first two were not believed.
    let share = 1.0 / 19.0;
    assert!((north - 2.1 * share).abs() < 2e-3 && (east + 4.2 * share).abs() < 2e-3);
    assert_eq!(up, settled().metres()[2]);
    assert_eq!(position.fixed_us(), [Some(now), Some(4_000_000)]);
}

#[test]
fn a_position_tells_its_origin_and_how_many_fixes_it_believed() {
    let position = settled();
    let (first, _) = fix(1, [0.0; 3]);
    assert_eq!(position.origin(), Some((first.place, first.altitude_mm)));
    assert_eq!(position.counts(), [18, 2]);
}

/// Dead reckoning to every side, with the nose up and the body rolled.
#[test]
fn belts_move_the_position_along_the_forward_axis() {
    for [heading, roll, pitch] in [[0.0, 0.0, 0.0_f64], [2.0, 0.2, 0.6], [-1.2, -0.4, -0.3]] {
        let mut position = settled();
        let before = position.metres();
        let angle = Angle::from_radians(heading as f32);
        position.advance(2_000_000, angle, &tilted(roll, pitch).level_axes());
        // The forward axis: pitched up, then rolled about the heading, then turned.
        let (ahead, raised) = (pitch.cos(), pitch.sin());
        let (left, up) = (-raised * roll.sin(), raised * roll.cos());
        let exact = [
            ahead * heading.cos() - left * heading.sin(),
            -(ahead * heading.sin() + left * heading.cos()),
            up,
        ];
        for axis in 0..3 {
            let step = f64::from(position.metres()[axis] - before[axis]);
            assert!(
                (step - 2.0 * exact[axis]).abs() < 1e-4,
                "{heading} {axis}: {step}"
            );
        }
    }
}

#[test]
fn a_sentence_is_a_fix_if_the_receiver_says_that_it_is_good() {
    let place = Some(Place::default());
    let good = Gga {
        time_ms: Some(200),
        place,
        altitude_mm: Some(3_000),
        quality: 1,
        satellites: Some(8),
        dilution: Some(DILUTION_LIMIT),
    };
    let taken = |gga| Fix::from_sentence(&Sentence::Gga(gga));
    for quality in 0..=8 {
        let fix = taken(Gga { quality, ..good });
        assert_eq!(fix.is_some(), (1..=5).contains(&quality), "{quality}");
    }
    let fix = taken(good).expect("a fix");
    assert_eq!((fix.time_ms, fix.altitude_mm), (200, Some(3_000)));
    for dilution in [None, Some(DILUTION_LIMIT + 1)] {
        assert_eq!(taken(Gga { dilution, ..good }), None);
    }
    let rmc = Rmc {
        time_ms: Some(200),
        place,
        ..Rmc::default()
    };
    let fix = Fix::from_sentence(&Sentence::Rmc(rmc)).expect("a fix");
    assert_eq!((fix.time_ms, fix.altitude_mm), (200, None));
    let void = Rmc { place: None, ..rmc };
    assert_eq!(Fix::from_sentence(&Sentence::Rmc(void)), None);
}
