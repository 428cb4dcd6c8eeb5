//! Random sequences of events: requests, restarts, two operators, flipped bits, forged frames, dead
//! sensors and slopes. Whatever their order is, no drive lets go unless the operator disarms.

use super::bench::{Bench, DRIVES, standing};
use crate::sweep::stamp_of_executable;
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::network::{Emergency, emergency};
use tautrack::bus::pdo::{DriveMotion, OperatorCommand, Payload, Request, transmit};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::State;
use tautrack::settings::Settings;

const SEQUENCES: u64 = 300;
const EVENTS: usize = 25;
/// Time after which two operators are recognised and the robot holds, ms.
const RECOGNISED_MS: u64 = 600;

struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u64) as usize]
    }
}

/// A second operator: his command, period and phase, ms.
type Second = Option<(OperatorCommand, u64, u64)>;

struct Sequence {
    random: Random,
    bench: Bench,
    second: Second,
    mixed_ms: u64,
    before: [bool; 4],
    events: Vec<String>,
}

fn powered(bench: &Bench) -> [bool; 4] {
    let under_power = [DriveState::OperationEnabled, DriveState::QuickStopActive];
    bench.states.map(|state| under_power.contains(&state))
}

impl Sequence {
    fn new(seed: u64) -> Self {
        let mut bench = Bench::new(&Settings::default());
        // The guard learns the constant error of the gyroscope.
        bench.run(1_100);
        Self {
            random: Random(seed),
            bench,
            second: None,
            mixed_ms: 0,
            before: [false; 4],
            events: vec![format!("seed {seed}")],
        }
    }

    /// Makes one event happen.
    fn event(&mut self) {
        let (random, bench) = (&mut self.random, &mut self.bench);
        let index = random.below(4) as usize;
        let id = DRIVES[index];
        let event = random.below(16);
        match event {
            0..=3 => bench.request(Request::Arm),
            4 => {
                let requests = [
                    Request::Stop,
                    Request::Disarm,
                    Request::EmergencyStop,
                    Request::ArmOffLevel,
                    Request::Override,
                    Request::BackOff,
                ];
                bench.request(random.one(&requests));
            }
            5 | 6 => bench.request(Request::Reset),
            7 => {
                bench.states[index] = DriveState::SwitchOnDisabled;
                bench.homed[index] &= random.below(2) == 0;
                self.before[index] = false;
                let boot_up = Frame::new(0x700 + u16::from(id), &[0]);
                bench.extra.extend(boot_up);
            }
            8 => {
                let command = OperatorCommand {
                    request: random.one(&[1, 1, 2, 3, 4, 5, 6, 7]),
                    forward: 200,
                    sequence: random.below(256) as u8,
                    ..OperatorCommand::default()
                };
                let other = (command, 2 + random.below(40), random.below(40));
                self.second = self.second.is_none().then_some(other);
            }
            9 => {
                let (position, velocity) =
                    (random.below(1 << 31) as i32, random.one(&[0, i32::MAX]));
                let motion = DriveMotion { position, velocity };
                bench.extra.push(motion.frame(transmit(1), id));
            }
            10 => {
                let network = random.one(&[4, 5, 0x7f]);
                bench
                    .extra
                    .extend(Frame::new(0x700 + u16::from(id), &[network]));
            }
            11 => {
                let code = Fault::Blocked.code();
                bench.extra.push(emergency(Emergency { node: id, code }));
            }
            12 => bench.emergency_stop = !bench.emergency_stop,
            13 => bench.body = random.one(&[None, Some(standing(0.0)), Some(standing(0.6))]),
            14 => bench.velocities[index % 2] = random.one(&[0, 1_500_000]),
            _ => {
                // One command with a flipped bit.
                let command = bench.command.as_mut().expect("an operator");
                let (request, sequence) = (command.request, command.sequence);
                let bit = 1 << random.below(8);
                if random.below(2) == 0 {
                    command.request ^= bit;
                } else {
                    command.sequence ^= bit;
                }
                self.tick();
                let command = self.bench.command.as_mut().expect("an operator");
                (command.request, command.sequence) = (request, sequence.wrapping_add(1));
            }
        }
        let request = self.bench.command.map(|command| command.request);
        self.events
            .push(format!("{event} at {id}, request {request:?}"));
    }

    fn tick(&mut self) {
        let time = self.bench.now_us / 1_000;
        let turn = match self.second {
            Some((_, period, phase)) => time % period == phase % period,
            None => false,
        };
        if let Some((command, ..)) = &mut self.second.filter(|_| turn) {
            let first = self.bench.command.replace(*command);
            self.bench.tick();
            let sent = self.bench.command.expect("the second operator's command");
            self.bench.command = first;
            if let Some((command, ..)) = &mut self.second {
                command.sequence = sent.sequence;
            }
        } else {
            self.bench.tick();
        }
        self.mixed_ms = if self.second.is_some() {
            self.mixed_ms + 1
        } else {
            0
        };
        self.check();
    }

    fn check(&mut self) {
        let (bench, events) = (&self.bench, &self.events);
        let command = bench.command.expect("an operator");
        let request = Request::from_byte(command.request);
        let now = powered(bench);
        for (index, now) in now.into_iter().enumerate() {
            let lets_go = self.before[index] && !now;
            assert!(
                !lets_go || request == Request::Disarm,
                "drive {index} let go; {events:#?}"
            );
        }
        let state = State::from_code(bench.guard.outputs().state.state).expect("a state");
        if self.mixed_ms > RECOGNISED_MS {
            assert!(
                !matches!(state, State::Starting(_) | State::Armed),
                "{state:?} with two operators; {events:#?}"
            );
        }
        self.before = now;
    }
}

#[test]
fn whatever_happens_no_drive_lets_go_unless_the_operator_disarms() {
    let Some(_stamp) =
        stamp_of_executable("whatever_happens_no_drive_lets_go_unless_the_operator_disarms")
    else {
        return;
    };
    let mut armed = 0;
    for seed in 0..SEQUENCES {
        let mut sequence = Sequence::new(seed);
        for _ in 0..EVENTS {
            sequence.event();
            for _ in 0..=sequence.random.below(1_000) {
                sequence.tick();
            }
            let state = sequence.bench.guard.outputs().state.state;
            armed += u32::from(state == State::Armed.code());
        }
    }
    assert!(armed > 300, "the robot is armed only {armed} times");
}
