//! Tests of the balance alone, with B2P2.

use super::{Balance, Motion};
use crate::constants::CONTROL_PERIOD;
use crate::estimate::attitude::Attitude;
use crate::math::max;
use crate::robots::b2p2::B2p2;
use crate::robots::body::balance_parameters;
use crate::robots::{Ahead, Command};
use crate::sensing::Sensing;
use crate::sensors::BodySensors;
use crate::settings::{Setting, Settings};
use crate::stability::filter::Verdict;
use crate::stability::support::{Edge, Stance};

fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings
            .set(setting.description().key, *value)
            .expect("a value within bounds");
    }
    settings
}

/// Motion of a robot with this pitch, rad, that takes this time to stop, s.
fn at(pitch: f32, stopping: f32) -> Motion {
    Motion {
        pitch,
        stopping,
        forward_scale: 1.0,
    }
}

/// Creates a stance on a support 0.8 m long and 0.6 m wide. The centre of gravity is `ahead` m in
/// front of the rear edge.
fn stance(ahead: f32) -> Stance {
    let contacts = [
        [0.0, -0.3, 0.0],
        [0.8, -0.3, 0.0],
        [0.8, 0.3, 0.0],
        [0.0, 0.3, 0.0],
    ];
    Stance::on(contacts, [ahead, 0.0, 0.2])
}

/// Reading of good sensors on a robot that stands level. Readings that never change would count as
/// those of a stuck sensor.
fn reading(step: u32) -> BodySensors {
    let noise = 1e-5 * (step % 3) as f32;
    BodySensors {
        inclination: [noise, -noise],
        specific_force: [0.0, 0.0, 9.81],
        ..BodySensors::default()
    }
}

/// Number of control periods after which the attitude has settled.
const SETTLED: u32 = 300;

/// Attitude of a robot on level ground after this many control periods.
fn level(steps: u32) -> Attitude {
    let mut attitude = Attitude::default();
    for step in 0..steps {
        attitude.update(&reading(step), CONTROL_PERIOD);
    }
    attitude
}

/// Creates sensors and balance of a robot on level ground with good sensors.
fn standing(settings: &Settings, ahead: f32, speed: f32) -> (Sensing, Balance) {
    let mut sensing = Sensing::new(settings);
    let mut balance = Balance::new(settings, balance_parameters::<B2p2>(settings));
    let mut attitude = Attitude::default();
    for step in 0..SETTLED {
        let reading = reading(step);
        let usable = sensing.receive(Some(&reading));
        assert_eq!(usable, &reading);
        attitude.update(usable, CONTROL_PERIOD);
        balance.evaluate(&mut sensing, &stance(ahead), None, &attitude, speed, 4e-3);
    }
    (sensing, balance)
}

/// The shape ahead has a rear margin of 65 mm. Without uncertainty the robot may move there slowly.
/// With an uncertainty of 20 mm it may not.
#[test]
fn the_uncertainty_is_taken_off_the_margin_ahead() {
    for (uncertainty, passes) in [(0, true), (20_000, false)] {
        let settings = settings(&[(Setting::CogUncertainty, uncertainty)]);
        let (_, balance) = standing(&settings, 0.3, 0.0);
        let (allowed, verdict) = balance.clone().filter(
            &Command::<()>::default(),
            Some(&stance(0.065).into()),
            at(0.0, 0.0),
        );
        let expected = if passes {
            Verdict::PostureScaled(Edge::Back)
        } else {
            Verdict::PostureRefused(Edge::Back)
        };
        assert_eq!((allowed.posture, verdict), (passes, expected));
    }
}

/// The shape ahead has a rear margin of 65 mm. The measured force takes 20 mm from the present
/// margin, and as much from the margin ahead.
#[test]
fn a_measured_force_is_taken_off_the_margin_ahead() {
    for (force, passes) in [(0.0, true), (0.02, false)] {
        let (_, mut balance) = standing(&Settings::default(), 0.3, 0.0);
        balance.margins.now[Edge::Back as usize] -= force;
        let ahead = stance(0.065).into();
        let (allowed, _) =
            balance
                .clone()
                .filter(&Command::<()>::default(), Some(&ahead), at(0.0, 0.0));
        assert_eq!(allowed.posture, passes, "{force}");
    }
}

