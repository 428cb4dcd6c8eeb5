//! Tests the limits of acceleration and yaw, and the fall off a step, against double precision.

use crate::random::Random;
use tautrack::constants::GRAVITY;
use tautrack::settings::Settings;
use tautrack::stability::diagonal::loss;
use tautrack::stability::evaluation::Evaluation;
use tautrack::stability::limits::{LEAST_SHARE, MotionLimits};
use tautrack::stability::parameters::{Parameters, Uncertainty};
use tautrack::stability::step_behind::{StepBehind, room, speed};
use tautrack::stability::support::Stance;

const WIDENING: f32 = 0.02;

fn parameters() -> Parameters {
    Parameters {
        uncertainty: Uncertainty {
            cog: WIDENING,
            mass: 0.0,
            reach: 0.0,
            robot_mass: 20.0,
            attitude: 0.0,
        },
        acceleration: 2.0,
        braking: 3.0,
        ..Parameters::new(&Settings::default())
    }
}

fn directions(limits: &MotionLimits) -> [f32; 4] {
    [limits.forward, limits.backward, limits.left, limits.right]
}

#[test]
fn without_margins_the_limits_are_those_of_the_settings() {
    let limits = MotionLimits::unlimited(&parameters());
    assert_eq!(directions(&limits), [3.0, 3.0, 2.0, 2.0]);
    assert_eq!(limits.posture, 1.0);
}

/// An acceleration shifts every margin by its lever, which is uncertain. A limit that is neither at
/// its minimum nor at its maximum uses up the first margin exactly.
#[test]
fn an_acceleration_at_its_limit_leaves_the_trip_margin() {
    let mut random = Random(9);
    let parameters = parameters();
    let mut exact = [0; 4];
    for _ in 0..500 {
        // A small robot, or one five times as large.
        let size = if random.next() > 0.0 { 1.0 } else { 5.0 };
        let gravity = [0; 4].map(|_| size * (0.15 + 0.1 * random.next()) as f32);
        let levers = [[0; 2]; 4].map(|lever| lever.map(|_| size * 0.4 * random.next() as f32));
        let found = Evaluation {
            gravity,
            levers,
            ..Evaluation::default()
        };
        let limits = directions(&MotionLimits::of(&found, &parameters));
        for (direction, limit) in limits.into_iter().enumerate() {
            let (axis, sign) = (direction / 2, [1.0, -1.0][direction % 2]);
            let (least, most) = [(LEAST_SHARE * 2.0, 3.0), (0.0, 2.0)][axis];
            assert!((least..=most).contains(&limit), "{direction}: {limit}");
            let left = |acceleration: f64| {
                let after = gravity.iter().zip(levers).filter_map(|(margin, lever)| {
                    let lever = f64::from(lever[axis]) * sign;
                    let cost = -lever + f64::from(WIDENING);
                    let after = f64::from(*margin) - acceleration / f64::from(GRAVITY) * cost;
                    (lever < 0.0).then_some(after)
                });
                after.fold(f64::INFINITY, f64::min) - f64::from(parameters.trip)
            };
            let room = left(f64::from(limit));
            assert!(limit == least || room > -1e-5, "{direction}: {room}");
            if limit > least && limit < most {
                assert!(room < 1e-5, "{direction}: {room}");
                exact[direction] += 1;
            }
        }
    }
    assert!(exact.iter().all(|count| *count > 20), "{exact:?}");
}

/// Forward and to the left, forward and to the right, then the same backward.
#[test]
fn a_turn_is_limited_on_the_side_toward_which_it_accelerates() {
    let limits = MotionLimits {
        forward: 1.0,
        backward: 1.0,
        left: 0.5,
        right: 0.2,
        posture: 1.0,
    };
    for (speed, yaw_rate, bearable) in [
        (2.0, 1.0, 0.5),
        (2.0, -1.0, 0.2),
        (-2.0, -1.0, 0.5),
        (-2.0, 1.0, 0.2),
    ] {
        let passed: f32 = limits.yaw_rate(yaw_rate, speed);
        let expected = yaw_rate * bearable / 2.0;
        assert!(
            (passed - expected).abs() < 1e-3,
            "{speed} {yaw_rate}: {passed}"
        );
    }
    assert_eq!(limits.yaw_rate(0.1, 0.2), 0.1);
    assert_eq!(limits.yaw_rate(f32::NAN, 0.2), 0.0);
}

