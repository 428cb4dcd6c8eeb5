//! A drive's node as a value with an ideal current loop and a rotor, on a bus with a guard and
//! other senders.

use crate::can_node::{Memory, parts};
use std::cell::Cell;
use std::rc::Rc;
use tautrack::bus::cia402::State;
use tautrack::bus::pdo::{
    DriveMotion, Payload, PositionSetPoint, VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::capture::{Capture, Request};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{CurrentLoop, Electrical, Excitation, Means, Measurement};
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs};
use tautrack::node::screw::Screw;
use tautrack::roles::drive::{Control, Drive, Measurements, Motor, Readings};
use tautrack::screw::Geometry;
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{FIRST_OBJECT, Setting, Settings};

pub const ID: u8 = 4;
pub const GUARD: u8 = 1;
pub const JOINT: u8 = 5;
/// SYNC period, ms.
pub const SYNC_MS: u64 = 4;

/// Screw of the lead robot: 140 rad/s are 111 mm/s.
pub const SCREW: &[(Setting, i32)] = &[
    (Setting::JointId, JOINT as i32),
    (Setting::GearRatio, 4_000),
    (Setting::VelocityLimit, 140_000),
    (Setting::AccelerationLimit, 2_000_000),
    (Setting::VelocityGain, 300),
    (Setting::VelocityIntegralTime, 30_000),
    (Setting::PositionGain, 60_000),
    (Setting::FollowingLimit, 6_000),
    (Setting::EngageSpeed, 100_000),
];

/// Default settings of the drive with these changes.
fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    let id = (Setting::NodeId, i32::from(ID));
    for (setting, value) in std::iter::once(&id).chain(changes) {
        settings.set(setting.description().key, *value).unwrap();
    }
    settings
}

/// Control core of a drive. It shows its outputs, and reports what a test lets it find.
struct Watched<C> {
    control: C,
    watch: Rc<Watch>,
}

#[derive(Default)]
struct Watch {
    outputs: Cell<Option<Outputs>>,
    found: Cell<Faults>,
}

impl<C: Control> Control for Watched<C> {
    fn axle(&mut self) -> &mut Axle {
        self.control.axle()
    }

    fn tick(&mut self, inputs: Inputs, joint: Option<(DriveMotion, u64)>) -> Outputs {
        let found = self.watch.found.take();
        self.axle().report(found);
        let outputs = self.control.tick(inputs, joint);
        self.watch.outputs.set(Some(outputs));
        outputs
    }

    fn retune(&mut self, settings: &Settings) {
        self.control.retune(settings);
    }
}

type Node<C> = Drive<Watched<C>, Measurements, Memory>;

#[allow(clippy::large_enum_variant)] // there is one at a time
enum Role {
    Axle(Node<Axle>),
    Screw(Node<Screw<Geometry>>),
}

/// Motor whose current is the demanded one, and its shaft.
pub struct Rotor {
    /// Angle, rad, and velocity, rad/s, of the output shaft.
    pub angle: f64,
    pub velocity: f64,
    /// Torque that turns the shaft, N m.
    pub load: f64,
    pub switches: Switches,
    pub current: f32,
    inertia: f64,
    per_ampere: f64,
    counts: f64,
}

impl Rotor {
    /// Turns for a millisecond.
    fn turn(&mut self) {
        let torque = self.per_ampere * f64::from(self.current) + self.load;
        self.velocity += (torque / self.inertia - 0.5 * self.velocity) * 1e-3;
        self.angle += self.velocity * 1e-3;
    }
}

impl Motor for Rotor {
    fn readings(&mut self) -> Readings {
        Readings {
            encoder: (self.angle * self.counts).floor() as i64 as i32,
            encoder_broken: false,
            bridge_stop: None,
            means: Some(Means {
                current: self.current,
                electrical: Electrical::default(),
            }),
            supply_voltage: 24.0,
            temperatures: Temperatures::default(),
            switches: self.switches,
        }
    }

    fn demand(&mut self, demand: BridgeDemand, _: f32, _: f32) {
        self.current = match demand {
            BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => current,
            _ => 0.0,
        };
    }

    fn take_measurement(&mut self, _: f32) -> Option<Measurement> {
        None
    }

    fn capture<R>(&mut self, _: impl FnOnce(&mut Capture) -> R) -> Option<R> {
        None
    }

    fn install(&mut self, _: CurrentLoop) {}

    fn set_limits(&mut self, _: &Settings) {}

    fn set_cogging(&mut self, _: i32, _: Wave) {}

    fn excite(&mut self, _: &Excitation, _: f32) {}

    fn set_brake(&mut self, _: bool) {}

    fn request_capture(&mut self, _: Request) {}
}

/// One drive on the bus.
pub struct Wire {
    role: Role,
    watch: Rc<Watch>,
    pub rotor: Rotor,
    pub now_us: u64,
    /// Frame that the guard sends with each SYNC, and whether its heartbeat is on the bus.
    pub command: Option<Frame>,
    pub guard: bool,
    /// Angle, rad, and rate, rad/s, of the joint that sends its motion with each SYNC.
    pub joint: Option<(f64, f64)>,
    /// What the node has sent in this millisecond.
    sent: Vec<Frame>,
}

impl Wire {
    pub fn axle(changes: &[(Setting, i32)]) -> Self {
        let settings = settings(changes);
        let (control, watch) = watched(Axle::new(&settings));
        let drive = Drive::axle(parts(&settings, control));
        Self::new(Role::Axle(drive), watch, &settings, 0.05)
    }

