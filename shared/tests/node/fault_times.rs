//! Provokes every fault of the table, and compares its time with that of docs/faults.md. Drives run
//! on the motor model of `motor_faults`, with default settings.

use crate::guard::bench as guard;
use crate::motor_faults::rig::{self, GEAR, PER_RADIAN, Rig, Trouble};
use tautrack::bus::cia402::{CONTROL_START, State, controlword, mode, toward_operation};
use tautrack::bus::pdo::{DriveMotion, Request};
use tautrack::can::Frame;
use tautrack::faults::{ALL, Fault, Faults, Reaction};
use tautrack::motor::bridge::BridgeStop;
use tautrack::motor::model::MotorModel;
use tautrack::node::axle::{BridgeDemand, SetPoint};
use tautrack::node::guard::State as GuardState;
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::Switches;
use tautrack::settings::{Setting, Settings};

/// Velocity limit of the default settings, rad/s.
const LIMIT: f64 = 6.0;
/// Speeds at which a fault is provoked, rad/s.
const SPEEDS: [f64; 4] = [1.2, 3.0, 5.5, -3.0];

#[test]
fn every_fault_comes_in_the_time_of_the_page_and_has_its_reaction() {
    let mut differ = Vec::new();
    for fault in ALL {
        let times = times(*fault);
        let longest = times.iter().copied().max().expect("a time");
        println!("{fault:?}: {times:?} ms");
        let stated = usize::from(fault.description().longest_ms);
        if longest != stated {
            differ.push(format!("{fault:?}: {longest} ms instead of {stated}"));
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

/// Provokes a fault in several ways, and checks its reaction. Returns the milliseconds.
fn times(fault: Fault) -> Vec<usize> {
    match fault {
        Fault::NodeLost
        | Fault::SecondMaster
        | Fault::UnexpectedState
        | Fault::ScaleMismatch
        | Fault::TwoOperators
        | Fault::DuplicateNode => vec![time_of_guard(fault)],
        Fault::JointLost | Fault::BeltOverload | Fault::BeltLost => vec![time_of_screw(fault)],
        _ => rigs(fault)
            .into_iter()
            .map(|rig| time_of_drive(rig, fault))
            .collect(),
    }
}

/// The drive runs at this speed, rad/s.
fn running(three_phase: bool, speed: f64, changes: &[(Setting, i32)]) -> Rig {
    let mut rig = Rig::new(three_phase, changes);
    rig.target = (speed * PER_RADIAN) as i32;
    rig.run(1_000);
    rig
}

/// The same with a trouble that begins with the next tick.
fn troubled(three_phase: bool, speed: f64, trouble: Trouble) -> Rig {
    let mut rig = running(three_phase, speed, &[]);
    rig.trouble = trouble;
    rig
}

/// A brushed and a three-phase drive.
fn both(make: impl Fn(bool) -> Rig) -> Vec<Rig> {
    vec![make(false), make(true)]
}

fn at_speeds(three_phase: bool, trouble: Trouble) -> [Rig; 4] {
    SPEEDS.map(|speed| troubled(three_phase, speed, trouble))
}

/// Drives whose bridge something opens without software, at standstill without a current and in
/// motion.
fn stopped(stop: BridgeStop) -> Vec<Rig> {
    let at = |speed| {
        both(|kind| {
            let mut rig = running(kind, speed, &[]);
            rig.bridge_stop = Some(stop);
            rig
        })
    };
    [at(0.0), at(3.0)].into_iter().flatten().collect()
}

/// Drives in which the cause of a fault begins with the next tick.
fn rigs(fault: Fault) -> Vec<Rig> {
    match fault {
        Fault::SafeTorqueOff => stopped(BridgeStop::SafeTorqueOff),
        Fault::ShortCircuit => stopped(BridgeStop::Comparator),
        Fault::ProcessorEvent => stopped(BridgeStop::Processor),
        Fault::OverCurrent => [0, u16::MAX]
            .into_iter()
            .flat_map(|code| both(|kind| troubled(kind, 3.0, Trouble::CurrentCode(code))))
            .collect(),
        Fault::Overspeed => both(|kind| {
            let mut rig = running(kind, 5.5, &[]);
            rig.load = -60.0;
            while rig.run(1).velocity < 1.2 * LIMIT as f32 {}
            rig
        }),
        Fault::VelocityDeviation => vec![runaway()],
        Fault::OpenPhase => [(false, 2), (true, 3)]
            .into_iter()
            .flat_map(|(kind, leads)| (0..leads).map(move |lead| (kind, lead)))
            .flat_map(|(kind, lead)| [0.3, 1.2, 3.0].map(|speed| (kind, lead, speed)))
            .map(|(kind, lead, speed)| {
                let mut rig = running(kind, speed, &[]);
                rig.load = 8.0;
                rig.run(300);
                rig.trouble = Trouble::OpenLead(lead);
                rig
            })
            .collect(),
        Fault::EncoderMismatch => [Trouble::FrozenEncoder, Trouble::ReversedEncoder]
            .into_iter()
            .flat_map(|trouble| at_speeds(false, trouble))
            .collect(),
        Fault::RotorAngle => [30.0, -30.0, 60.0, -60.0]
            .into_iter()
            .flat_map(|degrees| at_speeds(true, Trouble::Slipped(degrees)))
            .collect(),
        Fault::EncoderNoise => [false, true]
            .into_iter()
            .flat_map(|kind| at_speeds(kind, Trouble::NoisyEncoder(800)))
            .collect(),
        Fault::Misaligned => both(|kind| {
            let mut rig = Rig::new(kind, &[(Setting::ProbeCurrent, 1_000)]);
            rig.run(500);
            rig.trouble = Trouble::ReversedEncoder;
            rig.target = (3.0 * PER_RADIAN) as i32;
            rig
        }),
        _ => rigs_around_the_motor(fault),
    }
}

/// The same for the faults of supply, temperature, load and command.
fn rigs_around_the_motor(fault: Fault) -> Vec<Rig> {
    match fault {
        Fault::InvalidReading | Fault::OverTemperature => {
            let readings = if fault == Fault::InvalidReading {
                [Some(f32::NAN), None]
            } else {
                [Some(90.5), Some(300.0)]
            };
            readings
                .into_iter()
                .map(|motor| {
                    let mut rig = Rig::new(false, &[(Setting::MotorTemperature, 900)]);
                    rig.temperatures.motor = Some(25.0);
                    rig.target = PER_RADIAN as i32;
                    rig.run(500);
                    rig.temperatures.motor = motor;
                    rig
                })
                .collect()
        }
        Fault::OverVoltage | Fault::UnderVoltage => both(|kind| {
            let mut rig = running(kind, 3.0, &[]);
            let over = fault == Fault::OverVoltage;
            rig.supply_voltage = if over { 33.0 } else { 11.5 };
            rig
        }),
        Fault::ControlOverrun => both(|kind| troubled(kind, 3.0, Trouble::MissedInterrupts)),
        Fault::Blocked => both(|kind| {
            let stuck = MotorModel {
                friction_torque: 60.0,
                ..rig::model(kind)
            };
            let mut rig = Rig::with_model(stuck, &rig::settings(kind, &[]));
            rig.run(500);
            rig.target = (3.0 * PER_RADIAN) as i32;
            rig
        }),
        Fault::FollowingError => both(|kind| {
            let mut rig = running(kind, 0.0, &[]);
            (rig.mode, rig.target) = (mode::CYCLIC_POSITION, 0);
            rig.run(200);
            rig.load = 24.7;
            let limit = Settings::default().get(Setting::FollowingLimit);
            while rig.angle().abs() * 1e3 <= f64::from(limit) {
                rig.run(1);
            }
            rig
        }),
        Fault::ShaftMismatch => both(|kind| {
            let mut rig = located(kind);
            rig.run(500);
            rig.shaft_error = Some(6_f64.to_radians());
            rig
        }),
        Fault::HoldOverload => both(|kind| {
            let mut rig = running(kind, 0.0, &[]);
            rig.word = Some(controlword::QUICK_STOP);
            rig.run(200);
            rig.load = 18.0;
            rig
        }),
        Fault::DuplicateId => both(|kind| {
            let mut rig = running(kind, 3.0, &[]);
            rig.axle.report(Faults::of(fault));
            rig
        }),
        Fault::GuardLost => both(|kind| {
            let mut rig = running(kind, 3.0, &[]);
            while rig.inputs.is_none_or(|inputs| !inputs.guard_received) {
                rig.run(1);
            }
            rig.guard_alive = false;
            rig
        }),
        Fault::CommandLost => both(|kind| {
            let mut rig = running(kind, 3.0, &[]);
            while rig.inputs.is_none_or(|inputs| inputs.set_point.is_none()) {
                rig.run(1);
            }
            rig.silent = true;
            rig
        }),
        Fault::HomingFailed => both(homing),
        Fault::HomingMismatch => both(|kind| {
            let mut rig = homing(kind);
            second_approach_elsewhere(&mut rig);
            rig
        }),
        _ => panic!("{fault:?} is no fault of an axle"),
    }
}

/// A drive that has its position from a shaft sensor.
pub fn located(three_phase: bool) -> Rig {
    let mut rig = Rig::new(three_phase, &[(Setting::ShaftSensor, 1)]);
    rig.shaft_error = Some(0.0);
    rig.word = Some(0);
    rig.run(200);
    assert!(rig.axle.homed());
    rig.word = None;
    rig
}

/// A brushed drive with swapped leads and a heavy load that gathers speed the wrong way, from the
/// moment in which it is faster than 20 % of the limit.
fn runaway() -> Rig {
    let heavy = MotorModel {
        rotor_inertia: 80.0 * 0.05 / (GEAR * GEAR) as f32,
        ..rig::model(false)
    };
    let mut rig = Rig::with_model(heavy, &rig::settings(false, &[]));
    rig.run(500);
    rig.trouble = Trouble::ReversedPhase;
    rig.target = (5.0 * PER_RADIAN) as i32;
    while rig.run(1).velocity > -0.2 * LIMIT as f32 {}
    rig
}

/// A drive that begins to home with the next tick; its switch never closes by itself.
fn homing(three_phase: bool) -> Rig {
    let mut rig = Rig::new(three_phase, &[(Setting::HomingDirection, 1)]);
    rig.mode = mode::HOMING;
    rig.run(500);
    rig.word = Some(controlword::ENABLE_OPERATION | CONTROL_START);
    rig
}

/// Homes until the second approach finds the switch 0.2 rad before the first one did. The switch
/// closes with the next tick.
fn second_approach_elsewhere(rig: &mut Rig) {
    let closed = Switches {
        home: true,
        ..Switches::default()
    };
    while rig.angle() < 0.5 {
        rig.run(1);
    }
    rig.switches = closed;
    let mut before = rig.angle();
    rig.run(20);
    // Back, away from the switch.
    while rig.angle() > 0.3 {
        before = rig.angle();
        rig.run(1);
    }
    rig.switches = Switches::default();
    // Forth again.
    loop {
        rig.run(1);
        let forth = rig.angle() > before;
        before = rig.angle();
        if forth {
            break;
        }
    }
    rig.switches = closed;
}

/// Runs a drive until a fault is raised; checks fault, reaction and snapshot. Returns the
/// milliseconds.
fn time_of_drive(mut rig: Rig, fault: Fault) -> usize {
    let (outputs, milliseconds) = rig.until_raised(25_000).expect("a fault");
    let raised = outputs.faults.strongest();
    assert_eq!(raised, Some(fault), "{milliseconds} ms");
    let inputs = rig.inputs.expect("inputs");
    let snapshot = outputs.snapshot.expect("a snapshot");
    assert_eq!(snapshot.code, fault.code());
    assert_eq!(snapshot.position, outputs.motion.position, "{fault:?}");
    assert_eq!(snapshot.velocity, outputs.motion.velocity, "{fault:?}");
    assert_eq!(snapshot.current, outputs.status.current, "{fault:?}");
    assert_eq!(
        snapshot.supply_voltage,
        (inputs.supply_voltage * 1e3) as i32
    );
    match fault.description().reaction {
        Reaction::Off => assert_eq!(outputs.bridge, BridgeDemand::Off),
        Reaction::Brake => assert_eq!(outputs.bridge, BridgeDemand::Brake),
        Reaction::Hold => holds(&mut rig, fault),
    }
    milliseconds
}

/// Checks that the drive ramps to standstill and stays there under power, whatever is commanded.
fn holds(rig: &mut Rig, fault: Fault) {
    rig.load = 0.0;
    for _ in 0..1_500 {
        rig.tick();
    }
    let start = rig.angle();
    for _ in 0..500 {
        let outputs = rig.tick();
        let current = matches!(
            outputs.bridge,
            BridgeDemand::Current(_) | BridgeDemand::Braking { .. }
        );
        assert!(current, "{fault:?}: {:?}", outputs.bridge);
    }
    let travel = (rig.angle() - start).abs();
    assert!(travel < 1e-3, "{fault:?}: {travel} rad");
}

/// Motor current of a screw with a straight front under this tension of each belt, A. A belt pulls
/// with twice its tension, and the motor has 2.4 N m/A.
fn current_at(tension: f64) -> f32 {
    (4.0 * tension * 5e-3 / std::f64::consts::TAU / 2.4) as f32
}

/// A screw in mode "taut", where the belt is taut. Its joint falls silent, or its belts pull hard
/// or no more.
fn time_of_screw(fault: Fault) -> usize {
    let mut settings = Settings::default();
    // At power-up the shaft is at position 0, and homed.
    let direction = Setting::HomingDirection.description().key;
    settings.set(direction, 0).expect("a direction");
    let mut screw = Screw::new(&settings).expect("a belt");
    let mut rig = Rig::new(false, &[]);
    rig.tick();
    let mut inputs = screw::Inputs {
        axle: rig.inputs.expect("inputs of an axle"),
        joint: None,
    };
    inputs.axle.bench_mode = true;
    // 0.226 m for a straight chassis, at 5 mm a turn; something else turns the shaft that far.
    let taut = (45.2 * 4_096.0 * GEAR) as i32;
    let mut state = State::SwitchOnDisabled;
    let mut tick = |joint_moves: bool, tension: f64| {
        let axle = &mut inputs.axle;
        axle.now_us += 1_000;
        axle.encoder = taut.min(axle.encoder + 120);
        axle.current = current_at(tension);
        let turned = axle.encoder == taut;
        axle.set_point = turned.then(|| SetPoint {
            controlword: toward_operation(state),
            mode: mode::TAUT,
            target: 0,
        });
        if joint_moves {
            inputs.joint = Some((DriveMotion::default(), axle.now_us));
        }
        let outputs = screw.tick(&inputs);
        state = State::from_statusword(outputs.status.statusword).expect("a state");
        (outputs, state == State::OperationEnabled)
    };
    while !tick(true, 0.0).1 {}
    for _ in 0..500 {
        let (outputs, _) = tick(true, 50.0);
        assert!(outputs.faults.is_empty(), "{:?}", outputs.faults);
    }
    let tension = match fault {
        Fault::BeltOverload => 600.0,
        Fault::BeltLost => 0.0,
        _ => 50.0,
    };
    let milliseconds = (1..500).find(|_| {
        let (outputs, _) = tick(fault != Fault::JointLost, tension);
        let Some(found) = outputs.faults.strongest() else {
            return false;
        };
        let code = outputs.snapshot.map(|snapshot| snapshot.code);
        assert_eq!((found, code), (fault, Some(fault.code())));
        assert!(matches!(outputs.bridge, BridgeDemand::Current(_)));
        true
    });
    milliseconds.expect("a fault")
}

/// Lets the sequence number of the next command jump.
fn jump(bench: &mut guard::Bench, step: i8) {
    let command = bench.command.as_mut().expect("an operator");
    command.sequence = command.sequence.wrapping_add_signed(step);
}

/// A guard that finds a fault: it holds the robot, or does not arm it.
fn time_of_guard(fault: Fault) -> usize {
    let mut bench = if fault == Fault::ScaleMismatch {
        let mut bench = guard::Bench::new(&Settings::default());
        bench.scales[2] = 24;
        bench
    } else {
        guard::Bench::armed()
    };
    match fault {
        Fault::NodeLost => bench.silent = Some(3),
        // A set-point for a drive.
        Fault::SecondMaster => bench.extra.extend(Frame::new(0x203, &[0; 8])),
        // A second operator's command, and the first jump back.
        Fault::TwoOperators => {
            for step in [100, -100] {
                jump(&mut bench, step);
                bench.tick();
            }
        }
        _ => {}
    }
    let milliseconds = (1..2_000).find(|_| {
        match fault {
            Fault::UnexpectedState => bench.states[1] = State::SwitchedOn,
            Fault::TwoOperators => jump(&mut bench, 100),
            // A heartbeat in each tick.
            Fault::DuplicateNode => bench.extra.extend(Frame::new(0x703, &[5])),
            _ => {}
        }
        bench.tick().state.fault_code == fault.code()
    });
    if fault == Fault::ScaleMismatch {
        bench.request(Request::Arm);
        let outputs = bench.run(1_000);
        assert_eq!(
            GuardState::from_code(outputs.state.state),
            Some(GuardState::Ready)
        );
    } else {
        let outputs = bench.run(4);
        assert_eq!(
            GuardState::from_code(outputs.state.state),
            Some(GuardState::Held)
        );
        // The right track is the one that fails, and the screw keeps the belt taut.
        for drive in [2, guard::JOINT] {
            let word = bench.controlword(drive);
            assert_eq!(word, Some(controlword::QUICK_STOP), "{fault:?}: {drive}");
        }
    }
    milliseconds.expect("a fault")
}
