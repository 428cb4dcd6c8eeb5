//! Tests of stops under random sequences of events.

use crate::bench::Node;
use crate::network::{Network, level};
use crate::random::Random;
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::pdo::{OperatorCommand, Request};
use tautrack::can::Frame;
use tautrack::faults::{Fault, Faults};
use tautrack::node::guard::State;
use tautrack::robots::Body;
use tautrack::sensors::BodySensors;

/// Time after which nothing moves once the robot must stop, ms: the operator's timeout, three
/// commands, and a stop from full speed at the comfortable deceleration.
const STANDSTILL_MS: u32 = 300 + 60 + 1_200;
/// Time after which two operators must be recognised, ms.
const RECOGNISED_MS: u32 = 1_000;
/// Time for which a forged frame may count as one of its drive, ms.
const FORGED_MS: u32 = 400;
/// Speed from which a shaft without power may be braked, rad/s, and from which it is.
const ROLLING: f64 = 0.09;
const BRAKED: f64 = 0.11;
/// Time in which a track or wheel that rolls comes under power after a stop, ms: three commands of
/// the operator, and the drive's states.
const BRAKED_WITHIN_MS: u32 = 250;

/// Number of random sequences of the default robot, and of each other one.
const SEQUENCES: [u64; 2] = [200, 50];

fn is_powered(state: Option<DriveState>) -> bool {
    matches!(
        state,
        Some(DriveState::OperationEnabled | DriveState::QuickStopActive)
    )
}

/// Checks the conditions that must hold in every millisecond of one network.
struct Watch {
    stopped_ms: u32,
    silent_ms: u32,
    mixed_ms: u32,
    since_forged_ms: u32,
    /// Whether every request since the guard started was "arm".
    only_arm: bool,
    latched: bool,
    before: Vec<Option<DriveState>>,
    state_before: State,
    /// Times for which each drive has been under power, ms.
    powered_ms: Vec<u32>,
    /// Times for which each drive rolls without power, although a stop brakes it, ms.
    rolls_ms: Vec<u32>,
}

impl Watch {
    fn new(drives: usize) -> Self {
        Self {
            stopped_ms: 0,
            silent_ms: 0,
            mixed_ms: 0,
            since_forged_ms: FORGED_MS,
            only_arm: true,
            latched: false,
            before: vec![None; drives],
            state_before: State::Waiting,
            powered_ms: vec![0; drives],
            rolls_ms: vec![0; drives],
        }
    }

    fn check<B: Body>(&mut self, network: &Network<B>, events: &[String]) {
        let request = Request::from_byte(network.command.request);
        let state = network.state();
        self.silent_ms = if network.operator {
            0
        } else {
            self.silent_ms + 1
        };
        self.since_forged_ms += 1;
        // The second operator may reset, too.
        let second = network.second.is_some();
        self.latched &= !second;
        self.latched |= network.emergency_stop
            || (network.operator && request == Request::EmergencyStop && self.silent_ms == 0);
        let asks = request.drives() || matches!(request, Request::Override | Request::BackOff);
        let both = second && network.operator && network.guard.is_some();
        self.mixed_ms = if both { self.mixed_ms + 1 } else { 0 };
        if self.mixed_ms > RECOGNISED_MS {
            let drives = matches!(state, State::Starting(_) | State::Armed);
            assert!(!drives, "{state:?} with two operators; {events:#?}");
        }
        let stop = if second {
            self.mixed_ms > RECOGNISED_MS
        } else {
            !asks || self.silent_ms > 0 || self.latched || network.guard.is_none()
        };
        self.stopped_ms = if stop { self.stopped_ms + 1 } else { 0 };
        let forged = self.since_forged_ms < FORGED_MS;
        // A second operator may request motors off, and a guard that waits brakes nothing.
        let brakes = state != State::Waiting
            && network.guard.is_some()
            && network.operator
            && !second
            && !forged
            && matches!(request, Request::Stop | Request::EmergencyStop);
        if self.state_before != State::Armed && state == State::Armed {
            assert!(!self.only_arm, "armed without a new request; {events:#?}");
        }
        let drives = self.before.iter_mut().zip(&network.drives);
        for (index, (before, drive)) in drives.enumerate() {
            let now = drive.state();
            let rolls = B::ODOMETRY.contains(&index) && drive.bench.velocity.abs() > ROLLING;
            let enabled = now == Some(DriveState::OperationEnabled)
                && *before != Some(DriveState::OperationEnabled);
            // The limit of 320 ms after the stop began is the operator's timeout, one SYNC period,
            // and the transmission of the frames both ways.
            assert!(
                !enabled || self.stopped_ms <= 320 || rolls || forged,
                "drive {} enabled in a stop; {events:#?}",
                drive.id
            );
            let faulty = drive
                .outputs
                .as_ref()
                .is_some_and(|outputs| outputs.status.error_code != 0);
            assert!(
                !is_powered(*before)
                    || is_powered(now)
                    || request == Request::Disarm
                    || second
                    || faulty
                    || drive.outputs.is_none(),
                "drive {} let go, {before:?} {now:?}; {events:#?}",
                drive.id
            );
            let powered_ms = &mut self.powered_ms[index];
            *powered_ms = if drive.under_power() {
                *powered_ms + 1
            } else {
                0
            };
            let speed = drive.speed();
            assert!(
                speed < 0.02 || self.stopped_ms.min(*powered_ms) <= STANDSTILL_MS,
                "{speed} of its limit in a stop; {events:#?}"
            );
            let fault = now == Some(DriveState::Fault);
            let free = B::ODOMETRY.contains(&index)
                && drive.bench.velocity.abs() > BRAKED
                && !is_powered(now);
            let rolls_ms = &mut self.rolls_ms[index];
            *rolls_ms = if brakes && free && !fault {
                *rolls_ms + 1
            } else {
                0
            };
            assert!(
                *rolls_ms <= BRAKED_WITHIN_MS,
                "drive {} rolls, {now:?}; {events:#?}",
                drive.id
            );
            *before = now;
        }
        self.state_before = state;
    }
}

