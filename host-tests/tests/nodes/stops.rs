//! Tests of the guard's stops, with a guard and all drives of a robot on one bus.

use crate::bench::Node;
use crate::network::{Network, level};
use tautrack::bus::cia402::{State as DriveState, controlword, mode};
use tautrack::bus::pdo::{DEAD_MAN_HELD, Payload, Request, VelocitySetPoint, receive};
use tautrack::faults::{Fault, Faults};
use tautrack::node::axle::SetPoint;
use tautrack::node::guard::State;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::settings::Setting;

const STAIRS: &str = "staircase.toml";
const JOINT: u8 = 4;

fn b2p2() -> Network<B2p2> {
    Network::armed(STAIRS, &[])
}

#[test]
fn a_restarted_guard_leaves_a_holding_drive_holding_and_arms_by_a_new_request_only() {
    for silence_ms in [20, 60, 500] {
        let mut network = b2p2();
        network.drive(JOINT).bench.load = 3.0;
        network.run(1_000);
        let angle = network.drive(JOINT).bench.angle;
        network.stop_guard();
        network.run(silence_ms);
        network.start_guard();
        // The operator keeps sending "arm".
        for _ in 0..2_000 {
            network.tick();
            assert!(
                network.drive(JOINT).under_power(),
                "{silence_ms} ms: let go"
            );
            assert!(
                !network.state().driving(),
                "{silence_ms} ms: armed by itself"
            );
        }
        let sagged = (network.drive(JOINT).bench.angle - angle).abs();
        assert!(sagged < 0.02, "{silence_ms} ms: sagged by {sagged} rad");
        network.request(Request::Reset);
        network.run(500);
        assert!(network.drive(JOINT).under_power(), "let go by the reset");
        network.request(Request::Arm);
        network.until(State::Armed);
        let sagged = (network.drive(JOINT).bench.angle - angle).abs();
        assert!(sagged < 0.03, "{silence_ms} ms: sagged by {sagged} rad");
    }
}

#[test]
fn a_reset_in_held_leaves_the_drives_holding() {
    let mut network = b2p2();
    network.drive(JOINT).bench.load = 3.0;
    network.run(500);
    let angle = network.drive(JOINT).bench.angle;
    // The restart of a track makes it silent for 200 ms.
    network.drive(2).restart();
    network.until(State::Held);
    network.request(Request::Reset);
    network.until(State::Ready);
    for _ in 0..1_000 {
        network.tick();
        assert!(network.drive(JOINT).under_power());
    }
    let sagged = (network.drive(JOINT).bench.angle - angle).abs();
    assert!(sagged < 0.02, "{sagged} rad");
    // Only "disarm" (motors off) releases the drives.
    network.request(Request::Disarm);
    // Three commands of the operator, and 20 ms of the guard's frames.
    network.run(120);
    assert!(!network.drive(JOINT).under_power());
}

#[test]
fn a_fault_in_any_stage_of_the_start_stops_every_drive_and_a_reset_leads_out() {
    for stage in 0..4 {
        for victim in [2, JOINT, 5] {
            let mut network = Network::<B2p2>::new(STAIRS, &[]);
            network.until(State::Ready);
            network.run(80);
            network.request(Request::Arm);
            network.until(State::Starting(stage));
            network.run(60);
            network.drive(victim).restart();
            network.until(State::Held);
            network.run(300);
            let places = network.angles();
            for _ in 0..2_000 {
                network.tick();
                let fastest = network.fastest();
                assert!(
                    fastest < 0.01,
                    "stage {stage}, node {victim}: {fastest} of its limit"
                );
            }
            for (drive, before) in network.drives.iter().zip(places) {
                let moved = (drive.bench.angle - before).abs();
                assert!(
                    moved < 0.02 || !drive.under_power(),
                    "stage {stage}, node {victim}: node {} moved",
                    drive.id
                );
            }
            network.request(Request::Reset);
            network.until(State::Ready);
            network.request(Request::Arm);
            network.until(State::Armed);
        }
    }
}