/// A stop lasts twice as long with half of the deceleration. A robot that drives forward or turns
/// on the spot brakes backward, and one that backs brakes forward. The margin to the left shrinks,
/// also while the robot stands.
#[test]
fn a_robot_that_bears_less_deceleration_looks_farther_ahead() {
    for (forward, yaw_rate) in [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.5)] {
        let asked = Command {
            forward,
            yaw_rate,
            posture: (),
        };
        let speed_scale = |stopping: f32, [ahead, behind]: [f32; 2]| {
            let (_, mut balance) = standing(&settings(&[(Setting::StepBehind, 0)]), 0.4, 0.0);
            let braking = balance.parameters.braking;
            balance.limits.forward = ahead * braking;
            balance.limits.backward = behind * braking;
            balance.margins.now[Edge::Left as usize] = 0.13;
            balance.margins.rate[Edge::Left as usize] = -0.2;
            balance
                .filter(&asked, None, at(0.0, stopping))
                .0
                .speed_scale
        };
        let (braking, other) = if forward < 0.0 {
            ([0.5, 1.0], [1.0, 0.5])
        } else {
            ([1.0, 0.5], [0.5, 1.0])
        };
        let (short, long) = (speed_scale(0.3, [1.0; 2]), speed_scale(0.6, [1.0; 2]));
        assert!(long > 0.0 && long < short && short < 1.0, "{long} {short}");
        assert_eq!(speed_scale(0.3, braking), long, "{asked:?}");
        assert_eq!(speed_scale(0.3, other), short, "{asked:?}");
        // The guard brakes no harder.
        assert_eq!(speed_scale(0.3, [3.0; 2]), short, "{asked:?}");
    }
}

/// The shape ahead has a rear margin of 80 mm. This is enough on level ground, and too little for
/// the sway of a steep robot.
#[test]
fn a_steep_robot_keeps_room_for_its_sway() {
    let (_, balance) = standing(&Settings::default(), 0.3, 0.0);
    for (pitch, passes) in [(0.0, true), (0.6, false), (-0.6, true)] {
        let (allowed, _) = balance.clone().filter(
            &Command::<()>::default(),
            Some(&stance(0.08).into()),
            at(pitch, 0.0),
        );
        assert_eq!(allowed.posture, passes, "{pitch}");
    }
}

/// The rear margin falls at 0.3 m/s, because the shape changes or because the robot rears up. The
/// change of shape holds nothing back, and rearing up is found equally fast after it as after rest.
/// While the attitude settles, only the margin itself counts, so the same takes longer.
#[test]
fn a_change_of_shape_is_no_decay_but_rearing_up_is_from_its_first_moment() {
    let asked = Command {
        forward: 0.1,
        ..Command::<()>::default()
    };
    let fall = 0.3 * CONTROL_PERIOD;
    // Returns the number of steps of rearing up until something is held back, after a change of
    // shape from the margin `start` to 0.2 m.
    let held_back = |uncertainty: i32, start: f32, attitude: &Attitude| {
        let settings = settings(&[(Setting::CogUncertainty, uncertainty)]);
        let (mut sensing, mut balance) = standing(&settings, start, 0.1);
        let mut evaluate = |margin: f32, kept: f32| {
            let (now, kept) = (stance(margin), stance(kept));
            balance.evaluate(
                &mut sensing,
                &now,
                Some(&kept),
                attitude,
                0.1,
                CONTROL_PERIOD,
            );
            balance
                .clone()
                .filter(&asked, None, at(0.3, 0.375))
                .0
                .speed_scale
                < 1.0
        };
        let mut margin = start;
        while margin > 0.2 {
            margin -= fall;
            assert!(!evaluate(margin, margin + fall), "{margin}");
        }
        margin = 0.2;
        let mut steps = 0;
        while !evaluate(margin, margin) {
            margin -= fall;
            steps += 1;
        }
        steps
    };
    let settled = level(SETTLED);
    for uncertainty in [0, 20_000] {
        let held_back = |start: f32, attitude| held_back(uncertainty, start, attitude);
        let (after_rest, after_change) = (held_back(0.2, &settled), held_back(0.6, &settled));
        assert!(after_rest > 0);
        assert_eq!(after_rest, after_change);
        let settling = held_back(0.2, &level(100));
        assert!(settling > 2 * after_rest, "{settling} {after_rest}");
    }
}

/// An undeclared load of 2 kg within 0.3 m, on robots of 8.315 kg and 40 kg. The expected pull on
/// the centre of gravity follows from the moments.
#[test]
fn a_heavier_robot_is_less_uncertain() {
    for (body_1, total) in [(6_356_067, 8.315_283), (38_040_784, 40.0)] {
        let settings = settings(&[
            (Setting::MassUncertainty, 2_000),
            (Setting::Body1Mass, body_1),
        ]);
        let found = standing(&settings, 0.4, 0.0).1.margins().now[0];
        let expected = 0.4 - 2.0 * 0.3 / (total + 2.0);
        assert!((f64::from(found) - expected).abs() < 1e-5, "{found}");
    }
}

/// The centre of gravity is 0.2 m high on level ground, so the robot does not bear a fall off a
/// step of 150 mm. Where the margin is wide, nothing passes backward, and the front is not folded
/// down. Where it is narrow, these motions may be the ways out.
#[test]
fn a_narrow_margin_leaves_the_ways_out_though_a_step_may_be_behind() {
    let backward = Command {
        forward: -0.45,
        ..Command::<()>::default()
    };
    for pitch in [0.04, 0.5] {
        let evaluate = |margin: f32| {
            let (_, balance) = standing(&Settings::default(), margin, 0.0);
            let ahead = Ahead {
                stance: stance(margin + 0.001),
                lifts: true,
            };
            let (allowed, _) = balance
                .clone()
                .filter(&backward, Some(&ahead), at(pitch, 0.0));
            (0.45 * allowed.speed_scale, allowed.limits.posture)
        };
        assert_eq!(evaluate(0.10), (0.0, 0.0));
        let (backed, folded) = evaluate(0.07);
        assert!((backed - 0.025).abs() < 1e-3 && (folded - 0.5).abs() < 0.02);
        let (backed, folded) = evaluate(0.045);
        assert!(
            (backed - 0.05).abs() < 1e-3 && folded > 0.8,
            "{backed} {folded}"
        );
    }
}

