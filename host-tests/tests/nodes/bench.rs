//! Test bench for one axle or screw: the tick of its firmware, an ideal current loop, and a rotor.

use std::f64::consts::TAU;
use tautrack::bus::cia402::{State, controlword};
use tautrack::bus::pdo::DriveMotion;
use tautrack::motor::current::Electrical;
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};

/// Number of ticks, of 1 ms each, per SYNC period.
pub const TICKS_PER_SYNC: u64 = 4;

/// Control core of the node on the bench.
#[allow(clippy::large_enum_variant)] // only one exists
pub enum Node {
    /// An axle.
    Axle(Axle),
    /// A screw; the bench also sends it the joint's motion.
    Screw(Screw),
}

/// Test bench: control core, motor, and the master that sends set-points.
pub struct Bench {
    pub node: Node,
    pub now_us: u64,
    /// Output shaft: angle, rad, velocity, rad/s, and torque of the load, N m.
    pub angle: f64,
    pub velocity: f64,
    pub load: f64,
    /// Whether the rotor is blocked.
    pub stuck: bool,
    /// Set-point that the master sends with every SYNC; `None` if it sends none.
    pub set_point: Option<SetPoint>,
    /// Torque feed-forward that the master sends with every fourth SYNC.
    pub torque_offset: Option<i16>,
    pub guard_alive: bool,
    /// Whether a client requests bench mode. Becomes false when bench mode ends, like the object
    /// 2001h.
    pub client: bool,
    /// Motion of the chassis joint, sent to a screw with every SYNC.
    pub joint: Option<DriveMotion>,
    /// 1, or -1 if the channels of the encoder are swapped, so that it counts backward.
    pub encoder_sign: i32,
    /// State of the switches at an angle relative to `switch_at`.
    pub switches: fn(f64) -> Switches,
    pub switch_at: f64,
    /// Replaces the current reading, if it is set.
    pub current_reading: Option<f32>,
    bridge: BridgeDemand,
    counts_per_radian: f64,
    torque_constant: f64,
    /// Inertia at the output shaft, kg m^2.
    pub inertia: f64,
    resistance: f64,
    current_limit: f64,
}

/// Default settings with these changes.
pub fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings
            .set(setting.description().key, *value)
            .unwrap_or_else(|error| panic!("{error}"));
    }
    settings
}

impl Bench {
    /// Creates a node at rest, with a guard that is alive and a master that sends nothing. Rotor
    /// and load have `inertia` at the output shaft, kg m^2.
    pub fn new(node: Node, settings: &Settings, inertia: f64) -> Self {
        let gear = f64::from(settings.get(Setting::GearRatio)) * 1e-3;
        Self {
            node,
            now_us: 0,
            angle: 0.0,
            velocity: 0.0,
            load: 0.0,
            stuck: false,
            set_point: None,
            torque_offset: None,
            guard_alive: true,
            client: false,
            encoder_sign: 1,
            joint: None,
            switches: |_| Switches::default(),
            switch_at: 0.0,
            current_reading: None,
            bridge: BridgeDemand::Off,
            counts_per_radian: f64::from(settings.get(Setting::EncoderCounts)) * gear / TAU,
            torque_constant: f64::from(settings.get(Setting::TorqueConstant)) * 1e-6 * gear,
            inertia,
            resistance: f64::from(settings.get(Setting::Resistance)) * 1e-3,
            current_limit: f64::from(settings.get(Setting::CurrentLimit)) * 1e-3,
        }
    }

    /// Creates an axle with the default settings and these changes.
    pub fn axle(changes: &[(Setting, i32)]) -> Self {
        let settings = settings(changes);
        Self::new(Node::Axle(Axle::new(&settings)), &settings, 0.05)
    }