/// A slope turns the left track, which was switched off with a fault that requires a hold.
#[test]
fn a_stop_brakes_a_track_that_rolls_with_a_fault_whose_reaction_is_hold() {
    for fault in [
        Fault::GuardLost,
        Fault::CommandLost,
        Fault::DuplicateId,
        Fault::SecondMaster,
        Fault::HoldOverload,
    ] {
        for request in [Request::Stop, Request::EmergencyStop] {
            let mut network = b2p2();
            if fault == Fault::GuardLost {
                network.stop_guard();
                network.run(500);
                network.start_guard();
            } else {
                let Node::Axle(axle) = &mut network.drive(2).bench.node else {
                    panic!("a track is an axle");
                };
                axle.report(Faults::of(fault));
            }
            network.run(500);
            network.request(Request::Disarm);
            network.run(500);
            let codes = network.drive(2).outputs.as_ref().expect("outputs");
            assert!(codes.faults.contains(fault), "{fault:?}");
            assert!(!network.drive(2).under_power());
            network.drive(2).bench.load = 0.05;
            network.run(1_000);
            let rolls = network.drive(2).bench.velocity;
            assert!(rolls < -0.5, "{rolls} rad/s");
            network.request(request);
            network.run(400);
            let place = network.drive(2).bench.angle;
            for _ in 0..1_000 {
                network.tick();
                assert!(network.drive(2).under_power(), "{fault:?}, {request:?}");
            }
            let moved = (network.drive(2).bench.angle - place).abs();
            assert!(moved < 0.02, "{fault:?}, {request:?}: {moved} rad");
        }
    }
}

#[test]
fn an_emergency_stop_shorter_than_a_sync_period_latches() {
    let mut network = b2p2();
    network.command.forward = 130;
    network.run(1_000);
    network.emergency_stop = true;
    network.tick();
    network.emergency_stop = false;
    network.run(1_500);
    assert!(
        network.fastest() < 0.01,
        "{} of its limit",
        network.fastest()
    );
}

/// Causes, other than faults, that stop a moving robot.
#[derive(Clone, Copy, Debug)]
enum Stop {
    EmergencyObject,
    EmergencyRequest,
    Request,
    Silence,
    DeadMan,
}

const STOPS: [Stop; 5] = [
    Stop::EmergencyObject,
    Stop::EmergencyRequest,
    Stop::Request,
    Stop::Silence,
    Stop::DeadMan,
];

impl Stop {
    fn begin(self, network: &mut Network<B2p2>) {
        match self {
            Self::EmergencyObject => network.emergency_stop = true,
            Self::EmergencyRequest => {
                network.command.request = Request::EmergencyStop as u8 | DEAD_MAN_HELD;
            }
            Self::Request => network.command.request = Request::Stop as u8 | DEAD_MAN_HELD,
            Self::Silence => network.operator = false,
            Self::DeadMan => network.command.request = Request::Arm as u8,
        }
    }
}

#[test]
fn every_stop_stops_every_stage_of_the_start() {
    for stage in 0..4 {
        for stop in STOPS {
            let mut network = Network::<B2p2>::new(STAIRS, &[(Setting::DeadMan, 1)]);
            network.command.request = Request::Stop as u8 | DEAD_MAN_HELD;
            network.until(State::Ready);
            network.run(80);
            network.command.request = Request::Arm as u8 | DEAD_MAN_HELD;
            network.until(State::Starting(stage));
            network.run(60);
            stop.begin(&mut network);
            // The operator's timeout is 300 ms; a quick stop from the homing speed follows.
            network.run(600);
            let (places, state) = (network.angles(), network.state());
            for _ in 0..1_000 {
                network.tick();
                let fastest = network.fastest();
                assert!(
                    fastest < 0.01,
                    "stage {stage}, {stop:?}: {fastest} of its limit"
                );
            }
            assert_eq!(network.state(), state, "stage {stage}, {stop:?}");
            for (before, after) in places.iter().zip(network.angles()) {
                let moved = (after - before).abs();
                assert!(moved < 0.02, "stage {stage}, {stop:?}: {moved} rad");
            }
            // When it is allowed again, the start continues where it was.
            network.emergency_stop = false;
            network.operator = true;
            network.command.request = Request::Reset as u8 | DEAD_MAN_HELD;
            network.run(100);
            network.command.request = Request::Arm as u8 | DEAD_MAN_HELD;
            network.until(State::Armed);
        }
    }
}

