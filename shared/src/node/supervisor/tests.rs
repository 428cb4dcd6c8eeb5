//! Tests of the watches, one tick after the other.

use super::*;

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
    following_error: 0,
    powered: true,
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
        direct: 0.0,
        direct_size: 0.0,
        angle: None,
        ahead: None,
        over_current: false,
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
    let (mut supervisor, bounds) = (Supervisor::default(), bounds());
    (1..500).find_map(|tick| {
        let faults = supervisor.check(&readings, &bounds, STALL);
        (!faults.is_empty()).then_some((tick, faults))
    })
}

#[test]
fn the_watches_are_the_first_faults_of_the_table() {
    for ((fault, _), other) in WATCHES.iter().zip(crate::faults::ALL) {
        assert_eq!(fault, other);
    }
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
                following_error: -401,
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
    let (mut supervisor, bounds) = (Supervisor::default(), bounds());
    let bad = Readings {
        current: 20.0,
        supply_voltage: 40.0,
        velocity: 0.0,
        demand: 10.0,
        following_error: 1_000,
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
    let (mut supervisor, bounds) = (Supervisor::default(), bounds());
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
        !deviates(6.0, 10.0, |ms| 0.1 * ms),
        "a start at the current limit"
    );
    assert!(!deviates(-6.0, -10.0, |ms| 3.0 - 0.1 * ms), "a reversal");
    assert!(!deviates(3.0, 10.0, |_| 0.0), "blocked");
    assert!(!deviates(3.0, -2.0, |ms| 0.1 * ms), "weakly braked");
}

#[test]
fn one_good_sample_starts_the_dwell_anew() {
    let (mut supervisor, bounds) = (Supervisor::default(), bounds());
    let bad = Readings {
        supply_voltage: 40.0,
        ..GOOD
    };
    for tick in 0..100 {
        let now = if tick % 4 == 3 { GOOD } else { bad };
        assert_eq!(supervisor.check(&now, &bounds, STALL), Faults::NONE);
    }
}
