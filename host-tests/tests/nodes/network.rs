//! Simulates a guard and all drives of a robot on one bus in one process: the same ticks as in the
//! nodes' programs, a rotor at each drive, level ground, and no physics of the whole robot.

use crate::bench::{self, Bench, Node};
use std::path::Path;
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::network::{Emergency, NmtCommand, emergency, is_sync, nmt};
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, GuardState, OperatorCommand, Payload, PositionSetPoint, Request,
    VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::node::axle::{Axle, BridgeDemand, Outputs, SetPoint};
use tautrack::node::guard::{Guard, Inputs, POSITION_SCALE, State};
use tautrack::node::screw::Screw;
use tautrack::robots::Body;
use tautrack::sensors::{BodySensors, Switches};
use tautrack::settings::{Setting, Settings};
use tautrack_host_tests::robots::{NodeSpec, Role};
use tautrack_host_tests::scenario::Scenario;

/// Drive with its rotor.
pub struct Drive {
    pub id: u8,
    pub bench: Bench,
    pub outputs: Option<Outputs>,
    /// Set-point from another sender that reaches the drive instead of the guard's.
    pub intruder: Option<SetPoint>,
    /// Whether NMT has started the node: it then accepts set-points and sends process data.
    operational: bool,
    boots: bool,
    syncs: u32,
    scale: u16,
    settings: Settings,
    role: Role,
    joint: Option<u8>,
}

impl Drive {
    fn new(spec: &NodeSpec) -> Self {
        let settings = settings(spec);
        let scale = match spec.role {
            Role::Screw => 0x118,
            _ => settings.get(Setting::PositionBits) as u16,
        };
        let inertia = spec.motor.map_or(0.05, |motor| {
            f64::from(motor.rotor_inertia) * f64::from(motor.gear_ratio).powi(2) * 2.0
        });
        let mut bench = Bench::new(node(spec.role, &settings), &settings, inertia);
        let direction = settings.get(Setting::HomingDirection);
        bench.switches = match direction {
            0 => |_| Switches::default(),
            1 => |angle| at_home(angle > 0.0),
            _ => |angle| at_home(angle < 0.0),
        };
        // The rotor starts at a small distance from the switch.
        bench.angle = -0.05 * f64::from(direction);
        Self {
            id: spec.id,
            bench,
            outputs: None,
            intruder: None,
            operational: false,
            boots: true,
            syncs: 0,
            scale,
            role: spec.role,
            joint: (spec.role == Role::Screw).then(|| settings.id(Setting::JointId)),
            settings,
        }
    }

    /// Restarts the node; the rotor keeps its angle.
    pub fn restart(&mut self) {
        self.bench.node = node(self.role, &self.settings);
        self.bench.set_point = None;
        self.outputs = None;
        self.operational = false;
        self.boots = true;
    }

    pub fn state(&self) -> Option<DriveState> {
        let outputs = self.outputs.as_ref()?;
        DriveState::from_statusword(outputs.status.statusword)
    }

    /// Whether the bridge carries current, so that the drive moves or holds.
    pub fn under_power(&self) -> bool {
        matches!(
            self.outputs.as_ref().map(|outputs| outputs.bridge),
            Some(BridgeDemand::Current(_))
        )
    }

    /// Speed of the output shaft, as a fraction of its limit.
    pub fn speed(&self) -> f64 {
        let limit = 1e-3 * f64::from(self.settings.get(Setting::VelocityLimit));
        self.bench.velocity.abs() / limit
    }

    /// Receives one frame; returns the answer if it is an SDO request.
    fn receive(&mut self, frame: &Frame) -> Option<Frame> {
        self.operational |= *frame == nmt(NmtCommand::Start, 0);
        if !self.operational && frame.id() < 0x580 {
            return None;
        }
        let mut follow = |controlword, mode, target| {
            self.bench.set_point = Some(SetPoint {
                controlword,
                mode,
                target,
            });
        };
        if let Some(point) = PositionSetPoint::from_frame(frame, receive(1), self.id) {
            follow(point.controlword, point.mode, point.target);
        } else if let Some(point) = VelocitySetPoint::from_frame(frame, receive(2), self.id) {
            follow(point.controlword, point.mode, point.target);
        } else if let Some(joint) = self.joint
            && let Some(motion) = DriveMotion::from_frame(frame, transmit(1), joint)
        {
            self.bench.joint = Some(motion);
        } else if frame.id() == 0x600 + u16::from(self.id) {
            let [low, high] = POSITION_SCALE.to_le_bytes();
            let [a, b] = self.scale.to_le_bytes();
            return Frame::new(
                0x580 + u16::from(self.id),
                &[0x4b, low, high, 0, a, b, 0, 0],
            );
        }
        None
    }
}

