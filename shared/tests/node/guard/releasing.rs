//! Tests of how the operator releases and tightens the belts, and of what freezes their slack.

use super::bench::{Bench, SCREW};
use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::bus::cia402::mode;
use tautrack::bus::pdo::{BELTS_RELEASED, Request};
use tautrack::node::guard::{Outputs, State};
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::robots::{Body, PostureCommand};
use tautrack::settings::Settings;

/// 120 mm, and the largest change in a SYNC period: 20 mm/s for 4 ms; in 2^-24 m.
const RELEASED: i32 = 2_013_265;
const STEP: i32 = 1_343;

/// Mode and slack of the newest set-point of the screw, 2^-24 m.
fn belt(bench: &Bench) -> Option<(i8, i32)> {
    let set_point = bench.position_set_point(SCREW)?;
    Some((set_point.mode, set_point.target))
}

fn slack(bench: &Bench) -> i32 {
    match belt(bench) {
        Some((mode::RELEASED, slack)) => slack,
        other => {
            assert_eq!(other, Some((mode::TAUT, 0)));
            0
        }
    }
}

fn state(outputs: &Outputs) -> State {
    State::from_code(outputs.state.state).expect("a state")
}

/// The operator requests this, and releases the belts or not.
fn request(bench: &mut Bench, request: Request, released: bool) {
    let flag = if released { BELTS_RELEASED } else { 0 };
    bench.command.as_mut().expect("an operator").request = request as u8 | flag;
}

#[test]
fn the_flag_releases_the_belts_with_the_engage_speed_and_its_end_tightens_them() {
    let mut bench = Bench::armed();
    assert_eq!(belt(&bench), Some((mode::TAUT, 0)));
    for (released, end) in [(true, RELEASED), (false, 0)] {
        request(&mut bench, Request::Arm, released);
        let mut periods = 0;
        let mut before = slack(&bench);
        while slack(&bench) != end {
            let outputs = bench.run(4);
            let now = slack(&bench);
            assert!((now - before).abs() <= STEP, "{before} {now}");
            let published = f64::from(outputs.slack[0]) * 1e-6 * 16_777_216.0;
            assert!(
                (published - f64::from(now)).abs() < 20.0,
                "{published} {now}"
            );
            (before, periods) = (now, periods + 1);
            assert!(periods < 1_600);
        }
        // 120 mm at 20 mm/s.
        assert!((1_490..1_530).contains(&periods), "{periods}");
    }
}

/// Whatever stops the robot, and whatever the flag says meanwhile.
#[test]
fn a_stop_keeps_the_present_slack() {
    type Stop = fn(&mut Bench);
    let stops: [(&str, Stop); 4] = [
        ("stop", |bench| request(bench, Request::Stop, true)),
        ("emergency stop", |bench| bench.emergency_stop = true),
        ("silence", |bench| bench.command = None),
        ("a drive with a fault", |bench| bench.errors[0] = 0x7121),
    ];
    for (name, stop) in stops {
        let mut bench = Bench::armed();
        request(&mut bench, Request::Arm, true);
        bench.run(1_000);
        stop(&mut bench);
        bench.run(400);
        let kept = slack(&bench);
        assert!((1..RELEASED).contains(&kept), "{name}: {kept}");
        bench.run(1_000);
        assert_eq!(slack(&bench), kept, "{name}");
        if let Some(command) = &mut bench.command {
            command.request &= !BELTS_RELEASED;
        }
        if name != "emergency stop" && name != "a drive with a fault" {
            continue;
        }
        bench.run(1_000);
        assert_eq!(slack(&bench), kept, "{name}, without the flag");
    }
}

#[test]
fn arming_starts_taut_whatever_the_flag_says() {
    let mut bench = Bench::with(&[]);
    request(&mut bench, Request::Arm, true);
    bench.run(1_000);
    assert!(slack(&bench) > 0);
    // A fault holds the robot. After the reset it is armed anew.
    bench.errors[0] = 0x7121;
    bench.run(200);
    bench.errors[0] = 0;
    request(&mut bench, Request::Reset, true);
    let outputs = bench.run(400);
    assert_eq!(state(&outputs), State::Ready);
    request(&mut bench, Request::Arm, true);
    let mut started = false;
    loop {
        let outputs = bench.tick();
        match state(&outputs) {
            State::Starting(_) => {
                started = true;
                assert_eq!(slack(&bench), 0);
            }
            State::Armed => break,
            other => assert!(!started, "{other:?}"),
        }
    }
    assert!(started);
}

