//! Tests of the set-point of the screw, compared with the triangle of the axles in double
//! precision.

use super::*;
use crate::bus::cia402::{controlword, mode};
use crate::math::Turns;
use crate::motor::current::Electrical;
use crate::node::axle::SetPoint;
use crate::sensors::{Switches, Temperatures};
use core::f64::consts::{PI, TAU};

const TURN: f64 = 4_294_967_296.0;
/// Lengths L1, L2 and K of the default settings, and the lead of the screw, m.
const L1: f64 = 0.32;
const L2: f64 = 0.23;
const K: f64 = 1.232;
const LEAD: f64 = 5e-3;
/// The screw's length is compared to within this, m.
const TOLERANCE: f64 = 1e-6;
/// Distance that the engage speed makes in a tick, m; as slack, in whole units of 2^-24 m.
const ENGAGED: f64 = 20e-6;
const SLACKENED: f64 = 335.0 / 16_777_216.0;

fn inputs(joint: Option<(f64, f64)>) -> Inputs {
    Inputs {
        axle: AxleInputs {
            now_us: 0,
            encoder: 0,
            encoder_broken: false,
            bridge_stop: None,
            current: 0.0,
            electrical: Electrical::default(),
            supply_voltage: 24.0,
            temperatures: Temperatures::default(),
            switches: Switches::default(),
            set_point: None,
            torque_offset: None,
            guard_received: false,
            bench_mode: true,
        },
        joint: joint.map(|(angle, rate)| {
            let position = (angle / TAU * TURN) as i64 as i32;
            let velocity = (rate * 1e6) as i32;
            (DriveMotion { position, velocity }, 0)
        }),
    }
}

/// Creates a screw of which the current loop is on, in mode `TAUT`, while the joint is at `angle`.
/// Before that, something turns the shaft by `turns`, with half a turn a second.
fn driving(turns: i32, angle: f64) -> Screw {
    let mut settings = Settings::default();
    // At power-up the shaft is at position 0, and homed.
    for (setting, value) in [(Setting::HomingDirection, 0), (Setting::JointTimeout, 24)] {
        settings.set(setting.description().key, value).unwrap();
    }
    let mut screw = Screw::new(&settings).unwrap();
    let mut now = inputs(Some((angle, 0.0)));
    let counts = settings.get(Setting::EncoderCounts) * (settings.get(Setting::GearRatio) / 1_000);
    let step = counts / 2_000;
    let mut tick = |screw: &mut Screw, command: Option<u16>| {
        now.axle.now_us += 1_000;
        if now.axle.encoder < turns * counts {
            now.axle.encoder += step;
        }
        now.joint = now.joint.map(|(motion, _)| (motion, now.axle.now_us));
        now.axle.set_point = command.map(|controlword| SetPoint {
            controlword,
            mode: mode::TAUT,
            target: 0,
        });
        screw.tick(&now);
    };
    for _ in 0..2_100 * turns + 500 {
        tick(&mut screw, None);
    }
    for word in [
        controlword::SHUTDOWN,
        controlword::SWITCH_ON,
        controlword::ENABLE_OPERATION,
    ] {
        assert!(!screw.axle.follows_joint());
        tick(&mut screw, Some(word));
    }
    assert!(screw.axle.follows_joint() && screw.axle.is_free());
    screw
}

/// Commands a slack, 2^-24 m, in mode `RELEASED`, or mode `TAUT` with a target that it ignores.
fn command(screw: &mut Screw, slack: Option<i32>) {
    let mut now = inputs(None);
    now.axle.set_point = Some(SetPoint {
        controlword: controlword::ENABLE_OPERATION,
        mode: if slack.is_some() {
            mode::RELEASED
        } else {
            mode::TAUT
        },
        target: slack.unwrap_or(1_000_000),
    });
    screw.tick(&now);
    assert!(screw.axle.follows_joint() && screw.axle.is_free());
}

/// Slack in bus units.
fn units(metres: f64) -> i32 {
    (metres * 16_777_216.0) as i32
}

