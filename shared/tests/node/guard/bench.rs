//! Test bench: a guard with ideal drives.

use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_START, DriveCommand, State as DriveState, mode, status};
use tautrack::bus::network::sync;
use tautrack::bus::pdo::{
    DriveMotion, DriveStatus, OperatorCommand, Payload, PositionSetPoint, Request,
    VelocitySetPoint, receive, transmit,
};
use tautrack::can::Frame;
use tautrack::node::guard::{Guard, Inputs, Outputs, POSITION_SCALE, State};
use tautrack::robots::b2p2::B2p2;
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::filter::Verdict;

pub const DRIVES: [u8; 4] = [2, 3, 4, 5];
/// Answers of the drives when the guard asks for their position scales.
pub const SCALES: [u16; 4] = [16, 16, 32, 0x118];
pub const JOINT: u8 = 4;
pub const SCREW: u8 = 5;
/// Largest step of the screw in one SYNC period, 2^-24 m: 4 mm.
const SCREW_STEP: i32 = 67_108;
/// Extension at chassis angle 0, 2^-24 m.
pub const TAUT: i32 = (0.226 * 16_777_216.0) as i32;

/// A guard with ideal drives, an operator and level ground, unless a test changes them.
pub struct Bench {
    pub guard: Guard<B2p2>,
    pub now_us: u64,
    pub command: Option<OperatorCommand>,
    pub body: Option<BodySensors>,
    /// The sensors have no noise.
    pub exact: bool,
    pub extra: Vec<Frame>,
    pub silent: Option<u8>,
    /// Position of the chassis joint: the one that the guard commanded last.
    pub joint: i32,
    /// Position of a chassis joint that does not follow.
    pub joint_held: Option<i32>,
    /// Position of the screw: [`TAUT`], or the last target of its own profile.
    pub screw: i32,
    /// States of the network in the drives' heartbeats.
    pub heartbeats: [u8; 4],
    /// Velocities of the tracks, in units of the bus.
    pub velocities: [i32; 2],
    /// Where the screw moves, and the positions that the drives have sent last.
    screw_target: i32,
    published: [i32; 4],
    /// Drives that are homed; another one is homed as soon as the guard requests it.
    pub homed: [bool; 4],
    pub states: [DriveState; 4],
    pub scales: [u16; 4],
    /// Error codes in the drives' status.
    pub errors: [u16; 4],
    pub sent: Vec<Frame>,
    pub emergency_stop: bool,
    /// Until when the drives stay in "switched on" instead of "operation enabled", us, and the bits
    /// that their statuswords show meanwhile.
    pub aligns_until_us: u64,
    pub aligning: u16,
}

impl Bench {
    pub fn armed() -> Self {
        let mut bench = Self::with(&[]);
        let outputs = bench.run(4);
        assert_eq!(State::from_code(outputs.state.state), Some(State::Armed));
        bench
    }

    pub fn with(changes: &[(Setting, i32)]) -> Self {
        let mut settings = Settings::default();
        for (setting, value) in changes {
            settings
                .set(setting.description().key, *value)
                .expect("a value within bounds");
        }
        let mut bench = Self::new(&settings);
        bench.run(200);
        bench.request(Request::Arm);
        bench.run(800);
        bench
    }

    pub fn new(settings: &Settings) -> Self {
        Self {
            guard: Guard::new(settings).expect("the default robot is good"),
            now_us: 0,
            command: Some(OperatorCommand {
                request: Request::Stop as u8,
                ..OperatorCommand::default()
            }),
            body: Some(standing(0.0)),
            exact: false,
            extra: Vec::new(),
            silent: None,
            joint: 0,
            joint_held: None,
            screw: TAUT,
            heartbeats: [5; 4],
            velocities: [0; 2],
            screw_target: TAUT,
            published: [0, 0, 0, TAUT],
            homed: [true; 4],
            states: [DriveState::SwitchOnDisabled; 4],
            scales: SCALES,
            errors: [0; 4],
            sent: Vec::new(),
            emergency_stop: false,
            aligns_until_us: 0,
            aligning: status::ALIGNING,
        }
    }

    /// Returns whether the next tick is one in which something with this period comes, us.
    pub fn next_is(&self, period_us: u64) -> bool {
        (self.now_us + 1_000).is_multiple_of(period_us)
    }

    pub fn run(&mut self, ticks: u64) -> Outputs {
        (0..ticks)
            .map(|_| self.tick())
            .last()
            .expect("at least one tick")
    }

