//! Tests of stops under random sequences of events.

use crate::network::Network;
use crate::random::Random;
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::pdo::Request;
use tautrack::node::guard::State;
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;

/// Time after which nothing moves once the robot must stop, ms: the operator's timeout, and a stop
/// from full speed at the comfortable deceleration.
const STANDSTILL_MS: u32 = 300 + 1_200;

/// Checks the conditions that must hold in every millisecond of one network.
struct Watch {
    stopped_ms: u32,
    silent_ms: u32,
    /// Whether every request since the guard started was "arm".
    only_arm: bool,
    latched: bool,
    before: Vec<Option<DriveState>>,
    state_before: State,
}

impl Watch {
    fn new(drives: usize) -> Self {
        Self {
            stopped_ms: 0,
            silent_ms: 0,
            only_arm: true,
            latched: false,
            before: vec![None; drives],
            state_before: State::Waiting,
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
        self.latched |= network.emergency_stop
            || (network.operator && request == Request::EmergencyStop && self.silent_ms == 0);
        let asks = matches!(request, Request::Arm | Request::Override | Request::BackOff);
        let stop = !asks || self.silent_ms > 0 || self.latched || network.guard.is_none();
        self.stopped_ms = if stop { self.stopped_ms + 1 } else { 0 };
        if self.stopped_ms > STANDSTILL_MS {
            let fastest = network.fastest();
            assert!(
                fastest < 0.02,
                "{fastest} of its limit in a stop; {events:#?}"
            );
        }
        if self.state_before != State::Armed && state == State::Armed {
            assert!(!self.only_arm, "armed without a new request; {events:#?}");
        }
        for (before, drive) in self.before.iter_mut().zip(&network.drives) {
            let now = drive.state();
            let enabled = now == Some(DriveState::OperationEnabled)
                && *before != Some(DriveState::OperationEnabled);
            // The limit of 320 ms after the stop began is the operator's timeout, one SYNC period,
            // and the transmission of the frames both ways.
            assert!(
                !enabled || self.stopped_ms <= 320,
                "drive {} enabled in a stop; {events:#?}",
                drive.id
            );
            *before = now;
        }
        self.state_before = state;
    }
}

/// Runs one sequence of random events, each followed by a random time.
fn sequence<B: Body>(scenario: &str, seed: u64) {
    let mut random = Random::new(seed);
    let mut network = Network::<B>::new(scenario, &[]);
    let mut watch = Watch::new(network.drives.len());
    let mut events = vec![format!("{scenario}, seed {seed}")];
    for _ in 0..20 {
        let event = random.below(13);
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
        if request != Request::Arm && network.operator {
            watch.only_arm = false;
        }
        let milliseconds = random.between(1, 4_000);
        events.push(format!(
            "{event}: {:?} for {milliseconds} ms",
            network.command
        ));
        for _ in 0..milliseconds {
            network.tick();
            watch.check(&network, &events);
        }
    }
}

#[test]
fn no_order_of_events_gets_around_a_stop_of_b2p2() {
    (0..60).for_each(|seed| sequence::<B2p2>("staircase.toml", seed));
}

#[test]
fn no_order_of_events_gets_around_a_stop_of_legs() {
    (0..15).for_each(|seed| sequence::<Hylos>("hylos/loop.toml", seed));
}

#[test]
fn no_order_of_events_gets_around_a_stop_of_arms() {
    (0..15).for_each(|seed| sequence::<RtMover>("rt-mover/step-10.toml", seed));
}
