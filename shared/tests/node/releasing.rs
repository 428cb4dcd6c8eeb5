//! Random sequences of a screw on the bus that is released and tightened: by a guard, by frames
//! that others forge, through halts, holds, faults, resets and restarts.

use super::wire::{Wire, set_point};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;
use std::f64::consts::TAU;
use tautrack::bus::cia402::{State, mode, toward_operation};
use tautrack::can::Frame;
use tautrack::screw::Geometry;
use tautrack::settings::Setting;
use tautrack::units::{Angle, Length};

/// Travel of the screw in a tick at the engage speed of 20 mm/s, m.
const ENGAGED: f64 = 20e-6;
/// Ends of the extension, m, and distance by which the screw may pass them.
const RELEASED: f64 = 0.226;
const LONGEST: f64 = 0.546;
const PASSED: f64 = 20e-6;

/// What happens in one step.
#[derive(Clone, Copy, Debug)]
enum Happens {
    /// The guard leads the drive up, in this mode with this target.
    Guard(i8, i32),
    /// The guard sends this controlword.
    Word(u16),
    /// The guard's frames stay out.
    Silence,
    /// The joint turns with this rate, rad/s.
    Joint(f64),
    /// The joint's frames stay out.
    JointLost,
    /// Both belts pull with this tension, N.
    Tension(f64),
    /// Another node sends a set-point to the drive in every so many milliseconds.
    Forged(i8, i32, u64),
    Restart,
}

fn happens() -> impl Strategy<Value = Happens> {
    let slack = || prop_oneof![4 => 0..3_000_000_i32, 1 => any::<i32>()];
    let mode = || prop_oneof![3 => Just(mode::RELEASED), 2 => Just(mode::TAUT)];
    prop_oneof![
        6 => (mode(), slack()).prop_map(|(mode, slack)| Happens::Guard(mode, slack)),
        2 => prop_oneof![Just(0x02), Just(0x10f), Just(0x8f), Just(0x00), Just(0x82)]
            .prop_map(Happens::Word),
        1 => Just(Happens::Silence),
        2 => (-0.5..0.5).prop_map(Happens::Joint),
        2 => Just(Happens::Joint(0.0)),
        1 => Just(Happens::JointLost),
        3 => (0.0..120.0).prop_map(Happens::Tension),
        1 => (mode(), any::<i32>(), 1_u64..9).prop_map(|(m, s, every)| Happens::Forged(m, s, every)),
        1 => Just(Happens::Restart),
    ]
}

fn screw() -> Wire {
    Wire::screw(&[(Setting::EngageSpeed, 20_000)])
}

/// Extension that the drive publishes, m.
fn extension(wire: &Wire) -> f64 {
    f64::from(wire.outputs().motion.position) / 16_777_216.0
}

/// Torque, N m, with which a force draws the nut of the screw back, N.
fn torque(force: f64) -> f64 {
    -force * 5e-3 / TAU
}

/// Leads the screw to the taut belt at this angle of the joint, from the extension at power-up.
fn engaged(theta: f64) -> Wire {
    let mut wire = screw();
    wire.joint = Some((theta, 0.0));
    wire.operate(mode::TAUT, 0);
    // At 20 mm/s.
    wire.run(30_000);
    wire
}

/// Releases the belt where it is taut, in less than 5 s.
#[test]
fn a_screw_on_the_bus_gives_the_slack_of_its_target_and_names_what_it_cannot_give() {
    let geometry = Geometry::from_micrometres(320_000, 230_000, 1_232_000).expect("a geometry");
    let mut wire = engaged(1.2);
    for (slack, named) in [
        (0.05, false),
        (0.12, false),
        (0.14, true),
        (-0.01, true),
        (0.0, false),
    ] {
        let target = (slack * 16_777_216.0) as i32;
        wire.command = Some(set_point(0x0f, mode::RELEASED, target));
        wire.run(8_000);
        let length = (extension(&wire) * 268_435_456.0) as i32;
        let theta = Angle::from_bits((1.2 / TAU * 4_294_967_296.0) as i32);
        let length = Length::from_bits(length);
        let found = f64::from(geometry.slack(theta, length).to_bits()) / 268_435_456.0;
        // At its released length the screw gives 131 mm at this angle.
        let given = f64::clamp(slack, 0.0, 0.13095);
        assert!((found - given).abs() < 50e-6, "{slack}: {found}");
        // Object 2000: slack.
        assert_eq!(wire.read((0x2000, 0))[0] == 19, named, "{slack}");
    }
}

/// Belt of 50 kN/m whose path something makes longer than the law's, by `longer`, m. Returns its
/// slack by the law, m, and its tension, N.
fn pull(wire: &mut Wire, longer: f64) -> (f64, f64) {
    let (l1, r) = (0.32, 0.23 + wire.rotor.angle / TAU * 5e-3);
    let along = r + l1 * 1.2_f64.cos();
    let chord = along.hypot(l1 * 1.2_f64.sin());
    let slack = 1.232 - r - chord;
    let tension = 50e3 * (longer - slack).max(0.0);
    wire.rotor.load = torque(2.0 * tension * (1.0 + along / chord));
    wire.tick(&[]);
    (slack, tension)
}

/// Commands the slack `command`, m, but at most 2 mm less than there is, as the guard does. Returns
/// the tension after 4 s, and the largest one, N.
fn settle(wire: &mut Wire, command: f64, longer: f64) -> (f64, f64) {
    let (mut now, mut most) = (0.0, 0.0_f64);
    for _ in 0..4_000 {
        let (slack, tension) = pull(wire, longer);
        let target = command.max(slack - 2e-3) * 16_777_216.0;
        wire.command = Some(set_point(0x0f, mode::RELEASED, target as i32));
        (now, most) = (tension, most.max(tension));
    }
    let found = f64::from(wire.outputs().belt_tension) * 0.1;
    assert!((found - now).abs() < 1.5, "{found} {now}");
    (now, most)
}