    pub fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        let mut frames = std::mem::take(&mut self.extra);
        for (index, id) in DRIVES.into_iter().enumerate() {
            if self.silent == Some(id) {
                continue;
            }
            if self.now_us.is_multiple_of(50_000) {
                let heartbeat = [self.heartbeats[index]];
                frames.extend(Frame::new(0x700 + u16::from(id), &heartbeat));
            }
            if self.now_us.is_multiple_of(4_000) {
                let ahead = self.screw_target - self.screw;
                self.screw += ahead.clamp(-SCREW_STEP, SCREW_STEP);
                let position = match id {
                    SCREW => self.screw,
                    JOINT => self.joint_held.unwrap_or(self.joint),
                    _ => 0,
                };
                let step = f64::from(position.wrapping_sub(self.published[index]));
                self.published[index] = position;
                let velocity = match id {
                    SCREW => (step / 16_777_216.0 / 0.004 * 1e9) as i32,
                    JOINT => (step / 4_294_967_296.0 * TAU / 0.004 * 1e6) as i32,
                    _ => self.velocities[index],
                };
                frames.push(DriveMotion { position, velocity }.frame(transmit(1), id));
                let mut statusword = self.states[index].statusword();
                if self.homed[index] {
                    statusword |= status::HOMED;
                }
                let waits = self.states[index] == DriveState::SwitchedOn;
                if waits && self.now_us < self.aligns_until_us {
                    statusword |= self.aligning;
                }
                frames.push(
                    DriveStatus {
                        statusword,
                        error_code: self.errors[index],
                        ..DriveStatus::default()
                    }
                    .frame(transmit(2), id),
                );
            }
        }
        let operator = self.command.as_mut().map(|command| {
            command.sequence = command.sequence.wrapping_add(1);
            *command
        });
        let inputs = Inputs {
            now_us: self.now_us,
            body: self.body.map(|reading| {
                if self.exact {
                    reading
                } else {
                    noisy(reading, self.now_us / 1_000)
                }
            }),
            operator,
            emergency_stop: self.emergency_stop,
            frames: &frames,
            serial: &[],
        };
        let outputs = self.guard.tick(&inputs).clone();
        if outputs.frames.first() == Some(&sync()) {
            self.sent = outputs.frames.to_vec();
            self.follow();
        }
        outputs
    }

    /// Makes every drive follow its controlword, and answer a request for its scale.
    pub fn follow(&mut self) {
        if let Some(set_point) = self.position_set_point(JOINT) {
            self.joint = set_point.target;
        }
        if let Some(set_point) = self.position_set_point(SCREW) {
            self.screw_target = if set_point.mode == mode::PROFILE_POSITION {
                set_point.target
            } else {
                TAUT
            };
        }
        for (index, id) in DRIVES.into_iter().enumerate() {
            if let Some(word) = self.controlword(id) {
                let state = &mut self.states[index];
                let after = state.after(DriveCommand::from_controlword(word));
                if after != DriveState::OperationEnabled || self.now_us >= self.aligns_until_us {
                    *state = after;
                }
            }
            let set_point = self.position_set_point(id);
            self.homed[index] |= set_point.is_some_and(|set_point| {
                set_point.mode == mode::HOMING && set_point.controlword & CONTROL_START != 0
            });
            let request = 0x600 + u16::from(id);
            if self.sent.iter().any(|frame| frame.id() == request) {
                let ([low, high], [a, b]) = (
                    POSITION_SCALE.to_le_bytes(),
                    self.scales[index].to_le_bytes(),
                );
                let answer = [0x4b, low, high, 0, a, b, 0, 0];
                self.extra
                    .extend(Frame::new(0x580 + u16::from(id), &answer));
            }
        }
    }

    /// Returns the set-point with a position that the guard sent last to drive `id`.
    pub fn position_set_point(&self, id: u8) -> Option<PositionSetPoint> {
        let mut frames = self.sent.iter();
        frames.find_map(|frame| PositionSetPoint::from_frame(frame, receive(1), id))
    }

    /// Returns the controlword that the guard sent last to drive `id`.
    pub fn controlword(&self, id: u8) -> Option<u16> {
        self.sent.iter().find_map(|frame| {
            let position = PositionSetPoint::from_frame(frame, receive(1), id);
            let velocity = VelocitySetPoint::from_frame(frame, receive(2), id);
            position
                .map(|point| point.controlword)
                .or(velocity.map(|point| point.controlword))
        })
    }

    /// Turns the robot nose up within twelve seconds, as all its sensors show it, and holds it
    /// there.
    pub fn tilt(&mut self, pitch: f32) {
        for step in 0..12_000 {
            let turning = standing(pitch * step as f32 / 12_000.0);
            self.body = Some(BodySensors {
                angular_rate: [0.0, -pitch / 12.0, 0.0],
                ..turning
            });
            self.tick();
        }
        self.body = Some(standing(pitch));
        self.run(3_000);
    }

    pub fn request(&mut self, request: Request) {
        self.command.as_mut().expect("an operator").request = request as u8;
    }

    pub fn ask(&mut self, forward: i16) {
        self.command.as_mut().expect("an operator").forward = forward;
    }

    pub fn track_speeds(&self) -> Vec<i32> {
        let speed = |id| {
            self.sent
                .iter()
                .find_map(|frame| VelocitySetPoint::from_frame(frame, receive(2), id))
        };
        [2, 3]
            .into_iter()
            .filter_map(speed)
            .map(|set_point| set_point.target)
            .collect()
    }
}

pub fn standing(pitch: f32) -> BodySensors {
    BodySensors {
        inclination: [pitch, 0.0],
        // Reading of an accelerometer at this pitch.
        specific_force: [9.81 * pitch.sin(), 0.0, 9.81 * pitch.cos()],
        ..BodySensors::default()
    }
}

/// Returns the same reading with noise in its last digit, as a sensor has it.
pub fn noisy(reading: BodySensors, step: u64) -> BodySensors {
    let noise = |channel: u64| 1e-6 * ((step * 7 + channel * 3) % 5) as f32;
    let [pitch, roll] = reading.inclination;
    let [x, y, z] = reading.specific_force;
    let [rate_x, rate_y, rate_z] = reading.angular_rate;
    BodySensors {
        inclination: [pitch + noise(0), roll + noise(1)],
        specific_force: [x + noise(2), y + noise(3), z + noise(4)],
        angular_rate: [rate_x + noise(5), rate_y + noise(6), rate_z + noise(7)],
        ..reading
    }
}

pub fn verdict(outputs: &Outputs) -> Option<Verdict> {
    Verdict::from_code(outputs.state.verdict)
}