    /// A screw that is homed at power-up, at extension 0.
    pub fn screw(changes: &[(Setting, i32)]) -> Self {
        let settings = settings(&[SCREW, changes].concat());
        let (control, watch) = watched(Screw::new(&settings).expect("a belt"));
        let drive = Drive::screw(parts(&settings, control));
        let mut wire = Self::new(Role::Screw(drive), watch, &settings, 1.6e-4);
        wire.joint = Some((0.0, 0.0));
        wire
    }

    fn new(role: Role, watch: Rc<Watch>, settings: &Settings, inertia: f64) -> Self {
        let gear = f64::from(settings.get(Setting::GearRatio)) * 1e-3;
        let turn = f64::from(settings.get(Setting::EncoderCounts)) * gear;
        let rotor = Rotor {
            angle: 0.0,
            velocity: 0.0,
            load: 0.0,
            switches: Switches::default(),
            current: 0.0,
            inertia,
            per_ampere: 0.04 * gear,
            counts: turn / std::f64::consts::TAU,
        };
        let mut wire = Self {
            role,
            watch,
            rotor,
            now_us: 0,
            command: None,
            guard: true,
            joint: None,
            sent: Vec::new(),
        };
        wire.boot();
        wire
    }

    /// The node boots, and the guard starts it.
    fn boot(&mut self) {
        let send = &mut |frame| self.sent.push(frame);
        match &mut self.role {
            Role::Axle(drive) => drive.boot(0, send),
            Role::Screw(drive) => drive.boot(0, send),
        }
        self.receive(&Frame::new(0x000, &[1, 0]).unwrap());
    }

    /// Returns the milliseconds since power-up.
    pub fn milliseconds(&self) -> u64 {
        self.now_us / 1_000
    }

    /// Returns the outputs of the last tick; `None` before the first one.
    pub fn last(&self) -> Option<Outputs> {
        self.watch.outputs.get()
    }

    pub fn outputs(&self) -> Outputs {
        self.last().expect("a tick before")
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

    /// The drive finds this fault in its next tick.
    pub fn report(&mut self, fault: Fault) {
        self.watch.found.set(Faults::of(fault));
    }

    /// A client writes an object.
    pub fn write<const N: usize>(&mut self, (index, sub): (u16, u8), value: [u8; N]) {
        let command = 0x23 | (4 - N as u8) << 2;
        let answer = self.request(command, (index, sub), &value);
        assert_eq!(answer[0], 0x60, "{index:#x}:{sub}, {value:x?}");
    }

    /// A client writes a setting. Returns the abort code if the node refuses it.
    pub fn set(&mut self, setting: Setting, value: i32) -> Option<u32> {
        let object = (FIRST_OBJECT + setting.bounds().key, 0);
        self.refusal(object, value.to_le_bytes())
    }

    /// A client saves the settings. Returns the abort code if the node refuses it.
    pub fn save(&mut self) -> Option<u32> {
        self.refusal((0x1010, 1), *b"save")
    }

    fn refusal(&mut self, object: (u16, u8), value: [u8; 4]) -> Option<u32> {
        let answer = self.request(0x23, object, &value);
        let code = u32::from_le_bytes(answer[4..].try_into().expect("four bytes"));
        (answer[0] != 0x60).then_some(code)
    }

    /// A client reads a setting.
    pub fn get(&mut self, setting: Setting) -> i32 {
        i32::from_le_bytes(self.read((FIRST_OBJECT + setting.bounds().key, 0)))
    }

    /// A client reads an object of at most four bytes.
    pub fn read(&mut self, (index, sub): (u16, u8)) -> [u8; 4] {
        let answer = self.request(0x40, (index, sub), &[]);
        assert_eq!(answer[0] & 0xf3, 0x43, "{index:#x}:{sub}");
        answer[4..].try_into().expect("four bytes")
    }

    fn request(&mut self, command: u8, (index, sub): (u16, u8), value: &[u8]) -> [u8; 8] {
        let [low, high] = index.to_le_bytes();
        let mut data = [command, low, high, sub, 0, 0, 0, 0];
        data[4..4 + value.len()].copy_from_slice(value);
        self.sent.clear();
        self.receive(&Frame::new(0x600 + u16::from(ID), &data).unwrap());
        let mut answers = self.sent.iter();
        let answer = answers.rfind(|frame| frame.id() == 0x580 + u16::from(ID));
        answer
            .expect("an answer")
            .data()
            .try_into()
            .expect("eight bytes")
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &Frame) {
        let send = &mut |frame| self.sent.push(frame);
        match &mut self.role {
            Role::Axle(drive) => drive.receive(frame, self.now_us, send),
            Role::Screw(drive) => drive.receive(frame, self.now_us, send),
        }
    }

    /// Runs one millisecond: the guard and the joint send first, then these other senders.
    pub fn tick(&mut self, foreign: &[Frame]) -> Outputs {
        self.now_us += 1_000;
        self.sent.clear();
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
        self.rotor.turn();
        let send = &mut |frame| self.sent.push(frame);
        match &mut self.role {
            Role::Axle(drive) => drive.tick(self.now_us, &mut self.rotor, send),
            Role::Screw(drive) => drive.tick(self.now_us, &mut self.rotor, send),
        };
        self.outputs()
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
        assert_eq!(
            self.state(),
            State::OperationEnabled,
            "{:?}",
            self.outputs()
        );
    }
}

fn watched<C>(control: C) -> (Watched<C>, Rc<Watch>) {
    let watch = Rc::new(Watch::default());
    let watched = Watched {
        control,
        watch: Rc::clone(&watch),
    };
    (watched, watch)
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
