//! Tests with operators whose frames are flipped, lost or mixed with those of another operator.

use super::bench::Bench;
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::network::{Emergency, emergency};
use tautrack::bus::pdo::{OperatorCommand, Request};
use tautrack::faults::Fault;
use tautrack::node::guard::State;
use tautrack::settings::Settings;

fn state(bench: &Bench) -> State {
    State::from_code(bench.guard.outputs().state.state).expect("a state")
}

fn powered(bench: &Bench) -> bool {
    let under_power = [DriveState::OperationEnabled, DriveState::QuickStopActive];
    bench.states.iter().all(|state| under_power.contains(state))
}

/// Sends one command of the stream with a bit of its request flipped.
fn flip(bench: &mut Bench, bit: u8) {
    let command = bench.command.as_mut().expect("an operator");
    command.request ^= 1 << bit;
    bench.tick();
    bench.command.as_mut().expect("an operator").request ^= 1 << bit;
}

/// The robot climbs; a drive's fault holds it. The operator goes on sending "arm".
#[test]
fn no_flipped_bit_resets_arms_or_switches_off() {
    for bit in 0..8 {
        let mut bench = Bench::armed();
        bench.ask(130);
        flip(&mut bench, bit);
        bench.run(200);
        let stopped = bit == 2; // from 1 to 5 is "back off", which needs a trip
        assert_eq!(state(&bench), State::Armed, "bit {bit}, {stopped}");
        assert!(powered(&bench), "bit {bit}: motors off");
        let code = Fault::Blocked.code();
        bench.extra.push(emergency(Emergency { node: 3, code }));
        bench.run(100);
        for _ in 0..10 {
            flip(&mut bench, bit);
            bench.run(50);
            assert_eq!(state(&bench), State::Held, "bit {bit}");
        }
        assert!(powered(&bench), "bit {bit}: motors off");
    }
}

/// Bits of the sequence number flip, too.
#[test]
fn one_operator_with_flipped_sequence_numbers_drives_on() {
    for bit in 0..8 {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.run(500);
        let command = bench.command.as_mut().expect("an operator");
        let sequence = command.sequence;
        command.sequence ^= 1 << bit;
        bench.tick();
        bench.command.as_mut().expect("an operator").sequence = sequence.wrapping_add(1);
        let outputs = bench.run(1_000);
        assert_eq!(outputs.passed.passed_speed, 130, "bit {bit}");
    }
}

/// Two streams: the first one's command comes in each tick but those in which the second one sends.
fn two(second: Request, every: u64, phase: u64, start: u8) -> Bench {
    let mut bench = Bench::new(&Settings::default());
    bench.run(1_000);
    let mut other = OperatorCommand {
        request: second as u8,
        forward: 300,
        sequence: start,
        ..OperatorCommand::default()
    };
    for tick in 0..2_000 {
        if tick % every == phase % every {
            other.sequence = other.sequence.wrapping_add(1);
            let first = bench.command.replace(OperatorCommand {
                // The bench counts it up.
                sequence: other.sequence.wrapping_sub(1),
                ..other
            });
            bench.tick();
            bench.command = first;
        } else {
            bench.tick();
        }
        assert!(!state(&bench).driving(), "every {every}, from {start}");
    }
    bench
}

#[test]
fn two_operators_never_arm_the_robot_and_the_report_names_them() {
    for second in [Request::Arm, Request::ArmOffLevel] {
        for every in [2, 3, 4, 7, 20] {
            for phase in 0..every.min(4) {
                for start in [0, 3, 250, 100] {
                    let bench = two(second, every, phase, start);
                    let code = bench.guard.outputs().state.fault_code;
                    assert_eq!(code, Fault::TwoOperators.code(), "{every} {phase} {start}");
                }
            }
        }
    }
}

#[test]
fn a_second_operator_makes_an_armed_robot_hold() {
    for every in [2, 4, 9] {
        let mut bench = Bench::armed();
        bench.ask(130);
        bench.run(500);
        for tick in 0..200_u64 {
            let command = *bench.command.as_ref().expect("an operator");
            if tick.is_multiple_of(every) {
                bench.command = Some(OperatorCommand {
                    request: Request::Stop as u8,
                    sequence: 77 + (tick / every) as u8,
                    ..command
                });
            }
            bench.tick();
            bench.command = Some(OperatorCommand {
                sequence: command
                    .sequence
                    .wrapping_add(u8::from(!tick.is_multiple_of(every))),
                ..command
            });
        }
        assert_eq!(state(&bench), State::Held, "every {every}");
        assert!(powered(&bench));
    }
}