    /// Runs one millisecond.
    pub fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        let milliseconds = self.now_us / 1_000;
        let current = self.turn();
        let sync = milliseconds.is_multiple_of(TICKS_PER_SYNC);
        let counts = (self.angle * self.counts_per_radian).floor() as i32;
        let inputs = Inputs {
            now_us: self.now_us,
            encoder: self.encoder_sign * counts,
            encoder_broken: false,
            bridge_stop: None,
            current: self.current_reading.unwrap_or(current as f32),
            electrical: Electrical::default(),
            supply_voltage: 24.0,
            temperatures: Temperatures::default(),
            switches: (self.switches)(self.angle - self.switch_at),
            set_point: self.set_point.filter(|_| sync),
            torque_offset: self
                .torque_offset
                .filter(|_| milliseconds.is_multiple_of(4 * TICKS_PER_SYNC)),
            // The guard's first heartbeat comes before the first set-point.
            guard_received: self.guard_alive && milliseconds % 50 == 1,
            bench_mode: self.client,
        };
        let outputs = match &mut self.node {
            Node::Axle(axle) => axle.tick(&inputs),
            Node::Screw(screw) => screw.tick(&screw::Inputs {
                axle: inputs,
                joint: self
                    .joint
                    .filter(|_| sync)
                    .map(|joint| (joint, self.now_us)),
            }),
        };
        self.bridge = outputs.bridge;
        self.client &= outputs.bench_mode;
        outputs
    }

    /// Moves the rotor by one millisecond; returns its mean current.
    fn turn(&mut self) -> f64 {
        let back_emf = self.torque_constant * self.velocity;
        let current = match self.bridge {
            // This motor needs no alignment.
            BridgeDemand::Off | BridgeDemand::Align { .. } | BridgeDemand::Aligned(_) => 0.0,
            BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => {
                f64::from(current)
            }
            // The PWM interrupt opens the bridge where the current exceeds its limit.
            BridgeDemand::Brake => {
                let limit = self.current_limit;
                (-back_emf / self.resistance).clamp(-limit, limit)
            }
        };
        if self.stuck {
            self.velocity = 0.0;
            return current;
        }
        // The brake is stiff, so its torque `-k^2 / R * velocity` is solved implicitly.
        let drag = match self.bridge {
            BridgeDemand::Brake => self.torque_constant.powi(2) / self.resistance,
            _ => 0.0,
        };
        let driving = match self.bridge {
            BridgeDemand::Current(_) | BridgeDemand::Braking { .. } => {
                self.torque_constant * current
            }
            _ => 0.0,
        };
        let push = (driving - self.load) / self.inertia;
        self.velocity = (self.velocity + push * 1e-3) / (1.0 + drag / self.inertia * 1e-3);
        self.angle += self.velocity * 1e-3;
        current
    }

    /// Runs this many milliseconds; returns the last outputs.
    pub fn run(&mut self, milliseconds: usize) -> Outputs {
        let mut last = None;
        for _ in 0..milliseconds {
            last = Some(self.tick());
        }
        last.expect("at least one tick")
    }

    /// Enables the drive in `mode` with `target`, and runs until it has been enabled for 100 ms.
    pub fn enable(&mut self, mode: i8, target: i32) -> Outputs {
        self.enable_quietly(mode, target);
        self.run(108)
    }

    /// Sends the first controlwords that enable the drive and sets the last one, which is not sent
    /// yet.
    pub fn enable_quietly(&mut self, mode: i8, target: i32) {
        for word in [controlword::SHUTDOWN, controlword::SWITCH_ON] {
            self.command(word, mode, target);
            self.run(8);
        }
        self.command(controlword::ENABLE_OPERATION, mode, target);
    }

    /// Sets what the master sends from now on.
    pub fn command(&mut self, controlword: u16, mode: i8, target: i32) {
        self.set_point = Some(SetPoint {
            controlword,
            mode,
            target,
        });
    }
}

/// State of the drive in the statusword.
pub fn state(outputs: &Outputs) -> Option<State> {
    State::from_statusword(outputs.status.statusword)
}
