//! Tests of the watches, one tick after the other.

use super::*;
use crate::math::Turns;
use crate::motor::index::Finding;

const STALL: Stall = Stall {
    pushing: 9.0,
    standing: 0.06,
};

const GOOD: Readings = Readings {
    current: 1.0,
    demand: 1.0,
    supply_voltage: 24.0,
    velocity: 1.0,
    commanded_velocity: 1.0,
    following_error: Turns::ZERO,
    power: Power::On,
    motor: Findings {
        open_phase: false,
        disagrees: false,
        slipped: false,
    },
    misaligned: false,
    noisy: false,
    temperatures: Temperatures {
        bridge: None,
        motor: None,
    },
    electrical: Electrical {
        voltage: None,
        wrong_zero: false,
        wrong_sum: false,
        direct: 0.0,
        direct_size: 0.0,
        angle: None,
        ahead: None,
        index: Finding::Nothing,
        over_current: false,
        over_voltage: false,
        overrun: false,
    },
};

/// Bounds of 10 A and 6 rad/s, the default settings, with a following error of 400 units.
fn bounds() -> Bounds {
    Bounds {
        following: 400,
        ..Bounds::new(&Settings::default())
    }
}

fn ticks_until_fault(readings: Readings) -> Option<(usize, Faults)> {
    let (mut supervisor, bounds) = (Watches::default(), bounds());
    (1..500).find_map(|tick| {
        let faults = supervisor.check(&readings, &bounds, STALL);
        (!faults.is_empty()).then_some((tick, faults))
    })
}

#[test]
#[allow(clippy::too_many_lines)] // one case for each fault
fn each_bad_reading_raises_its_fault_after_its_dwell() {
    assert_eq!(ticks_until_fault(GOOD), None);
    let cases = [
        (
            Readings {
                current: f32::NAN,
                ..GOOD
            },
            3,
            Fault::InvalidReading,
        ),
        (
            Readings {
                current: -13.0,
                ..GOOD
            },
            5,
            Fault::OverCurrent,
        ),
        (
            Readings {
                velocity: -7.3,
                commanded_velocity: -7.3,
                ..GOOD
            },
            3,
            Fault::Overspeed,
        ),
        (
            Readings {
                supply_voltage: 33.0,
                ..GOOD
            },
            5,
            Fault::OverVoltage,
        ),
        (
            Readings {
                supply_voltage: 11.0,
                ..GOOD
            },
            5,
            Fault::UnderVoltage,
        ),
        (
            Readings {
                demand: -9.5,
                velocity: 0.0,
                ..GOOD
            },
            40,
            Fault::Blocked,
        ),
        (
            Readings {
                motor: Findings {
                    open_phase: true,
                    ..GOOD.motor
                },
                ..GOOD
            },
            8,
            Fault::OpenPhase,
        ),
        (
            Readings {
                motor: Findings {
                    disagrees: true,
                    ..GOOD.motor
                },
                ..GOOD
            },
            8,
            Fault::EncoderMismatch,
        ),
        (
            Readings {
                noisy: true,
                ..GOOD
            },
            1,
            Fault::EncoderNoise,
        ),
        (
            Readings {
                misaligned: true,
                ..GOOD
            },
            1,
            Fault::Misaligned,
        ),
        (
            Readings {
                electrical: Electrical {
                    overrun: true,
                    ..GOOD.electrical
                },
                ..GOOD
            },
            3,
            Fault::ControlOverrun,
        ),
        (
            Readings {
                electrical: Electrical {
                    over_current: true,
                    ..GOOD.electrical
                },
                ..GOOD
            },
            1,
            Fault::OverCurrent,
        ),
        (
            Readings {
                following_error: Turns::from_bits(-401),
                ..GOOD
            },
            100,
            Fault::FollowingError,
        ),
    ];
    for (readings, tick, fault) in cases {
        let expected = Some((tick, Faults::of(fault)));
        assert_eq!(ticks_until_fault(readings), expected);
    }
}

#[test]
fn a_condition_is_reported_beside_every_other_one() {
    let (mut supervisor, bounds) = (Watches::default(), bounds());
    let bad = Readings {
        current: 20.0,
        supply_voltage: 40.0,
        velocity: 0.0,
        demand: 10.0,
        following_error: Turns::from_bits(1_000),
        ..GOOD
    };
    let mut faults = Faults::NONE;
    for _ in 0..100 {
        faults = supervisor.check(&bad, &bounds, STALL);
    }
    for fault in [
        Fault::OverCurrent,
        Fault::OverVoltage,
        Fault::Blocked,
        Fault::FollowingError,
    ] {
        assert!(faults.contains(fault), "{fault:?} in {faults:?}");
    }
    assert_eq!(supervisor.check(&GOOD, &bounds, STALL), Faults::NONE);
}