#[test]
fn the_flag_arms_no_robot_and_unknown_bits_stop_one() {
    let mut bench = Bench::with(&[]);
    request(&mut bench, Request::Stop, true);
    bench.ask(100);
    assert_eq!(bench.run(1_000).passed.passed_speed, 0);
    request(&mut bench, Request::Arm, false);
    assert_eq!(bench.run(2_000).passed.passed_speed, 100);
    for unknown in [0x08, 0x10] {
        bench.command.as_mut().expect("an operator").request |= unknown;
        assert_eq!(bench.run(1_000).passed.passed_speed, 0, "{unknown:#x}");
        request(&mut bench, Request::Arm, false);
        bench.run(1_000);
    }
}

#[test]
fn another_robot_ignores_the_flag() {
    fn check<B: Body>() {
        let body = B::new(&Settings::default()).expect("the default robot is good");
        for word in [-20_000, 0, 100] {
            let [with, without] = [true, false].map(|flag| body.commanded_posture(word, flag));
            assert_eq!(with.word(), without.word());
        }
        assert_eq!(body.slack(), [0.0; 2]);
    }
    check::<Crawler>();
    check::<Hylos>();
    check::<RtMover>();
}

/// What happens in one step of a random sequence.
#[derive(Clone, Copy, Debug)]
enum Happens {
    Request(u8),
    Posture(i16),
    Silence,
    Fault(bool),
    EmergencyStop(bool),
}

fn happens() -> impl Strategy<Value = Happens> {
    prop_oneof![
        6 => Just(Happens::Request(Request::Arm as u8 | BELTS_RELEASED)),
        4 => Just(Happens::Request(Request::Arm as u8)),
        2 => Just(Happens::Request(Request::Reset as u8)),
        2 => Just(Happens::Request(Request::Stop as u8 | BELTS_RELEASED)),
        2 => any::<u8>().prop_map(Happens::Request),
        2 => (-8_000_i16..14_000).prop_map(Happens::Posture),
        1 => Just(Happens::Silence),
        1 => any::<bool>().prop_map(Happens::Fault),
        1 => any::<bool>().prop_map(Happens::EmergencyStop),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The slack is never beyond the setting and never jumps. It changes only while the robot is
    /// armed and drives, and begins at 0 with every start.
    #[test]
    fn only_an_armed_robot_that_drives_changes_its_slack(
        steps in vec((happens(), 1_u64..500), 1..30),
    ) {
        let mut bench = Bench::armed();
        let mut before = slack(&bench);
        let mut silent = None;
        for (what, ticks) in steps {
            if let Some(command) = silent.take() {
                bench.command = Some(command);
            }
            match what {
                Happens::Request(byte) => bench.command.as_mut().unwrap().request = byte,
                Happens::Posture(word) => bench.command.as_mut().unwrap().posture = word,
                Happens::Silence => silent = bench.command.take(),
                Happens::Fault(on) => bench.errors[0] = if on { 0x7121 } else { 0 },
                Happens::EmergencyStop(on) => bench.emergency_stop = on,
            }
            for _ in 0..ticks {
                let outputs = bench.tick();
                let Some((mode, now)) = belt(&bench) else { continue };
                let now = match mode {
                    mode::RELEASED => now,
                    mode::TAUT => 0,
                    // A hold has no slack: the next start begins at 0.
                    _ => {
                        before = 0;
                        continue;
                    }
                };
                prop_assert!((0..=RELEASED).contains(&now), "{now}");
                prop_assert!(mode == mode::TAUT || now > 0);
                match state(&outputs) {
                    State::Armed => prop_assert!((now - before).abs() <= STEP, "{before} {now}"),
                    State::Held => prop_assert_eq!(now, before),
                    _ => prop_assert_eq!(now, 0),
                }
                let drives = bench.command.is_some_and(|command| {
                    Request::from_byte(command.request).drives()
                });
                if bench.emergency_stop || bench.command.is_some() && !drives {
                    prop_assert!(now == before || now == 0, "{before} {now} in a stop");
                }
                before = now;
            }
        }
    }
}