/// Something under the belts makes their path longer by 30 mm, and then by more.
#[test]
fn a_released_belt_is_tightened_to_its_tension_and_yields_to_a_larger_one() {
    let mut wire = engaged(1.2);
    settle(&mut wire, 0.06, 0.0);
    let (tension, most) = settle(&mut wire, 0.0, 0.03);
    assert!((39.0..41.0).contains(&tension), "{tension}");
    // It meets the tension at 20 mm/s.
    assert!(most < 70.0, "{most}");
    let (tension, _) = settle(&mut wire, 0.0, 0.034);
    assert!((39.0..41.0).contains(&tension), "{tension}");
    // A release does not look at the tension.
    let (tension, _) = settle(&mut wire, 0.06, 0.034);
    assert!(tension < 1.0, "{tension}");
}

/// A stop freezes the command, 2 mm below the slack.
#[test]
fn a_released_belt_yields_up_to_5_mm_beyond_a_command_that_stays() {
    let mut wire = engaged(1.2);
    settle(&mut wire, 0.06, 0.0);
    settle(&mut wire, 0.0, 0.03);
    for (longer, expected) in [(0.032, 39.0..41.0), (0.036, 185.0..195.0)] {
        let mut tension = 0.0;
        for _ in 0..4_000 {
            (_, tension) = pull(&mut wire, longer);
        }
        assert!(expected.contains(&tension), "{longer}: {tension}");
    }
}

/// Resets the faults of the drive, which then holds.
fn reset(wire: &mut Wire) {
    for word in [0x02, 0x82, 0x02] {
        wire.command = Some(set_point(word, 0, 0));
        wire.run(20);
    }
}

#[test]
fn no_sequence_takes_a_released_screw_beyond_its_ends_or_makes_it_jump() {
    let operated = Cell::new(0_u64);
    let mut runner = TestRunner::new(ProptestConfig::with_cases(40));
    let steps = vec((happens(), 1_u64..600), 1..25);
    runner
        .run(&steps, |steps| play(steps, &operated))
        .unwrap_or_else(|broken| panic!("{broken}"));
    // The sequences are worth something: most of the time the screw moves.
    assert!(operated.get() > 40_000, "{} ms", operated.get());
}

fn play(steps: Vec<(Happens, u64)>, operated: &Cell<u64>) -> Result<(), TestCaseError> {
    let mut wire = engaged(1.0);
    let (mut word, mut wanted): (Option<u16>, _) = (None, (mode::TAUT, 0));
    let (mut theta, mut rate, mut heard) = (1.0, 0.0, true);
    let (mut load, mut rests) = (0.0, 0_u64);
    for (what, ticks) in steps {
        let mut forged: Option<(Frame, u64)> = None;
        wire.guard = true;
        let mut silent = false;
        match what {
            Happens::Guard(mode, target) => {
                (word, wanted) = (None, (mode, target));
                if !wire.outputs().faults.is_empty() {
                    reset(&mut wire);
                }
            }
            Happens::Word(sent) => word = Some(sent),
            Happens::Silence => (silent, wire.guard) = (true, false),
            Happens::Joint(next) => (rate, heard) = (next, true),
            Happens::JointLost => heard = false,
            Happens::Tension(tension) => load = torque(3.8 * tension),
            Happens::Forged(mode, target, every) => {
                forged = Some((set_point(0x0f, mode, target), every));
            }
            Happens::Restart => {
                // The new drive begins at extension 0, and engages the belt from there.
                wire = engaged(theta);
            }
        }
        for tick in 0..ticks {
            theta += rate * 1e-3;
            if !(0.0..1.7).contains(&theta) {
                (theta, rate) = (theta.clamp(0.0, 1.7), 0.0);
            }
            wire.joint = heard.then_some((theta, rate));
            let state = wire.state();
            let sent = word.unwrap_or_else(|| toward_operation(state));
            wire.command = (!silent).then(|| set_point(sent, wanted.0, wanted.1));
            let foreign: Vec<Frame> = forged
                .filter(|(_, every)| tick % every == 0)
                .map(|(frame, _)| frame)
                .into_iter()
                .collect();
            let before = extension(&wire);
            // A load does not turn a screw without power.
            wire.rotor.load = if wire.powered() { load } else { 0.0 };
            wire.tick(&foreign);
            let now = extension(&wire);
            let state = wire.state();
            if !matches!(state, State::OperationEnabled | State::QuickStopActive) {
                continue;
            }
            prop_assert!(now > RELEASED - PASSED, "{now}");
            prop_assert!(now < LONGEST + PASSED, "{now}");
            // The motion that the joint asks for, at most 0.25 m/rad for any slack; twice the
            // engage speed; and what the loops add. The velocity limit is 0.11 mm in a tick.
            rests = if rate == 0.0 { rests + 1 } else { 0 };
            let joint = if rests > 100 { 0.0 } else { 0.5 * 0.25e-3 };
            let most = joint + 2.0 * ENGAGED + 20e-6;
            let moves = state == State::OperationEnabled && rests > 100;
            operated.set(operated.get() + u64::from(moves));
            prop_assert!((now - before).abs() < most, "{} m/s", (now - before) * 1e3);
        }
    }
    Ok(())
}
