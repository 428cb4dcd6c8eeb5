//! Generates random events for a drive, its rotor and its surroundings.

use tautrack::bus::cia402::{State, toward_operation};
use tautrack::bus::drive_parameters::DriveParameters;
use tautrack::bus::pace::Pace;
use tautrack::bus::pdo::DriveMotion;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::current::Electrical;
use tautrack::motor::index::Finding;
use tautrack::motor::rotor::ElectricalAngle;
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// `SplitMix64`: a fast random generator. Every seed gives another sequence.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        // The states are far apart, so that no sequence is the rest of another one.
        let state = Self(seed).bits();
        Self(state)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }

    /// Returns true once in `times` calls, on average.
    pub fn once_in(&mut self, times: u64) -> bool {
        self.below(times) == 0
    }

    pub fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len() as u64) as usize]
    }
}

/// What a sequence tests, besides random events.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Axle,
    Screw,
    /// An axle with a holding brake.
    Braked,
    /// An axle with a three-phase motor.
    ThreePhase,
    /// An axle with a three-phase motor whose encoder only counts and has an index, and with a
    /// holding brake.
    Incremental,
    /// An axle with a three-phase motor whose absolute rotor sensor is checked at arming.
    Checked,
    /// An axle that homes, with a switch that is never found.
    NoSwitch,
    /// An axle that homes, with a switch that seems to close at a wrong place.
    FalseSwitch,
}

impl Kind {
    pub fn of(seed: u64) -> Self {
        match seed % 80 {
            0 => Self::NoSwitch,
            1 | 2 => Self::FalseSwitch,
            3..=12 => Self::Screw,
            13..=16 => Self::Braked,
            17..=19 => Self::Incremental,
            20..=21 => Self::Checked,
            22..=36 => Self::ThreePhase,
            _ => Self::Axle,
        }
    }

    pub fn has_brake(self) -> bool {
        matches!(self, Self::Braked | Self::Incremental)
    }

    pub fn is_three_phase(self) -> bool {
        matches!(self, Self::ThreePhase | Self::Incremental | Self::Checked)
    }

    /// Whether the rotor is aligned at arming.
    pub fn aligns(self) -> bool {
        self.rotor_sensor() != 0
    }

    fn rotor_sensor(self) -> i32 {
        match self {
            Self::Incremental => 3,
            Self::Checked => 2,
            _ => 0,
        }
    }
}

#[allow(clippy::large_enum_variant)] // there is one at a time
enum Node {
    Axle(Axle),
    Screw(Screw),
}

/// Time in which the brake of [`Kind::Braked`] engages.
pub const BRAKE_ENGAGE_MS: i32 = 30;

/// How the rotor responds to a current.
#[derive(Clone, Copy, PartialEq)]
enum Rotor {
    /// Normally.
    Turns,
    /// With swapped encoder channels, and with this inertia, kg m^2.
    Swapped(f64),
    Stuck,
    /// Turns at this speed, rad/s, whatever the current is.
    Dragged(f32),
    /// Its encoder jumps.
    Jumps,
}

/// What the readings of the motor hide or show, besides its current.
#[derive(Clone, Copy, PartialEq)]
enum Trouble {
    None,
    /// A voltage of this many V that nothing explains, in q.
    Voltage(f32),
    /// The same, and no current flows.
    OpenLead(f32),
    /// The rotor's angle is wrong by this angle, rad.
    Angle(f32),
    /// The PWM interrupt has opened the bridge.
    OverCurrent,
    Overrun,
    /// The bridge has this temperature, degree Celsius.
    Temperature(Option<f32>),
}

/// Temperature at which every drive raises "over-temperature", degree Celsius.
pub const TEMPERATURE_LIMIT: f32 = 80.0;

/// Current limit of every drive, A: the default in the table of settings.
pub const CURRENT_LIMIT: f32 = 10.0;

/// Which other nodes are present in an event.
#[derive(Clone, Copy)]
struct Present {
    guard: bool,
    master: bool,
    joint: bool,
}

pub struct Generator {
    random: Random,
    kind: Kind,
    node: Node,
    now_us: u64,
    ticks: u64,
    rotor: Rotor,
    trouble: Trouble,
    angle: f64,
    velocity: f64,
    bridge: BridgeDemand,
    current: Option<f32>,
    supply_voltage: f32,
    switches: Switches,
    present: Present,
    bench: bool,
    /// Controlword for the whole event; `None` for the controlwords that lead to operation.
    word: Option<u16>,
    resets: bool,
    state: State,
    faulty: bool,
    mode: i8,
    target: i32,
    /// Another master's set-point, and every how many ticks it comes.
    second: Option<(SetPoint, u64)>,
    pace: Pace,
    /// Draws the frames of others.
    others: Random,
    /// When the guard was received last, us.
    guard_us: Option<u64>,
    /// Faults that the bus shows in this tick.
    pub found: Faults,
}