/// Energies by the angles of the body, in double precision.
fn expected_room(slope: f64, ahead: f64, up: f64, step: f64, gyration: f64) -> f64 {
    let over_nose = up - ahead * slope.tan();
    let turn = (step * slope.cos() / ahead).min(1.0).asin() - slope;
    let length = ahead.hypot(up);
    let bears = length - over_nose * turn.cos() - step;
    let about_nose = over_nose * over_nose + gyration;
    // What is left of an energy when the rear meets the ground.
    let left = (over_nose * up + gyration).powi(2) / (about_nose * (length * length + gyration));
    let sunk = over_nose * (1.0 - turn.cos());
    (bears / left - sunk) * about_nose / over_nose.powi(2)
}

#[test]
fn the_room_of_a_fall_off_a_step_is_its_balance_of_energies() {
    let mut count = 0;
    for slope in [0.0, 0.3, 0.6_f64] {
        for (ahead, up) in [(0.12, 0.25), (0.2, 0.3), (0.3, 0.35), (0.1, 0.12)] {
            for step in [0.05, 0.1, 0.15] {
                for (gyration, deduction) in [(0.053, 0.0), (0.02, 0.0), (0.053, 0.015)] {
                    let front = [0.6 * slope.cos(), 0.6 * slope.sin()].map(|x| x as f32);
                    // Not at the origin.
                    let (x, z) = (0.4, -0.3);
                    let contacts = [
                        [x, -0.2, z],
                        [x + front[0], -0.2, z + front[1]],
                        [x + front[0], 0.2, z + front[1]],
                        [x, 0.2, z],
                    ];
                    let cog = [x + ahead as f32, 0.0, z + up as f32];
                    let stance = Stance::on(contacts, cog);
                    let behind = StepBehind {
                        height: step as f32,
                        gyration: gyration as f32,
                    };
                    let got = f64::from(room(&stance, &behind, deduction as f32));
                    let (ahead, up) = (ahead - deduction, up + deduction);
                    let case = (slope, ahead, up, step, gyration);
                    let under_nose = up - ahead * slope.tan() < 1e-3;
                    if under_nose || step * slope.cos() / ahead <= slope.sin() {
                        assert_eq!(got, f64::INFINITY, "{case:?}");
                        continue;
                    }
                    let expected = expected_room(slope, ahead, up, step, gyration);
                    assert!((got - expected).abs() < 1e-4, "{case:?}: {got} {expected}");
                    count += 1;
                }
            }
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn the_speed_of_a_height_is_that_of_a_free_fall() {
    // 0.05 m take 0.101 s.
    let time = f64::sqrt(2.0 * 0.05 / f64::from(GRAVITY));
    let expected = f64::from(GRAVITY) * time;
    assert!((f64::from(speed(0.05)) - expected).abs() < 1e-6);
    assert_eq!([speed(0.0), speed(-0.1), speed(f32::NAN)], [0.0; 3]);
}

#[test]
fn the_fall_over_a_diagonal_does_not_depend_on_the_origin() {
    let contacts = [
        [0.0, -0.2, 0.0],
        [0.6, -0.2, 0.05],
        [0.6, 0.2, 0.1],
        [0.0, 0.2, 0.04],
    ];
    let lost = |origin: [f32; 3]| {
        let moved = |point: [f32; 3]| [0, 1, 2].map(|axis| point[axis] + origin[axis]);
        loss(&Stance::on(contacts.map(moved), moved([0.25, 0.02, 0.3])))
    };
    let expected = lost([0.0; 3]);
    assert!(expected > 0.0);
    for origin in [[0.5, 0.0, 0.0], [-0.7, 0.3, 0.0], [0.0, -0.4, 0.6]] {
        assert!((lost(origin) - expected).abs() < 1e-5, "{origin:?}");
    }
}