fn at_home(home: bool) -> Switches {
    Switches {
        home,
        ..Switches::default()
    }
}

fn settings(spec: &NodeSpec) -> Settings {
    let mut changes = spec.settings.clone();
    changes.push((Setting::NodeId, i32::from(spec.id)));
    bench::settings(&changes)
}

fn node(role: Role, settings: &Settings) -> Node {
    match role {
        Role::Screw => Node::Screw(Screw::new(settings).expect("the robot's geometry is good")),
        _ => Node::Axle(Axle::new(settings)),
    }
}

/// The guard, its drives, and an operator who sends a command every 20 ms.
pub struct Network<B> {
    pub guard: Option<Guard<B>>,
    pub guard_settings: Settings,
    pub drives: Vec<Drive>,
    pub now_us: u64,
    pub command: OperatorCommand,
    /// Whether the operator sends commands.
    pub operator: bool,
    /// Value of object 0x4008, the emergency stop.
    pub emergency_stop: bool,
    pub body: BodySensors,
    /// Frames that another participant sends in the next millisecond.
    pub foreign: Vec<Frame>,
    /// As [`Self::foreign`], but only the guard receives them.
    pub forged: Vec<Frame>,
    /// A second operator, who sends a command with this period and phase, ms.
    pub second: Option<(OperatorCommand, u64, u64)>,
    /// Bits that are flipped in request and sequence number of the operator's next command.
    pub flips: [u8; 2],
    /// Whether the body's sensors give readings.
    pub sensors: bool,
    /// State of the guard as published on the bus.
    pub shown: GuardState,
    /// Frames that the guard sent in the last millisecond.
    pub sent: Vec<Frame>,
    to_guard: Vec<Frame>,
    to_drives: Vec<Frame>,
}

