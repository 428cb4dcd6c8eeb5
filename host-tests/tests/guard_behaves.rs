//! What docs/nodes.md promises of the guard, against four drives that are as obedient as frames can say.

use std::f64::consts::TAU;
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, OperatorCommand, Payload, PositionSetPoint, Request,
    VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::BodySensors;
use tautrack::node::cia402::{self, controlword, status};
use tautrack::node::guard::{Guard, Inputs, Outputs, State};
use tautrack::settings::Settings;

const LEFT: u8 = 2;
const JOINT: u8 = 4;
const SCREW: u8 = 5;
/// `(K - L1) / 2 - L2`: the straight robot's extension, in 2^-24 m.
const TAUT: i32 = (0.226 * 16_777_216.0) as i32;

/// The guard on level ground, and what its drives were told last.
struct Robot {
    guard: Guard,
    now_us: u64,
    /// Drives that are on the bus.
    alive: Vec<u8>,
    operator: Option<OperatorCommand>,
    /// Speed and controlword that the left track was told, speed in 1e-6 rad/s.
    left: VelocitySetPoint,
    /// What the joint was told.
    joint: PositionSetPoint,
}

impl Robot {
    fn new() -> Self {
        Self {
            guard: Guard::new(&Settings::default()).expect("B2P2's geometry"),
            now_us: 0,
            alive: vec![LEFT, 3, JOINT, SCREW],
            operator: None,
            left: VelocitySetPoint::default(),
            joint: PositionSetPoint::default(),
        }
    }

    /// A robot whose operator drives it at 0.2 m/s.
    fn driving() -> Self {
        let mut robot = Self::new();
        robot.ask(Request::Arm, 0);
        robot.run(500);
        robot.ask(Request::Arm, 200);
        let outputs = robot.run(1_500);
        assert_eq!(State::from_byte(outputs.state.state), Some(State::Armed));
        // 0.2 m/s on a pulley of 50 mm.
        assert!(
            (robot.left.target - 4_000_000).abs() < 10_000,
            "{:?}",
            robot.left
        );
        robot
    }

    fn ask(&mut self, request: Request, forward: i16) {
        self.operator = Some(OperatorCommand {
            forward,
            request: request as u8,
            ..OperatorCommand::default()
        });
    }

    /// One millisecond: every drive beats, says where it is, and that it is enabled and referenced.
    fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        let milliseconds = self.now_us / 1_000;
        let mut frames: Vec<Frame> = Vec::new();
        for node in &self.alive {
            if milliseconds.is_multiple_of(50) {
                frames.push(Frame::new(0x700 + u16::from(*node), &[5]).expect("a heartbeat"));
            }
            if milliseconds.is_multiple_of(4) {
                let motion = DriveMotion {
                    position: if *node == SCREW { TAUT } else { 0 },
                    velocity: 0,
                };
                let condition = DriveStatus {
                    statusword: cia402::State::OperationEnabled.statusword() | status::REFERENCED,
                    ..DriveStatus::default()
                };
                frames.push(motion.frame(transmit(1), *node));
                frames.push(condition.frame(transmit(2), *node));
            }
        }
        let operator = self
            .operator
            .as_mut()
            .filter(|_| milliseconds.is_multiple_of(20));
        let operator = operator.map(|command| {
            command.sequence = command.sequence.wrapping_add(1);
            *command
        });
        let outputs = self.guard.tick(&Inputs {
            now_us: self.now_us,
            body: Some(BodySensors {
                specific_force: [0.0, 0.0, 9.81],
                ..BodySensors::default()
            }),
            operator,
            frames: &frames,
        });
        for frame in &outputs.frames {
            if let Some(told) = VelocitySetPoint::from_frame(frame, receive(2), LEFT) {
                self.left = told;
            } else if let Some(told) = PositionSetPoint::from_frame(frame, receive(1), LEFT) {
                (self.left.controlword, self.left.mode) = (told.controlword, told.mode);
            } else if let Some(told) = PositionSetPoint::from_frame(frame, receive(1), JOINT) {
                self.joint = told;
            }
        }
        outputs
    }

    fn run(&mut self, milliseconds: usize) -> Outputs {
        let mut last = None;
        for _ in 0..milliseconds {
            last = Some(self.tick());
        }
        last.expect("at least one tick")
    }
}

#[test]
fn guard_stops_the_robot_when_the_operator_falls_silent() {
    let mut robot = Robot::driving();
    robot.operator = None;
    robot.run(250);
    assert!(robot.left.target > 3_900_000, "operator_timeout is 300 ms");
    // 0.2 m/s down at 0.4 m/s^2 takes 500 ms.
    let outputs = robot.run(70 + 520);
    assert_eq!(robot.left.target, 0);
    assert_eq!(robot.left.controlword, controlword::ENABLE_OPERATION);
    assert_eq!(State::from_byte(outputs.state.state), Some(State::Armed));
}

#[test]
fn guard_holds_the_robot_when_a_drive_falls_silent() {
    let mut robot = Robot::driving();
    robot.alive.retain(|node| *node != SCREW);
    let outputs = robot.run(80);
    assert_eq!(State::from_byte(outputs.state.state), Some(State::Held));
    assert_eq!(outputs.state.fault_node, SCREW);
    assert_eq!(
        Fault::from_code(outputs.state.fault_code),
        Some(Fault::NodeLost)
    );
    assert_eq!(robot.left.controlword, controlword::QUICK_STOP);
    assert_eq!(robot.joint.controlword, controlword::QUICK_STOP);
}

#[test]
fn a_held_robot_is_ready_after_the_reset_but_not_armed() {
    let mut robot = Robot::driving();
    robot.alive.retain(|node| *node != SCREW);
    robot.run(200);
    robot.alive.push(SCREW);
    // The node is back and the operator still asks to drive: nothing changes without a reset.
    let outputs = robot.run(500);
    assert_eq!(State::from_byte(outputs.state.state), Some(State::Held));
    robot.ask(Request::Reset, 200);
    let outputs = robot.run(500);
    assert_eq!(State::from_byte(outputs.state.state), Some(State::Ready));
    assert_eq!(robot.left.controlword, controlword::DISABLE_VOLTAGE);
}

#[test]
fn a_command_beyond_the_speed_limit_is_the_limit() {
    let mut robot = Robot::driving();
    robot.ask(Request::Arm, i16::MAX);
    robot.run(3_000);
    // speed_limit, 0.45 m/s.
    assert!(
        (robot.left.target - 9_000_000).abs() < 20_000,
        "{:?}",
        robot.left
    );
}

#[test]
fn the_chassis_turns_no_faster_than_its_limit() {
    let mut robot = Robot::driving();
    robot.ask(Request::Arm, 0);
    robot.run(1_000);
    if let Some(command) = &mut robot.operator {
        command.chassis = (0.3 / TAU * 65_536.0) as i16;
    }
    let mut before = robot.joint.target;
    for _ in 0..500 {
        robot.run(4);
        let speed =
            f64::from(robot.joint.target.wrapping_sub(before)) / 4_294_967_296.0 * TAU / 4e-3;
        assert!(speed.abs() < 0.501, "{speed} rad/s; chassis_speed is 0.5");
        before = robot.joint.target;
    }
    let angle = f64::from(before) / 4_294_967_296.0 * TAU;
    assert!((angle - 0.3).abs() < 1e-3, "{angle}");
}