fn set_point(screw: &mut Screw, now: &Inputs) -> Motion {
    screw.follow(now).unwrap()
}

/// Sends one motion of the joint, and returns the set-point when the belt is engaged.
fn engaged(screw: &mut Screw, joint: (f64, f64), age_us: u64) -> Motion {
    let mut now = inputs(Some(joint));
    now.axle.now_us = age_us;
    screw.joint = now.joint;
    // The joint has not moved there: this step is refused.
    let _ = screw.follow(&now);
    (0..60_000).map(|_| set_point(screw, &now)).last().unwrap()
}

fn metres_of(motion: Motion) -> f64 {
    motion.position.to_bits() as f64 / TURN * LEAD
}

/// Extension at which the belt has this slack: the distance of axles 1 and 3, by the law of
/// cosines, and the front are shorter by the slack than `K`. Found by bisection.
fn extension(theta: f64, slack: f64) -> f64 {
    let (mut low, mut high) = (0.0, K);
    for _ in 0..60 {
        let r = 0.5 * (low + high);
        let distance = (L1 * L1 + r * r + 2.0 * L1 * r * libm::cos(theta)).max(0.0);
        if libm::sqrt(distance) + r > K - slack {
            high = r;
        } else {
            low = r;
        }
    }
    low - L2
}

fn released() -> f64 {
    0.5 * (K - L1) - L2
}

#[test]
fn the_set_point_is_the_taut_length_at_the_joint_angle_of_now() {
    let mut screw = driving(0, 1.0);
    for theta in [-3.0, -1.2, -0.05, 0.03, 0.3, 2.0, 3.0] {
        for rate in [-2.0, -0.3, 0.0, 0.5, 2.0] {
            for age_us in [0, 4_000, 24_000] {
                let motion = engaged(&mut screw, (theta, rate), age_us);
                let now = theta + rate * age_us as f64 * 1e-6;
                let speed = (extension(now + 1e-4, 0.0) - extension(now - 1e-4, 0.0)) / 2e-4 * rate;
                // An inward motion ends early by 10 ms of its speed.
                let end = released() - 10e-3 * speed.min(0.0);
                let taut = extension(now, 0.0);
                let case = (theta, rate, age_us, metres_of(motion), taut, end);
                assert!(
                    (metres_of(motion) - taut.max(end)).abs() < TOLERANCE,
                    "{case:?}"
                );
                if (taut - end).abs() > 1e-6 {
                    let speed = if taut < end { 0.0 } else { speed };
                    let shaft = speed / LEAD * TAU;
                    assert!(
                        (f64::from(motion.velocity) - shaft).abs() < 1e-3 + 1e-4 * shaft.abs(),
                        "{case:?} {} {shaft}",
                        motion.velocity
                    );
                }
            }
        }
    }
}

#[test]
fn a_motion_of_the_joint_counts_until_its_timeout_and_no_longer() {
    let mut screw = driving(0, 1.0);
    let mut now = inputs(Some((1.0, 0.0)));
    screw.joint = now.joint;
    now.axle.now_us = 24_000;
    assert!(screw.follow(&now).is_ok());
    now.axle.now_us += 1;
    assert_eq!(screw.follow(&now).err(), Some(Fault::JointLost));
    screw.joint = None;
    assert_eq!(screw.follow(&now).err(), Some(Fault::JointLost));
}

/// The joint is silent. The screw runs to a velocity, or is off.
#[test]
fn only_a_screw_that_follows_the_law_of_the_belt_needs_the_joint() {
    for (mode, controlword, needed) in [
        (mode::TAUT, controlword::ENABLE_OPERATION, true),
        (mode::RELEASED, controlword::ENABLE_OPERATION, true),
        (mode::CYCLIC_VELOCITY, controlword::ENABLE_OPERATION, false),
        (mode::TAUT, controlword::DISABLE_VOLTAGE, false),
    ] {
        let mut screw = driving(0, 1.0);
        let mut now = inputs(None);
        now.axle.now_us = 1_000_000;
        now.axle.set_point = Some(SetPoint {
            controlword,
            mode,
            target: 0,
        });
        screw.joint = inputs(Some((1.0, 0.0)))
            .joint
            .map(|(motion, _)| (motion, 1_000_000));
        let lost = (0..30).any(|_| {
            now.axle.now_us += 1_000;
            screw.tick(&now).faults.contains(Fault::JointLost)
        });
        assert_eq!(lost, needed, "{mode} {controlword}");
    }
}