/// Returns whether these velocities over time, with the current that acts, are a velocity
/// deviation.
fn deviates(commanded: f32, demand: f32, velocity: fn(f32) -> f32) -> bool {
    let (mut supervisor, bounds) = (Watches::default(), bounds());
    (0..60).any(|tick| {
        let now = Readings {
            velocity: velocity(tick as f32),
            commanded_velocity: commanded,
            demand,
            ..GOOD
        };
        supervisor
            .check(
                &now,
                &bounds,
                Stall {
                    pushing: 99.0,
                    ..STALL
                },
            )
            .contains(Fault::VelocityDeviation)
    })
}

#[test]
fn only_speed_gathered_against_the_current_is_a_deviation() {
    assert!(deviates(0.5, 10.0, |ms| -0.1 * ms), "a runaway");
    assert!(!deviates(0.0, -10.0, |ms| 6.0 - 0.1 * ms), "braking");
    assert!(
        !deviates(0.0, -10.0, |ms| 4.0 + 0.1 * (ms % 2.0)),
        "overpowered"
    );
    assert!(
        !deviates(0.0, 10.0, |ms| -2.0 - 1.5 * (0.3 * ms).sin()),
        "a blow, and the gear swings"
    );
    assert!(
        deviates(0.0, 10.0, |ms| {
            -(0.3 * ms).min(4.0) - 0.35 * (core::f32::consts::TAU * 0.05 * ms).sin()
        }),
        "a runaway whose speed ripples"
    );
    assert!(
        !deviates(6.0, 10.0, |ms| 0.1 * ms),
        "a start at the current limit"
    );
    assert!(!deviates(-6.0, -10.0, |ms| 3.0 - 0.1 * ms), "a reversal");
    assert!(!deviates(3.0, 10.0, |_| 0.0), "blocked");
    assert!(!deviates(3.0, -2.0, |ms| 0.1 * ms), "weakly braked");
}

#[test]
fn one_good_sample_starts_the_dwell_anew() {
    let (mut supervisor, bounds) = (Watches::default(), bounds());
    let bad = Readings {
        supply_voltage: 40.0,
        ..GOOD
    };
    for tick in 0..100 {
        let now = if tick % 4 == 3 { GOOD } else { bad };
        assert_eq!(supervisor.check(&now, &bounds, STALL), Faults::NONE);
    }
}

/// Returns the faults that these readings raise within the longest dwell.
fn faults_of(readings: Readings, bounds: &Bounds) -> Faults {
    let mut supervisor = Watches::default();
    (0..200).fold(Faults::NONE, |all, _| {
        all.or(supervisor.check(&readings, bounds, STALL))
    })
}

#[test]
fn a_reading_exactly_at_its_bound_raises_no_fault() {
    let bounds = Bounds {
        temperatures: [90.0, 120.0],
        ..bounds()
    };
    for sign in [1.0, -1.0] {
        let at_the_bounds = Readings {
            current: 12.5 * sign,
            velocity: bounds.overspeed * sign,
            commanded_velocity: bounds.overspeed * sign,
            supply_voltage: bounds.over_voltage,
            following_error: Turns::from_bits(400 * sign as i64),
            temperatures: Temperatures {
                bridge: Some(90.0),
                motor: Some(120.0),
            },
            ..GOOD
        };
        assert_eq!(faults_of(at_the_bounds, &bounds), Faults::NONE);
        let standing = Readings {
            supply_voltage: bounds.under_voltage,
            velocity: STALL.standing * sign,
            demand: 10.0 * sign,
            ..at_the_bounds
        };
        assert_eq!(faults_of(standing, &bounds), Faults::NONE);
        let pushing = Readings {
            velocity: 0.0,
            demand: STALL.pushing * sign,
            ..standing
        };
        assert_eq!(faults_of(pushing, &bounds), Faults::NONE);
    }
}

#[test]
fn a_sensor_that_must_be_there_is_watched_and_another_one_is_not() {
    let with = |bridge, motor| Readings {
        temperatures: Temperatures { bridge, motor },
        ..GOOD
    };
    let none = bounds();
    for motor in [None, Some(500.0), Some(f32::NAN), Some(f32::INFINITY)] {
        assert_eq!(faults_of(with(None, motor), &none), Faults::NONE);
        let both = Bounds {
            temperatures: [90.0, 120.0],
            ..none
        };
        let hot = Faults::of(Fault::OverTemperature);
        let invalid = Faults::of(Fault::InvalidReading);
        let expected = match motor {
            Some(500.0) => hot,
            Some(f32::INFINITY) => hot.or(invalid),
            _ => invalid,
        };
        assert_eq!(faults_of(with(Some(20.0), motor), &both), expected);
        assert_eq!(faults_of(with(motor, Some(20.0)), &both), expected);
    }
}