/// Inertia of the rotor and its load, kg m^2.
const INERTIA: f64 = 0.05;
/// Electrical turns per turn of the output shaft.
const ELECTRICAL: f64 = 7.0 * 60.0;
const COUNTS_PER_RADIAN: f64 = 4_096.0 * 60.0 / std::f64::consts::TAU;

impl Generator {
    pub fn new(random: Random, kind: Kind) -> Self {
        let mut settings = Settings::default();
        if matches!(kind, Kind::NoSwitch | Kind::FalseSwitch) {
            let key = Setting::HomingDirection.description().key;
            settings.set(key, 1).expect("within its bounds");
        }
        if kind.has_brake() {
            for (setting, time) in [
                (Setting::BrakeReleaseTime, 20),
                (Setting::BrakeEngageTime, BRAKE_ENGAGE_MS),
                (Setting::ProbeCurrent, 1_000),
            ] {
                let key = setting.description().key;
                settings.set(key, time).expect("within its bounds");
            }
        }
        let temperature = Setting::BridgeTemperature.description().key;
        settings
            .set(temperature, 10 * TEMPERATURE_LIMIT as i32)
            .expect("within its bounds");
        for (setting, value) in [
            (Setting::MotorKind, kind.is_three_phase().into()),
            (Setting::RotorSensor, kind.rotor_sensor()),
        ] {
            let key = setting.description().key;
            settings.set(key, value).expect("within its bounds");
        }
        let node = if kind == Kind::Screw {
            Node::Screw(Screw::new(&settings).expect("the nominal geometry"))
        } else {
            Node::Axle(Axle::new(&settings))
        };
        let others = Random(random.0.rotate_left(32));
        Self {
            random,
            kind,
            node,
            now_us: 0,
            ticks: 0,
            rotor: Rotor::Turns,
            trouble: Trouble::None,
            angle: 0.0,
            velocity: 0.0,
            bridge: BridgeDemand::Off,
            current: None,
            supply_voltage: 24.0,
            switches: Switches::default(),
            present: Present {
                guard: true,
                master: true,
                joint: true,
            },
            bench: false,
            word: None,
            resets: false,
            state: State::SwitchOnDisabled,
            faulty: false,
            mode: 9,
            target: 0,
            second: None,
            pace: Pace::NEW,
            others,
            guard_us: None,
            found: Faults::NONE,
        }
    }

    /// Returns the rad/s of the output shaft per unit of velocity on the bus. A screw of 5 mm per
    /// turn publishes 1e-9 m/s.
    pub fn velocity_unit(&self) -> f32 {
        match self.node {
            Node::Axle(_) => 1e-6,
            Node::Screw(_) => 1e-9 / 5e-3 * std::f32::consts::TAU,
        }
    }