/// From below and from above, to an extension that is not a whole number of ticks away.
#[test]
fn the_belt_is_engaged_at_the_engage_speed_from_where_the_shaft_is() {
    for (turns, joint) in [(0, 1.0), (50, 0.3)] {
        let mut screw = driving(turns, joint);
        let now = inputs(Some((joint, 0.0)));
        screw.joint = now.joint;
        let (start, taut) = (
            screw.axle.position().to_bits() as f64 / TURN * LEAD,
            extension(joint, 0.0),
        );
        let direction = (taut - start).signum();
        assert_eq!(direction > 0.0, turns == 0);
        let ticks = ((taut - start).abs() / ENGAGED) as usize;
        for tick in 1..=ticks + 10 {
            let at = metres_of(set_point(&mut screw, &now));
            let expected = if tick <= ticks {
                start + direction * tick as f64 * ENGAGED
            } else {
                taut
            };
            assert!(
                (at - expected).abs() < 2.0 * TOLERANCE,
                "{turns} turns, tick {tick}: {at} {expected}"
            );
        }
        assert_eq!(screw.remaining, Turns::ZERO);
    }
}

#[test]
fn while_it_does_not_drive_the_set_point_is_where_the_shaft_is() {
    let mut screw = Screw::new(&Settings::default()).unwrap();
    screw.joint = inputs(Some((1.0, 0.5))).joint;
    for _ in 0..3 {
        let motion = set_point(&mut screw, &inputs(None));
        assert_eq!(motion.position, screw.axle.position());
    }
}

/// Lets the settings allow every slack that the bus can carry.
fn unlimited(screw: &mut Screw) {
    screw.slack_limit = i32::MAX;
}

#[test]
fn a_commanded_slack_is_the_slack_of_the_belt() {
    let mut screw = driving(0, 1.0);
    unlimited(&mut screw);
    for theta in [0.5, 1.0, 1.8, 3.0] {
        for slack in [0.001, 0.01, 0.1, 0.3, 0.44] {
            command(&mut screw, Some(units(slack)));
            let motion = engaged(&mut screw, (theta, 0.0), 0);
            let expected = extension(theta, slack).max(released());
            assert!(
                (metres_of(motion) - expected).abs() < 2.0 * TOLERANCE,
                "{theta} {slack}: {} {expected}",
                metres_of(motion)
            );
        }
        for taut in [Some(i32::MIN), Some(-1), Some(0), None] {
            command(&mut screw, taut);
            let motion = engaged(&mut screw, (theta, 0.0), 0);
            assert!((metres_of(motion) - extension(theta, 0.0)).abs() < TOLERANCE);
        }
    }
}

/// Also the speed of a joint that turns while the belt is released.
#[test]
fn the_speed_of_a_released_screw_is_that_of_its_extension() {
    let mut screw = driving(0, 1.0);
    unlimited(&mut screw);
    for theta in [1.2, 2.0, 2.9] {
        for slack in [0.01, 0.06, 0.12] {
            command(&mut screw, Some(units(slack)));
            let motion = engaged(&mut screw, (theta, 0.7), 0);
            let speed = (extension(theta + 1e-4, slack) - extension(theta - 1e-4, slack)) / 2e-4;
            let shaft = speed * 0.7 / LEAD * TAU;
            let found = f64::from(motion.velocity);
            assert!(
                (found - shaft).abs() < 1e-3 + 1e-4 * shaft.abs(),
                "{theta} {slack}: {found} {shaft}"
            );
        }
    }
}

