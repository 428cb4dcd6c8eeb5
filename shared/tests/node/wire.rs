//! A drive with an ideal current loop and a rotor, on a bus with a guard and other senders. Frames
//! reach the tick as the bus task of the firmware passes them.

use tautrack::bus::cia402::State;
use tautrack::bus::network::{NmtState, OFFSET_SYNCS, as_heartbeat, is_of, is_sync};
use tautrack::bus::pace::Pace;
use tautrack::bus::pdo::{
    DriveMotion, Payload, PositionSetPoint, TorqueOffset, VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::current::Electrical;
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};

pub const ID: u8 = 4;
pub const GUARD: u8 = 1;
pub const JOINT: u8 = 5;
/// SYNC period, ms.
pub const SYNC_MS: u64 = 4;
const PERIOD_US: u32 = 4_000;

/// Screw of the lead robot: 140 rad/s are 111 mm/s.
pub const SCREW: &[(Setting, i32)] = &[
    (Setting::GearRatio, 4_000),
    (Setting::VelocityLimit, 140_000),
    (Setting::AccelerationLimit, 2_000_000),
    (Setting::VelocityGain, 300),
    (Setting::VelocityIntegralTime, 30_000),
    (Setting::PositionGain, 60_000),
    (Setting::FollowingLimit, 6_000),
    (Setting::EngageSpeed, 100_000),
];

#[allow(clippy::large_enum_variant)] // there is one at a time
pub enum Node {
    Axle(Axle),
    Screw(Screw),
}

/// Default settings with these changes.
pub fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings.set(setting.description().key, *value).unwrap();
    }
    settings
}

/// One drive on the bus.
pub struct Wire {
    pub node: Node,
    pub now_us: u64,
    /// Angle, rad, and velocity, rad/s, of the output shaft.
    pub angle: f64,
    pub velocity: f64,
    /// Torque that turns the shaft, N m.
    pub load: f64,
    pub switches: Switches,
    pub bench: bool,
    pub outputs: Option<Outputs>,
    /// Frame that the guard sends with each SYNC, and whether its heartbeat is on the bus.
    pub command: Option<Frame>,
    pub guard: bool,
    /// Angle, rad, and rate, rad/s, of the joint that sends its motion with each SYNC.
    pub joint: Option<(f64, f64)>,
    inertia: f64,
    per_ampere: f64,
    counts: f64,
    inbox: Inbox,
    paces: [Pace; 3],
}

#[derive(Default)]
struct Inbox {
    set_point: Option<SetPoint>,
    offset: Option<i16>,
    guard: bool,
    joint: Option<(DriveMotion, u64)>,
    found: Faults,
    sync_us: u64,
}

impl Wire {
    pub fn axle(changes: &[(Setting, i32)]) -> Self {
        let settings = settings(changes);
        Self::new(Node::Axle(Axle::new(&settings)), &settings, 0.05)
    }

    /// A screw that is homed at power-up, at extension 0.
    pub fn screw(changes: &[(Setting, i32)]) -> Self {
        let settings = settings(&[SCREW, changes].concat());
        let screw = Screw::new(&settings).expect("a belt");
        let mut wire = Self::new(Node::Screw(screw), &settings, 1.6e-4);
        wire.joint = Some((0.0, 0.0));
        wire
    }

    fn new(node: Node, settings: &Settings, inertia: f64) -> Self {
        let gear = f64::from(settings.get(Setting::GearRatio)) * 1e-3;
        let turn = f64::from(settings.get(Setting::EncoderCounts)) * gear;
        Self {
            node,
            now_us: 0,
            angle: 0.0,
            velocity: 0.0,
            load: 0.0,
            switches: Switches::default(),
            bench: false,
            outputs: None,
            command: None,
            guard: true,
            joint: None,
            inertia,
            per_ampere: 0.04 * gear,
            counts: turn / std::f64::consts::TAU,
            inbox: Inbox::default(),
            paces: [Pace::NEW; 3],
        }
    }

    /// Returns the milliseconds since power-up.
    pub fn milliseconds(&self) -> u64 {
        self.now_us / 1_000
    }

    pub fn outputs(&self) -> &Outputs {
        self.outputs.as_ref().expect("a tick before")
    }

    pub fn state(&self) -> State {
        State::from_statusword(self.outputs().status.statusword).expect("a state")
    }

    pub fn has(&self, fault: Fault) -> bool {
        self.outputs().faults.contains(fault)
    }

    pub fn powered(&self) -> bool {
        matches!(
            self.outputs().bridge,
            BridgeDemand::Current(_) | BridgeDemand::Braking { .. }
        )
    }