    /// Chooses what event number `event` changes. Returns the length of the event in ticks.
    #[allow(clippy::too_many_lines)] // one case for each kind of event
    pub fn next_event(&mut self, event: usize) -> u64 {
        if event < 12 && matches!(self.kind, Kind::NoSwitch | Kind::FalseSwitch) {
            return self.homing_event(event);
        }
        if self.kind.aligns() && (event == 0 || self.random.once_in(30)) {
            return self.alignment_event();
        }
        let random = &mut self.random;
        // Most of the time everything is normal, so that operation is reached. Sometimes one or two
        // things are not.
        self.rotor = match random.below(24) {
            0 => Rotor::Stuck,
            1 => Rotor::Swapped(INERTIA),
            2 => Rotor::Dragged(random.pick(&[0.2, -0.3, 1.5, -4.0, 7.0, 9.0, -11.0])),
            3 if random.once_in(4) => Rotor::Jumps,
            _ => Rotor::Turns,
        };
        self.current = match random.below(40) {
            0 => Some(random.pick(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY])),
            1 => Some(random.pick(&[80.0, -13.0, 12.6])),
            2 => Some(f32::from_bits(random.bits() as u32)),
            _ => None,
        };
        self.supply_voltage = match random.below(40) {
            0 => random.pick(&[10.0, 0.0, 11.9, -24.0]),
            1 => random.pick(&[33.0, 60.0]),
            2 => f32::from_bits(random.bits() as u32),
            _ => 24.0,
        };
        self.trouble = match random.below(150) {
            0 => Trouble::OverCurrent,
            1 => Trouble::Overrun,
            2 => Trouble::Temperature(random.pick(&[None, Some(f32::NAN), Some(81.0)])),
            3 => Trouble::Voltage(f32::from_bits(random.bits() as u32)),
            _ => Trouble::None,
        };
        let bits = random.bits();
        if bits.is_multiple_of(8) {
            self.switches = Switches {
                home: bits & 0x100 != 0,
                positive_limit: bits & 0x600 == 0,
                negative_limit: bits & 0x1800 == 0,
            };
        }
        self.present.guard = if self.present.guard {
            !random.once_in(25)
        } else {
            random.once_in(3)
        };
        self.present.master = if self.present.master {
            !random.once_in(25)
        } else {
            random.once_in(3)
        };
        self.present.joint = !random.once_in(10);
        self.bench = random.once_in(if self.present.guard { 30 } else { 3 });
        self.word = match random.below(8) {
            0 => Some(random.pick(&[0x00, 0x02, 0x06, 0x07, 0x10f, 0x80, 0x82, 0x8f, 0x86])),
            1 => Some(random.pick(&[0x0f, 0x1f, 0x8f])),
            2 if random.once_in(3) => Some(random.bits() as u16),
            _ => None,
        };
        self.resets = !random.once_in(3);
        if random.once_in(4) {
            let taut = if self.kind == Kind::Screw { -1 } else { 9 };
            self.mode = random.pick(&[9, 9, 3, 8, 1, 6, 10, taut, taut, 77]);
        }
        let others = &mut self.others;
        self.second = others.once_in(40).then(|| {
            let point = SetPoint {
                controlword: others.pick(&[0x00, 0x02, 0x06, 0x07, 0x0f, 0x8f, 0x82]),
                mode: others.pick(&[9, 3, 8, 1, 10, 77]),
                target: others.pick(&[0, 5_900_000, -5_900_000]),
            };
            (point, others.pick(&[1, 2, 3, 5]))
        });
        // A client's parameters: a node refuses them while its guard is alive.
        let guarded = self.guard_us.is_some_and(|at| self.now_us <= at + 121_000);
        if random.once_in(12)
            && let Node::Axle(axle) = &mut self.node
        {
            let parameters = DriveParameters {
                quick_stop: random.pick(&[0, 1, 2, 5, 6, 6, 6]),
                shutdown: random.pick(&[0, 1]),
                disable_operation: random.pick(&[0, 1]),
                halt: random.pick(&[1, 2]),
                fault_reaction: random.pick(&[0, 1, 2, 2, 2, 2]),
                following_window: random.bits() as u32,
                following_time: random.bits() as u16,
                position_window: random.bits() as u32,
                position_time: random.bits() as u16,
                position_limits: [random.bits() as i32, random.bits() as i32],
                profile_velocity: u32::MAX,
                profile_acceleration: u32::MAX,
                torque_slope: random.pick(&[1, 24_000, u32::MAX]),
                homing_method: axle.parameters().homing_method,
            };
            if !guarded {
                axle.configure(&parameters);
            }
        }
        if random.once_in(3) {
            self.target = match random.below(4) {
                0 => random.bits() as i32,
                1 => random.pick(&[0, 500_000, -500_000]),
                _ => random.pick(&[5_900_000, -5_900_000, 30_000_000]),
            };
        }
        match random.below(200) {
            0 | 1 => {
                self.now_us += random.below(1_000_000);
                1
            }
            // These events last long enough for the longest dwell.
            2..=7 => {
                self.second = None;
                self.rotor = random.pick(&[
                    Rotor::Stuck,
                    Rotor::Dragged(0.2),
                    Rotor::Dragged(-0.3),
                    Rotor::Turns,
                    Rotor::Swapped(6.0 * INERTIA),
                ]);
                (self.current, self.supply_voltage) = (None, 24.0);
                (self.present.guard, self.present.master) = (true, true);
                110 + random.below(30)
            }
            8 | 9 => {
                self.second = None;
                (self.current, self.supply_voltage) = (None, 24.0);
                (self.present.guard, self.present.master) = (true, true);
                self.rotor = Rotor::Turns;
                self.trouble = match random.below(4) {
                    0 => Trouble::Voltage(random.pick(&[30.0, -30.0])),
                    1 => {
                        self.rotor = Rotor::Dragged(3.0);
                        self.current = Some(0.0);
                        Trouble::OpenLead(random.pick(&[30.0, -30.0]))
                    }
                    2 => {
                        self.rotor = Rotor::Dragged(random.pick(&[2.0, -3.0, 4.0]));
                        Trouble::Angle(random.pick(&[0.7, -0.7, 1.1]))
                    }
                    _ => Trouble::Temperature(random.pick(&[None, Some(81.0), Some(200.0)])),
                };
                if matches!(self.trouble, Trouble::Angle(_)) {
                    330
                } else {
                    110
                }
            }
            _ => 1 + random.below(4),
        }
    }

    /// Time in which an alignment may end, with a rotor that follows or not.
    fn alignment_event(&mut self) -> u64 {
        let random = &mut self.random;
        self.rotor = match random.below(6) {
            0 => Rotor::Stuck,
            1 => Rotor::Swapped(INERTIA),
            2 => Rotor::Dragged(random.pick(&[0.05, -1.0])),
            _ => Rotor::Turns,
        };
        (self.current, self.supply_voltage, self.trouble) = (None, 24.0, Trouble::None);
        (self.present.guard, self.present.master) = (true, true);
        (self.bench, self.word, self.resets) = (false, None, true);
        self.switches = Switches::default();
        1_200 + random.below(200)
    }

    /// Homing from power-up, with a switch that is not found, or that seems to close at a wrong
    /// place.
    fn homing_event(&mut self, event: usize) -> u64 {
        self.mode = 6;
        self.rotor = Rotor::Turns;
        // Shutdown, switch on, enable operation; then the edge that starts homing.
        self.word = Some([0x06, 0x07, 0x0f, 0x1f][event.min(3)]);
        let false_switch = self.kind == Kind::FalseSwitch;
        self.switches.home = false_switch && matches!(event, 5 | 8);
        match (event, false_switch) {
            (0..=3, _) => 8,
            (4, _) => 40 + self.random.below(40),
            // The switch is closed long enough to count, then open until the drive is back again.
            (5, true) => 12,
            (7, true) => 600,
            (8, true) => 20,
            (5, false) => 20_100,
            _ => 4,
        }
    }

    fn word(&mut self) -> u16 {
        if self.faulty && self.resets && self.word.is_none() {
            // The reset is a pulse: its edge needs a set-point without the bit before.
            return if self.random.once_in(2) { 0x82 } else { 0x02 };
        }
        self.word.unwrap_or_else(|| toward_operation(self.state))
    }

    /// Returns the inputs of the next tick, and when the newest motion of the joint was measured,
    /// us.
    pub fn inputs(&mut self) -> (Inputs, Option<u64>) {
        self.now_us += 1_000;
        self.ticks += 1;
        self.turn();
        let sync = self.ticks.is_multiple_of(4);
        let glitch = self.random.once_in(200);
        let word = self.word();
        let commanded = match self.bridge {
            BridgeDemand::Current(current)
            | BridgeDemand::Braking { current, .. }
            | BridgeDemand::Align { current, .. } => current,
            BridgeDemand::Off | BridgeDemand::Brake | BridgeDemand::Aligned(_) => 0.0,
        };
        let guard_received = self.present.guard && self.ticks % 50 == 1;
        if guard_received {
            self.guard_us = Some(self.now_us);
        }
        let master = (sync && self.present.master).then_some(SetPoint {
            controlword: word,
            mode: self.mode,
            target: self.target,
        });
        let second = self
            .second
            .filter(|(_, every)| self.ticks.is_multiple_of(*every));
        let second = second.map(|(point, _)| point);
        for _ in master.iter().chain(&second) {
            let exceeded = self.pace.is_exceeded(self.now_us, 4_000);
            self.found.insert_if(Fault::SecondMaster, exceeded);
        }
        let homes = matches!(self.kind, Kind::NoSwitch | Kind::FalseSwitch);
        let own = self.others.once_in(5_000) && !homes;
        self.found.insert_if(Fault::DuplicateId, own);
        let inputs = Inputs {
            now_us: self.now_us,
            encoder: (self.angle * COUNTS_PER_RADIAN) as i64 as i32,
            encoder_broken: false,
            bridge_stop: None,
            current: if glitch {
                80.0
            } else {
                self.current.unwrap_or(commanded)
            },
            electrical: self.electrical(commanded),
            supply_voltage: self.supply_voltage,
            temperatures: Temperatures {
                bridge: match self.trouble {
                    Trouble::Temperature(temperature) => temperature,
                    _ => Some(25.0),
                },
                motor: None,
            },
            switches: self.switches,
            set_point: second.or(master),
            torque_offset: None,
            guard_received,
            bench_mode: self.bench,
        };
        let joint_us = (sync && self.present.joint).then_some(self.now_us);
        (inputs, joint_us)
    }

    /// Returns the readings of the bridge for this current, A.
    fn electrical(&mut self, current: f32) -> Electrical {
        let driven = matches!(
            self.bridge,
            BridgeDemand::Current(_) | BridgeDemand::Braking { .. } | BridgeDemand::Align { .. }
        );
        let (mut d, mut q) = (0.0, 0.6 * current);
        let emf = if self.kind.is_three_phase() { 1.6 } else { 2.4 } * self.velocity as f32;
        match self.trouble {
            Trouble::Angle(error) => {
                d += emf * error.sin();
                q += emf * error.cos();
            }
            Trouble::Voltage(more) | Trouble::OpenLead(more) => q += emf + more,
            _ => q += emf,
        }
        if self.kind.is_three_phase() {
            d -= 60.0 * 7.0 * 3e-4 * self.velocity as f32 * current;
        }
        Electrical {
            voltage: driven.then_some([d, q]),
            ahead: self.ahead(),
            index: self.index(),
            over_current: self.trouble == Trouble::OverCurrent,
            overrun: self.trouble == Trouble::Overrun,
            ..Electrical::default()
        }
    }

    /// Returns what the index shows: nothing wrong, in most ticks.
    fn index(&mut self) -> Finding {
        if self.kind != Kind::Incremental {
            return Finding::Nothing;
        }
        let wrong = self.random.once_in(2_000);
        if wrong {
            self.random.pick(&[Finding::Misaligned, Finding::Lost])
        } else {
            Finding::Confirmed
        }
    }

    /// Returns how far the field of an alignment is ahead of the rotor's sensor. A rotor that turns
    /// follows the field.
    fn ahead(&mut self) -> Option<ElectricalAngle> {
        let BridgeDemand::Align { field, .. } = self.bridge else {
            return None;
        };
        let turned = Angle::from_radians((self.angle * ELECTRICAL) as f32);
        let sensed = match self.rotor {
            Rotor::Turns => field.0,
            Rotor::Swapped(_) => -field.0,
            Rotor::Jumps => Angle::from_bits(self.random.bits() as i32),
            Rotor::Stuck | Rotor::Dragged(_) => turned,
        };
        Some(ElectricalAngle(field.0 - sensed + Angle::QUARTER_TURN))
    }

    /// Runs one tick of the drive.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        let found = std::mem::take(&mut self.found);
        let outputs = match &mut self.node {
            Node::Axle(axle) => {
                axle.report(found);
                axle.tick(inputs)
            }
            Node::Screw(screw) => {
                screw.axle_mut().report(found);
                let sync = self.ticks.is_multiple_of(4);
                let joint =
                    (sync && self.present.joint).then_some((DriveMotion::default(), self.now_us));
                screw.tick(&screw::Inputs {
                    axle: *inputs,
                    joint,
                })
            }
        };
        self.bridge = outputs.bridge;
        self.bench &= outputs.bench_mode;
        self.state = State::from_statusword(outputs.status.statusword).expect("a state");
        self.faulty = outputs.status.error_code != 0;
        outputs
    }

    /// Turns the rotor, with 2.4 N m/A and friction.
    fn turn(&mut self) {
        let torque = match self.bridge {
            BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => {
                2.4 * f64::from(current)
            }
            BridgeDemand::Off | BridgeDemand::Align { .. } | BridgeDemand::Aligned(_) => 0.0,
            BridgeDemand::Brake => -9.6 * self.velocity.clamp(-3.0, 3.0),
        };
        match self.rotor {
            Rotor::Turns => self.velocity += (torque - 0.5 * self.velocity) / INERTIA * 1e-3,
            Rotor::Swapped(inertia) => {
                self.velocity += (-torque - 0.5 * self.velocity) / inertia * 1e-3;
            }
            Rotor::Stuck => self.velocity = 0.0,
            Rotor::Dragged(speed) => self.velocity = f64::from(speed),
            Rotor::Jumps => self.angle += (self.random.bits() % 2_000) as f64 - 1_000.0,
        }
        self.angle += self.velocity * 1e-3;
    }
}