/// Creates a stance on a support that rises along the heading by `sine` m per metre. The centre of
/// gravity is `ahead` m in front of its rear edge.
fn sloped(sine: f32, ahead: f32) -> Stance {
    let up = 0.8 * sine;
    let contacts = [
        [0.0, -0.3, 0.0],
        [0.8, -0.3, up],
        [0.8, 0.3, up],
        [0.0, 0.3, 0.0],
    ];
    Stance::on(contacts, [ahead, 0.0, 0.2])
}

/// The robot stands nose up, with a rear margin of 70 mm.
#[test]
fn the_guard_holds_back_a_turn_nose_up() {
    let turn = Command {
        yaw_rate: 0.5,
        ..Command::<()>::default()
    };
    let (_, mut balance) = standing(&Settings::default(), 0.07, 0.0);
    balance.stance = sloped(0.2, 0.07);
    let speed_scale = |pitch: f32| {
        balance
            .clone()
            .filter(&turn, None, at(pitch, 0.0))
            .0
            .speed_scale
    };
    assert!(
        (speed_scale(0.2) - 0.5).abs() < 0.02,
        "{}",
        speed_scale(0.2)
    );
    assert_eq!(speed_scale(-0.05), 1.0);
}

/// Whatever margin is left, and however steep the robot is, at least one motion passes with more
/// than 9 % of its speed.
#[test]
fn some_motion_always_passes_above_the_trip_margin() {
    let standing = |margin: f32| standing(&Settings::default(), margin, 0.0).1;
    for margin in (12..140).map(|millimetres| millimetres as f32 * 1e-3) {
        let balance = standing(margin);
        for pitch in [0.0, 0.1, 0.2, 0.4, 0.6, 0.8] {
            let speed_scale = |forward: f32| {
                let asked = Command {
                    forward,
                    ..Command::<()>::default()
                };
                balance
                    .clone()
                    .filter(&asked, None, at(pitch, 0.0))
                    .0
                    .speed_scale
            };
            let ahead = Ahead {
                stance: stance(margin + 0.001),
                lifts: true,
            };
            let none = Command::<()>::default();
            let (folding, _) = balance.clone().filter(&none, Some(&ahead), at(pitch, 0.0));
            let most = max(
                max(speed_scale(0.05), speed_scale(-0.05)),
                folding.limits.posture,
            );
            assert!(most > 0.09, "{margin} at {pitch}: {most}");
        }
    }
}

/// The centre of gravity is 0.2 m high and 30 mm in front of the rear edge. An instant stop from
/// 0.2 m/s leaves it the energy of the trip margin there.
#[test]
fn backing_down_close_to_the_rear_edge_is_slow() {
    let mut settings = Settings::default();
    settings
        .set(Setting::StepBehind.description().key, 0)
        .expect("no step");
    let (_, balance) = standing(&settings, 0.03, -0.1);
    let backward = Command {
        forward: -0.45,
        ..Command::<()>::default()
    };
    let (allowed, verdict) =
        balance
            .clone()
            .filter(&backward, Some(&stance(0.03).into()), at(0.3, 0.0));
    assert_eq!(verdict, Verdict::Scaled(Edge::Back));
    let passed = 0.45 * allowed.speed_scale;
    // v^2 = 2 g (l - l_left) l^2 / h^2 with l^2 = 0.0409 m^2. 10.44 mm are left: the trip margin,
    // and 44 % of the ramp's least width.
    assert!((passed - 0.1985).abs() < 2e-3, "{passed}");
}

/// The robot drives forward, nose up, and its rear margin of 110 mm falls by 0.15 m/s. The command
/// leads away from this edge, but the robot still drives to it.
#[test]
fn a_robot_that_drives_to_an_edge_brakes_hard_although_its_command_leads_away() {
    for (speed, margin, rate, brakes) in [
        (0.4, 0.11, -0.15, true),
        (0.4, 0.3, -0.15, false),
        (-0.1, 0.11, 0.0, false),
    ] {
        let (_, mut balance) = standing(&settings(&[(Setting::StepBehind, 0)]), margin, speed);
        balance.margins.rate[Edge::Back as usize] = rate;
        balance.margins.speed = speed;
        let backward = Command {
            forward: -0.2,
            ..Command::<()>::default()
        };
        let (allowed, verdict) =
            balance
                .clone()
                .filter(&backward, None, at(0.4, speed.abs() / 0.4));
        assert_eq!((allowed.speed_scale, verdict), (1.0, Verdict::Passed));
        assert_eq!(allowed.brakes, brakes, "{speed} {margin}");
    }
}