    pub fn axle_mut(&mut self) -> &mut Axle {
        match &mut self.node {
            Node::Axle(axle) => axle,
            Node::Screw(screw) => screw.axle_mut(),
        }
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &Frame) {
        let (now_us, inbox) = (self.now_us, &mut self.inbox);
        let [set_points, offsets, motions] = &mut self.paces;
        if is_sync(frame) {
            inbox.sync_us = now_us;
        }
        inbox.found.insert_if(Fault::DuplicateId, is_of(frame, ID));
        inbox.guard |= as_heartbeat(frame) == Some((GUARD, NmtState::Operational));
        let position = PositionSetPoint::from_frame(frame, receive(1), ID);
        let position = position.map(|point| (point.controlword, point.mode, point.target));
        let velocity = VelocitySetPoint::from_frame(frame, receive(2), ID);
        let velocity = velocity.map(|point| (point.controlword, point.mode, point.target));
        if let Some((controlword, mode, target)) = position.or(velocity) {
            inbox.set_point = Some(SetPoint {
                controlword,
                mode,
                target,
            });
            let second = set_points.is_exceeded(now_us, PERIOD_US);
            inbox.found.insert_if(Fault::SecondMaster, second);
        } else if let Some(offset) = TorqueOffset::from_frame(frame, receive(3), ID) {
            inbox.offset = Some(offset.torque);
            let second = offsets.is_exceeded(now_us, PERIOD_US * OFFSET_SYNCS);
            inbox.found.insert_if(Fault::SecondMaster, second);
        } else if let Node::Screw(_) = self.node
            && let Some(motion) = DriveMotion::from_frame(frame, transmit(1), JOINT)
        {
            inbox.joint = Some((motion, inbox.sync_us.saturating_sub(1_000)));
            let second = motions.is_exceeded(now_us, PERIOD_US);
            inbox.found.insert_if(Fault::DuplicateId, second);
        }
    }

    /// Runs one millisecond: the guard and the joint send first, then these other senders.
    pub fn tick(&mut self, foreign: &[Frame]) -> &Outputs {
        self.now_us += 1_000;
        let milliseconds = self.milliseconds();
        if self.guard && milliseconds % 50 == 1 {
            self.receive(&Frame::new(0x700 + u16::from(GUARD), &[5]).unwrap());
        }
        if milliseconds.is_multiple_of(SYNC_MS) {
            self.receive(&tautrack::bus::network::sync());
            if let Some((angle, rate)) = self.joint {
                self.receive(&motion(angle, rate));
            }
            if let Some(command) = self.command {
                self.receive(&command);
            }
        }
        for frame in foreign {
            self.receive(frame);
        }
        self.turn();
        let inputs = self.inputs();
        let joint = self.inbox.joint.take();
        let outputs = match &mut self.node {
            Node::Axle(axle) => axle.tick(&inputs),
            Node::Screw(screw) => screw.tick(&screw::Inputs {
                axle: inputs,
                joint,
                slack: 0,
            }),
        };
        self.bench &= outputs.bench_mode;
        self.outputs.insert(outputs)
    }

    fn inputs(&mut self) -> Inputs {
        let found = std::mem::take(&mut self.inbox.found);
        self.axle_mut().report(found);
        Inputs {
            now_us: self.now_us,
            encoder: (self.angle * self.counts).floor() as i64 as i32,
            encoder_broken: false,
            current: self.current(),
            electrical: Electrical::default(),
            supply_voltage: 24.0,
            temperatures: Temperatures::default(),
            switches: self.switches,
            set_point: self.inbox.set_point.take(),
            torque_offset: self.inbox.offset.take(),
            guard_received: std::mem::take(&mut self.inbox.guard),
            bench_mode: self.bench,
        }
    }

    fn current(&self) -> f32 {
        match self.outputs.map(|outputs| outputs.bridge) {
            Some(BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. }) => current,
            _ => 0.0,
        }
    }

    /// Turns the rotor for a millisecond.
    fn turn(&mut self) {
        let torque = self.per_ampere * f64::from(self.current()) + self.load;
        self.velocity += (torque / self.inertia - 0.5 * self.velocity) * 1e-3;
        self.angle += self.velocity * 1e-3;
    }

    pub fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.tick(&[]);
        }
    }

    /// The guard leads the drive to operation in `mode` with `target`.
    pub fn operate(&mut self, mode: i8, target: i32) {
        for word in [0x06, 0x07, 0x0f] {
            self.command = Some(set_point(word, mode, target));
            self.run(60);
        }
        assert_eq!(self.state(), State::OperationEnabled, "{:?}", self.outputs);
    }
}

/// Frame with a set-point for the drive.
pub fn set_point(controlword: u16, mode: i8, target: i32) -> Frame {
    if matches!(mode, 3 | 9) {
        let point = VelocitySetPoint {
            controlword,
            mode,
            target,
        };
        return point.frame(receive(2), ID);
    }
    let point = PositionSetPoint {
        controlword,
        mode,
        target,
    };
    point.frame(receive(1), ID)
}

/// Frame with the joint's motion: an angle, rad, and a rate, rad/s.
pub fn motion(angle: f64, rate: f64) -> Frame {
    let motion = DriveMotion {
        position: (angle / std::f64::consts::TAU * 4_294_967_296.0) as i64 as i32,
        velocity: (rate * 1e6) as i32,
    };
    motion.frame(transmit(1), JOINT)
}