/// A frame that seems to come from one of the drives.
fn forged<B: Body>(network: &Network<B>, random: &mut Random) -> Frame {
    let drive = random.below(network.drives.len() as u64) as usize;
    let id = u16::from(network.drives[drive].id);
    let (function, length) =
        [(0x080, 8), (0x180, 8), (0x280, 8), (0x700, 1)][random.below(4) as usize];
    let data = random.bits().to_le_bytes();
    let heartbeat = [[0, 4, 5, 0x7f][random.below(4) as usize]];
    let data = if length == 1 { &heartbeat } else { &data[..] };
    Frame::new(function + id, data).expect("a frame")
}

/// Readings of a robot that is tilted by up to 0.6 rad, or level.
fn attitude(random: &mut Random) -> BodySensors {
    if random.below(2) == 0 {
        return level();
    }
    let pitch = random.between(-600, 600) as f32 * 1e-3;
    BodySensors {
        inclination: [pitch, 0.0],
        specific_force: [9.81 * pitch.sin(), 0.0, 9.81 * pitch.cos()],
        ..BodySensors::default()
    }
}

/// Runs one sequence of random events, each followed by a random time.
fn sequence<B: Body>(scenario: &str, seed: u64) {
    let mut random = Random::new(seed);
    let mut network = Network::<B>::new(scenario, &[]);
    let mut watch = Watch::new(network.drives.len());
    let mut events = vec![format!("{scenario}, seed {seed}")];
    for _ in 0..20 {
        let event = random.below(20);
        match event {
            0..=3 => network.request(Request::Arm),
            4 => network.request(Request::Stop),
            5 => {
                // The reset request clears the latch if no cause to stop is left.
                network.request(Request::Reset);
                watch.latched = false;
                watch.only_arm = false;
            }
            6 => network.request(Request::EmergencyStop),
            7 => network.emergency_stop = !network.emergency_stop,
            8 => network.operator = !network.operator,
            9 if network.guard.is_some() => {
                network.stop_guard();
            }
            9 | 10 => {
                if network.guard.is_none() {
                    network.start_guard();
                    watch.only_arm = true;
                    // The restarted guard has no latch, and arms only on a new request.
                    watch.latched = false;
                }
            }
            11 => {
                // A drive restarts, in any state.
                let drive = random.below(network.drives.len() as u64) as usize;
                network.drives[drive].restart();
                watch.before[drive] = None;
            }
            12 => network.body = attitude(&mut random),
            13 => network.sensors = !network.sensors,
            14 => network.flips = [1 << random.below(8), 0],
            15 => network.flips = [0, 1 << random.below(8)],
            16 => {
                network.second = network.second.is_none().then(|| {
                    let command = OperatorCommand {
                        request: random.below(8) as u8,
                        forward: random.between(-400, 400) as i16,
                        sequence: random.bits() as u8,
                        ..OperatorCommand::default()
                    };
                    (command, 1 + random.below(100), random.bits() >> 8)
                });
                watch.only_arm = false;
            }
            17 => {
                // A slope turns what has no power.
                let load = random.between(-50, 50) as f64 * 1e-3;
                for index in B::ODOMETRY {
                    network.drives[*index].bench.load = load;
                }
            }
            18 => {
                let index = random.below(network.drives.len() as u64) as usize;
                if let Node::Axle(axle) = &mut network.drives[index].bench.node {
                    let holds = [Fault::DuplicateId, Fault::HoldOverload, Fault::SecondMaster];
                    axle.report(Faults::of(holds[random.below(3) as usize]));
                }
            }
            _ => {
                let choice = [Request::Override, Request::BackOff, Request::Disarm];
                network.request(choice[random.below(3) as usize]);
            }
        }
        network.command.forward = random.between(-400, 400) as i16;
        network.command.yaw_rate = random.between(-500, 500) as i16;
        network.command.posture = random.between(-150, 250) as i16;
        let request = Request::from_byte(network.command.request);
        if !request.drives() && network.operator {
            watch.only_arm = false;
        }
        let forges = random.below(8) == 0;
        let milliseconds = random.between(1, 4_000);
        events.push(format!(
            "{event}: {:?} for {milliseconds} ms, forges: {forges}",
            network.command
        ));
        for _ in 0..milliseconds {
            if forges && random.below(20) == 0 {
                network.forged.push(forged(&network, &mut random));
                watch.since_forged_ms = 0;
            }
            network.tick();
            watch.check(&network, &events);
        }
    }
}

macro_rules! sequences {
    ($($folder:ident::$body:ident: $about:literal,)*) => {$(
        mod $folder {
            use tautrack_host_tests::robots::Kind;

            #[test]
            fn no_order_of_events_gets_around_a_stop() {
                let scenario = Kind::$body.facts().scenario_file;
                let sequence = super::sequence::<tautrack::robots::$folder::$body>;
                let other = Kind::$body != Kind::default();
                (0..super::SEQUENCES[usize::from(other)]).for_each(|seed| sequence(scenario, seed));
            }
        }
    )*};
}

tautrack::every_robot!(sequences);