#[test]
fn only_a_reset_ends_an_emergency_stop() {
    let mut network = b2p2();
    network.command.forward = 130;
    network.run(2_000);
    network.request(Request::EmergencyStop);
    network.run(1_000);
    for request in [
        Request::Override,
        Request::BackOff,
        Request::Arm,
        Request::Stop,
    ] {
        network.request(request);
        for _ in 0..1_000 {
            network.tick();
            let fastest = network.fastest();
            assert!(fastest < 0.01, "{request:?}: {fastest} of its limit");
        }
    }
    network.request(Request::Reset);
    network.run(100);
    network.request(Request::Arm);
    network.run(2_000);
    assert!(network.drives[0].bench.velocity > 2.0);
}

/// Maximum speed of hips and knees, rad/s.
fn legs(network: &Network<Hylos>) -> f64 {
    let motors = network.drives.iter().enumerate();
    motors
        .filter(|(number, _)| number % 4 < 2)
        .map(|(_, drive)| drive.bench.velocity.abs())
        .fold(0.0, f64::max)
}

#[test]
fn an_emergency_stop_stops_legs_within_300_ms_and_a_tenth_of_a_radian() {
    for request in [Request::EmergencyStop, Request::Stop] {
        let mut network = Network::<Hylos>::armed("hylos/loop.toml", &[]);
        // The robot is rising by 5 cm.
        network.command.posture = 250;
        network.run(600);
        assert!(legs(&network) > 0.05, "{} rad/s", legs(&network));
        let before = network.angles();
        network.request(request);
        network.run(300);
        for _ in 0..2_200 {
            network.tick();
            let speed = legs(&network);
            assert!(speed < 0.01, "{request:?}: {speed} rad/s");
        }
        for (before, after) in before.iter().zip(network.angles()) {
            assert!(
                (after - before).abs() < 0.1,
                "{request:?}: {before} to {after}"
            );
        }
    }
}

#[test]
fn an_emergency_stop_stops_levelling_within_200_ms() {
    let mut network = Network::<RtMover>::armed("rt-mover/step-10.toml", &[]);
    // The seat stays tilted whatever the shafts do, so levelling never ends.
    network.body.inclination = [0.05, 0.05];
    network.run(1_000);
    assert!(network.fastest() > 0.02, "{}", network.fastest());
    network.request(Request::EmergencyStop);
    network.run(200);
    for _ in 0..1_000 {
        network.tick();
        assert!(
            network.fastest() < 0.01,
            "{} of its limit",
            network.fastest()
        );
    }
    network.body = level();
}

#[test]
fn a_drive_that_was_disabled_by_somebody_else_is_reported_and_not_enabled_again() {
    let mut network = b2p2();
    network.drive(2).intruder = Some(SetPoint {
        controlword: controlword::DISABLE_VOLTAGE,
        mode: 0,
        target: 0,
    });
    // The drive follows the command once it has come for 20 ms.
    network.run(40);
    assert!(!network.drive(2).under_power());
    network.drive(2).intruder = None;
    let mut enabled_again = false;
    for _ in 0..200 {
        network.tick();
        enabled_again |= network.state() == State::Held
            && network.drive(2).state() == Some(DriveState::OperationEnabled);
    }
    assert_eq!(network.state(), State::Held);
    assert!(!enabled_again);
    let code = Fault::UnexpectedState.description().code;
    assert_eq!(
        (network.shown.fault_node, network.shown.fault_code),
        (2, code)
    );
}

#[test]
fn a_second_master_is_reported_within_20_ms_and_moves_nothing_far() {
    let mut network = b2p2();
    network.run(200);
    let before = network.angles();
    let foreign = VelocitySetPoint {
        controlword: controlword::ENABLE_OPERATION,
        mode: mode::CYCLIC_VELOCITY,
        target: 3_000_000,
    };
    for step in 0..2_000 {
        if step % 10 == 0 {
            network.foreign.push(foreign.frame(receive(2), 2));
        }
        network.tick();
        if step == 20 {
            assert_eq!(network.state(), State::Held);
            let code = Fault::SecondMaster.description().code;
            assert_eq!(network.shown.fault_code, code);
        }
    }
    for (before, after) in before.iter().zip(network.angles()) {
        assert!((after - before).abs() < 0.2, "{before} to {after}");
    }
}