#[test]
fn a_reading_is_invalid_if_it_is_not_finite_however_large_it_is() {
    let bounds = bounds();
    for (current, supply_voltage, finite) in [
        (1e30, 1e30, true),
        (1.0, f32::INFINITY, false),
        (f32::INFINITY, 24.0, false),
        (f32::NEG_INFINITY, 24.0, false),
        (0.0, f32::NAN, false),
    ] {
        let readings = Readings {
            current,
            supply_voltage,
            ..GOOD
        };
        let faults = faults_of(readings, &bounds);
        assert_eq!(faults.contains(Fault::InvalidReading), !finite);
    }
}

#[test]
fn an_axle_that_moves_or_has_no_power_is_not_blocked() {
    let pushed = Readings {
        demand: 10.0,
        velocity: 0.0,
        ..GOOD
    };
    let bounds = bounds();
    assert!(faults_of(pushed, &bounds).contains(Fault::Blocked));
    let (mut moving, mut off) = (pushed, pushed);
    (moving.velocity, off.power) = (3.0, Power::Off);
    assert_eq!(faults_of(moving, &bounds), Faults::NONE);
    assert_eq!(faults_of(off, &bounds), Faults::NONE);
}

/// A blow throws the axle against its motor. The power at the bridge says whether the motor brakes
/// the axle or drives itself.
#[test]
fn an_axle_that_gives_energy_back_is_no_deviation() {
    for (voltage, current, direct, found) in [
        (None, 10.0, 0.0, true),
        (Some([0.0, -2.0]), 10.0, 0.0, false),
        (Some([0.0, 2.0]), 10.0, 0.0, true),
        (Some([0.0, 0.0]), 10.0, 0.0, true),
        (Some([-5.0, 2.0]), 10.0, 5.0, false),
        (Some([-3.0, 2.0]), 10.0, 5.0, true),
    ] {
        let (mut supervisor, bounds) = (Watches::default(), bounds());
        let fault = (0..60).any(|tick| {
            let now = Readings {
                velocity: -(0.5 * tick as f32).min(4.0),
                commanded_velocity: 0.0,
                demand: 10.0,
                current,
                electrical: Electrical {
                    voltage,
                    direct,
                    ..GOOD.electrical
                },
                ..GOOD
            };
            let faults = supervisor.check(&now, &bounds, STALL);
            faults.contains(Fault::VelocityDeviation)
        });
        assert_eq!(fault, found, "{voltage:?}");
    }
}

/// A deviation is a fifth of the velocity limit of 6 rad/s, against more than half of 10 A.
#[test]
fn a_little_speed_against_a_small_current_is_no_deviation() {
    assert!(deviates(2.0, 10.0, |ms| -0.05 * ms), "past the deviation");
    let slow = |ms: f32| -(0.05 * ms).min(1.15);
    assert!(!deviates(2.0, 10.0, slow), "less speed than a deviation");
    assert!(!deviates(2.0, 5.0, |ms| -0.05 * ms), "half of the current");
}

/// The speed at first falls against the current, as when the motor brakes, and then rises.
#[test]
fn a_runaway_counts_from_the_slowest_speed() {
    assert!(deviates(0.0, 10.0, |ms| -2.0 - 0.1 * (ms - 20.0).abs()));
    assert!(!deviates(0.0, 10.0, |ms| -2.0 - 0.05 * (ms - 20.0).abs().min(20.0)));
}

#[test]
fn a_speed_exactly_a_deviation_above_the_slowest_or_from_the_set_point_is_none() {
    let above_the_slowest = |ms: f32| if ms < 1.0 { 0.0 } else { -bounds().deviation };
    assert!(!deviates(0.5, 10.0, above_the_slowest));
    // At the bound the axle still follows its set-point, so that this speed is the slowest.
    let from_the_set_point = |ms: f32| -bounds().deviation * [0.0, 1.0, 1.5][ms.min(2.0) as usize];
    assert!(!deviates(0.0, 10.0, from_the_set_point));
}

#[test]
fn braking_after_a_run_is_no_deviation() {
    let (mut supervisor, bounds) = (Watches::default(), bounds());
    let mut now = GOOD;
    for tick in 0..120 {
        let ms = tick as f32;
        (now.velocity, now.commanded_velocity, now.demand) = if tick < 60 {
            (0.1 * ms, 6.0, 5.0)
        } else {
            (6.0 - 0.05 * (ms - 60.0), 0.0, -8.0)
        };
        assert_eq!(supervisor.check(&now, &bounds, STALL), Faults::NONE);
    }
}