#[test]
fn slack_comes_and_goes_with_the_engage_speed() {
    let mut screw = driving(0, 1.0);
    engaged(&mut screw, (2.0, 0.0), 0);
    let now = inputs(Some((2.0, 0.0)));
    let mut slack = 0.0_f64;
    // The last one is a change of mode in the middle of a release.
    for (commanded, ticks) in [
        (Some(0.02), 1_100),
        (Some(0.005), 800),
        (None, 300),
        (Some(0.1), 100),
        (None, 50),
    ] {
        let target = commanded.unwrap_or(0.0);
        // The tick that takes the command still follows the one before.
        let before = screw.slack;
        command(&mut screw, commanded.map(units));
        slack += f64::from(screw.slack - before) / 16_777_216.0;
        for _ in 0..ticks {
            slack += (target - slack).clamp(-SLACKENED, SLACKENED);
            let at = metres_of(set_point(&mut screw, &now));
            let expected = extension(2.0, slack);
            assert!(
                (at - expected).abs() < 2.0 * TOLERANCE,
                "{slack}: {at} {expected}"
            );
        }
    }
}

/// A forged or mistaken target counts as the limit, which the screw names.
#[test]
fn a_slack_beyond_its_limit_or_that_the_posture_forbids_is_named() {
    let mut screw = driving(0, 1.0);
    // The joint's angle, and what the screw gives there at most. At 0.3 rad the screw is at its
    // released length before the belt has the slack.
    for (theta, commanded, given, named) in [
        (2.0, 0.199, Some(0.199), false),
        (2.0, 0.201, Some(0.2), true),
        (2.0, 100.0, Some(0.2), true),
        (2.0, -0.001, Some(0.0), true),
        (0.3, 0.001, Some(0.001), false),
        (0.3, 0.03, None, true),
    ] {
        command(&mut screw, Some(units(commanded)));
        let at = metres_of(engaged(&mut screw, (theta, 0.0), 0));
        let expected = given.map_or(released(), |slack| extension(theta, slack));
        assert!(
            (at - expected).abs() < 2.0 * TOLERANCE,
            "{theta} {commanded}: {at} {expected}"
        );
        assert_eq!(screw.lacks_slack, named, "{theta} {commanded}");
    }
    command(&mut screw, None);
    engaged(&mut screw, (0.0, 0.0), 0);
    assert!(!screw.lacks_slack, "taut at its released length");
}

/// The way back from the limit takes 0.2 m of slack at 20 mm/s.
#[test]
fn after_an_absurd_slack_the_belt_is_taut_again_within_the_time_of_the_limit() {
    let mut screw = driving(0, 1.0);
    command(&mut screw, Some(i32::MAX));
    engaged(&mut screw, (3.0, 0.0), 0);
    let now = inputs(Some((3.0, 0.0)));
    command(&mut screw, None);
    let ticks = (1..60_000)
        .find(|_| (metres_of(set_point(&mut screw, &now)) - extension(3.0, 0.0)).abs() < TOLERANCE);
    let (ticks, expected) = (f64::from(ticks.expect("a taut belt")), 0.2 / SLACKENED);
    assert!((ticks / expected - 1.0).abs() < 2e-3, "{ticks} {expected}");
}

/// The travel is from the home switch, which closes 6 mm below the released length, to the longest
/// taut extension, at half a turn.
#[test]
fn the_travel_reaches_from_the_home_switch_to_the_longest_extension() {
    let screw = Screw::new(&Settings::default()).unwrap();
    let limits = screw.axle.parameters().position_limits;
    for (limit, expected) in limits
        .into_iter()
        .zip([released() - 6e-3, extension(PI, 0.0)])
    {
        let limit = f64::from(limit) / 16_777_216.0;
        assert!(
            (limit - expected).abs() < TOLERANCE,
            "{limits:?} {expected}"
        );
    }
}

#[test]
fn a_written_parameter_is_in_force() {
    let mut screw = Screw::new(&Settings::default()).unwrap();
    let mut parameters = screw.axle.parameters();
    parameters.following_time += 7;
    screw.axle_mut().configure(&parameters);
    assert_eq!(screw.axle.parameters(), parameters);
}