impl<B: Body> Network<B> {
    /// Creates the robot of a shipped scenario, with `changes` to its guard's settings.
    pub fn new(scenario: &str, changes: &[(Setting, i32)]) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        let scenario = Scenario::load(&folder.join(scenario)).expect("a shipped scenario");
        let nodes = scenario.nodes();
        let (drives, guards): (Vec<_>, Vec<_>) =
            nodes.iter().partition(|node| node.role != Role::Guard);
        let mut guard_settings = settings(guards[0]);
        for (setting, value) in changes {
            let key = setting.description().key;
            guard_settings
                .set(key, *value)
                .expect("a value within bounds");
        }
        Self {
            guard: Guard::new(&guard_settings).ok(),
            guard_settings,
            drives: drives.into_iter().map(Drive::new).collect(),
            now_us: 0,
            command: OperatorCommand {
                request: Request::Stop as u8,
                ..OperatorCommand::default()
            },
            operator: true,
            emergency_stop: false,
            body: level(),
            foreign: Vec::new(),
            forged: Vec::new(),
            second: None,
            flips: [0; 2],
            sensors: true,
            shown: GuardState::default(),
            sent: Vec::new(),
            to_guard: Vec::new(),
            to_drives: Vec::new(),
        }
    }

    /// Ends the guard's program; the drives receive no more frames from it.
    pub fn stop_guard(&mut self) {
        self.guard = None;
        self.to_drives.clear();
    }

    /// Restarts the guard without any stored state.
    pub fn start_guard(&mut self) {
        self.guard = Guard::new(&self.guard_settings).ok();
    }

    pub fn state(&self) -> State {
        State::from_code(self.shown.state).expect("a state of the guard")
    }

    pub fn request(&mut self, request: Request) {
        self.command.request = request as u8;
    }

    /// Runs one millisecond.
    pub fn tick(&mut self) {
        self.now_us += 1_000;
        let milliseconds = self.now_us / 1_000;
        let mut to_guard = std::mem::take(&mut self.foreign);
        let mut to_drives = std::mem::take(&mut self.to_drives);
        to_drives.extend(&to_guard);
        let mut joined = Vec::new();
        for drive in &mut self.drives {
            for frame in &to_drives {
                to_guard.extend(drive.receive(frame));
                if let (true, true, Some(outputs)) =
                    (is_sync(frame), drive.operational, &drive.outputs)
                {
                    let motion = outputs.motion.frame(transmit(1), drive.id);
                    joined.push(motion);
                    to_guard.push(motion);
                    // Transmission type 5: the status is sent with every fifth SYNC.
                    drive.syncs += 1;
                    if drive.syncs.is_multiple_of(5) {
                        let status: DriveStatus = outputs.status;
                        to_guard.push(status.frame(transmit(2), drive.id));
                    }
                }
            }
            drive.bench.guard_alive = self.guard.is_some();
            if milliseconds.is_multiple_of(4) && drive.intruder.is_some() {
                drive.bench.set_point = drive.intruder;
            }
            let outputs = drive.bench.tick();
            if milliseconds.is_multiple_of(4) {
                drive.bench.set_point = None;
            }
            if let Some(code) = outputs.emergency {
                to_guard.push(emergency(Emergency {
                    node: drive.id,
                    code,
                }));
            }
            drive.outputs = Some(outputs);
            let heartbeat = 0x700 + u16::from(drive.id);
            if std::mem::take(&mut drive.boots) {
                to_guard.extend(Frame::new(heartbeat, &[0]));
            } else if milliseconds.is_multiple_of(50) {
                let state = if drive.operational { 5 } else { 127 };
                to_guard.extend(Frame::new(heartbeat, &[state]));
            }
        }
        self.to_drives.extend(joined);
        to_guard.append(&mut self.to_guard);
        to_guard.append(&mut self.forged);
        self.tick_guard(&to_guard);
    }

    fn tick_guard(&mut self, frames: &[Frame]) {
        let milliseconds = self.now_us / 1_000;
        let mut operator = (self.operator && milliseconds.is_multiple_of(20)).then(|| {
            self.command.sequence = self.command.sequence.wrapping_add(1);
            let [request, sequence] = std::mem::take(&mut self.flips);
            OperatorCommand {
                request: self.command.request ^ request,
                sequence: self.command.sequence ^ sequence,
                ..self.command
            }
        });
        if let Some((command, period, phase)) = &mut self.second
            && milliseconds % *period == *phase % *period
        {
            command.sequence = command.sequence.wrapping_add(1);
            operator = Some(*command);
        }
        let Some(guard) = &mut self.guard else {
            return;
        };
        // The guard receives its own NMT commands and SYNC in the next tick.
        let own = |frame: &&Frame| frame.id() == 0 || is_sync(frame);
        let outputs = guard.tick(&Inputs {
            now_us: self.now_us,
            body: self.sensors.then(|| noisy(self.body, milliseconds)),
            operator,
            emergency_stop: self.emergency_stop,
            frames,
            serial: &[],
        });
        self.shown = outputs.state;
        self.to_drives.extend(&outputs.frames);
        self.sent = outputs.frames.to_vec();
        self.to_guard = outputs.frames.iter().filter(own).copied().collect();
    }

    pub fn run(&mut self, milliseconds: u32) {
        for _ in 0..milliseconds {
            self.tick();
        }
    }

    /// Runs until the guard is in `state`; panics after 60 s.
    pub fn until(&mut self, state: State) {
        for _ in 0..60_000 {
            if self.state() == state {
                return;
            }
            self.tick();
        }
        panic!("{state:?} is not reached: {:?}", self.shown);
    }

    /// Creates a robot and arms it.
    pub fn armed(scenario: &str, changes: &[(Setting, i32)]) -> Self {
        let mut network = Self::new(scenario, changes);
        network.until(State::Ready);
        network.run(80);
        network.request(Request::Arm);
        network.until(State::Armed);
        network
    }

    /// Maximum speed of an output shaft under power, as a fraction of its limit. Drives that are
    /// off are not included: their rotors have no friction and coast.
    pub fn fastest(&self) -> f64 {
        let powered = self.drives.iter().filter(|drive| drive.under_power());
        powered.map(Drive::speed).fold(0.0, f64::max)
    }

    /// Angles of all output shafts, rad.
    pub fn angles(&self) -> Vec<f64> {
        self.drives.iter().map(|drive| drive.bench.angle).collect()
    }

    pub fn drive(&mut self, id: u8) -> &mut Drive {
        let mut drives = self.drives.iter_mut();
        drives.find(|drive| drive.id == id).expect("a drive")
    }
}

/// Readings on level ground, at rest.
pub fn level() -> BodySensors {
    BodySensors {
        specific_force: [0.0, 0.0, 9.81],
        ..BodySensors::default()
    }
}

/// Adds small noise to a reading, because a real sensor's last digit changes all the time.
fn noisy(mut reading: BodySensors, step: u64) -> BodySensors {
    let noise = |channel: u64| 1e-6 * ((step * 7 + channel * 3) % 5) as f32;
    for (channel, value) in (0..).zip(&mut reading.inclination) {
        *value += noise(channel);
    }
    for (channel, value) in (2..).zip(&mut reading.specific_force) {
        *value += noise(channel);
    }
    for (channel, value) in (5..).zip(&mut reading.angular_rate) {
        *value += noise(channel);
    }
    reading
}
