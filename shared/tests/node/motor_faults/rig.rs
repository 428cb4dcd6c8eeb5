//! A drive on a simulated motor: the node's tick, its PWM interrupt, bridge, winding, rotor and
//! sensors. Its leads and its sensor can be changed while it runs.

use std::f64::consts::TAU;
use tautrack::bus::cia402::{State, toward_operation};
use tautrack::motor::bridge::{BridgeStop, PowerStage, Ratings};
use tautrack::motor::current::{Config, CurrentLoop};
use tautrack::motor::halls::Halls;
use tautrack::motor::model::{Motor, MotorModel, ThreePhaseModel, WindingModel};
use tautrack::motor::shaft_sensor::{Condition, Reading};
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

pub const STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 160.0,
    highest_supply: f32::INFINITY,
};
const PERIODS: u32 = 20;
const ENCODER_COUNTS: i32 = 4_096;
const POLE_PAIRS: i32 = 7;
pub const GEAR: f64 = 60.0;

/// Motors of the simulated robots: 24 V, 10 A, 0.04 N m/A, with a load of 0.05 kg m^2 at the output
/// shaft.
pub fn model(three_phase: bool) -> MotorModel {
    MotorModel {
        winding: if three_phase {
            WindingModel::ThreePhase(ThreePhaseModel {
                resistance: 0.3,
                inductance: [0.15e-3, 0.18e-3],
                flux: 0.04 / (1.5 * 7.0),
                pole_pairs: 7,
                offset_degrees: 40.0,
                cogging_torque: 0.0,
                cogging_periods: 42,
            })
        } else {
            WindingModel::Brushed {
                resistance: 0.6,
                inductance: 0.3e-3,
                torque_constant: 0.04,
            }
        },
        rotor_inertia: 1e-5 + 0.05 / (GEAR * GEAR) as f32,
        gear_ratio: GEAR as f32,
        friction_torque: 0.5,
        brake_torque: 0.0,
        encoder_counts: ENCODER_COUNTS as u32,
        current_noise: 0.02,
        current_quantum: 0.01,
        dead_time: 0.6e-6,
    }
}

/// Settings that fit to [`model`].
pub fn settings(three_phase: bool, changes: &[(Setting, i32)]) -> Settings {
    let motor: &[_] = if three_phase {
        &[
            (Setting::MotorKind, 1),
            (Setting::Resistance, 300),
            (Setting::Inductance, 150),
            (Setting::InductanceQ, 180),
            (Setting::ElectricalOffset, 40_000),
            (Setting::AngleWatch, 1),
        ]
    } else {
        &[]
    };
    let mut settings = Settings::default();
    for (setting, value) in motor.iter().chain(changes) {
        settings.set(setting.description().key, *value).unwrap();
    }
    settings
}

/// What is wrong with a motor or its sensor.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Trouble {
    None,
    /// The channels of the encoder are swapped.
    ReversedEncoder,
    /// Two leads of the motor are swapped.
    ReversedPhase,
    FrozenEncoder,
    /// The encoder jumps by up to this many counts in either direction.
    NoisyEncoder(i32),
    /// The encoder has lost this many counts.
    LostCounts(i32),
    /// The rotor sensor has turned on the shaft by this electrical angle, degrees.
    Slipped(f64),
    /// The lead of this half bridge is open.
    OpenLead(usize),
    /// The current of half bridge a reads this code.
    CurrentCode(u16),
    /// The current of this half bridge reads so many codes too much.
    CurrentOffset(usize, i32),
    /// The input "safe torque off" keeps the bridge open.
    NoTorque,
    /// The PWM interrupt runs in one of three periods only.
    MissedInterrupts,
    /// The line of this Hall sensor keeps a level.
    HallLine(u32, bool),
    /// The cable of the Hall sensors is unplugged: all lines are pulled up.
    HallCable,
}

impl Trouble {
    /// Returns the code that Hall sensors show instead of this one.
    fn code(self, code: u32) -> u32 {
        match self {
            // The lines of two sensors are swapped.
            Self::ReversedEncoder => code & 4 | (code & 1) << 1 | code >> 1 & 1,
            Self::HallLine(line, false) => code & !(1 << line),
            Self::HallLine(line, true) => code | 1 << line,
            Self::HallCable => 7,
            _ => code,
        }
    }
}

#[allow(clippy::struct_excessive_bools)] // each is a fact about the drive, and all are independent
pub struct Rig {
    pub axle: Axle,
    pub current_loop: CurrentLoop,
    pub motor: Motor,
    /// Counts of the encoder per turn of the rotor.
    counts: i32,
    stage: PowerStage,
    pub now_us: u64,
    pub trouble: Trouble,
    pub supply_voltage: f32,
    /// Torque that the load resists with, N m.
    pub load: f32,
    pub temperatures: Temperatures,
    /// Mode and target of the set-point.
    pub mode: i8,
    pub target: i32,
    pub guard_alive: bool,
    /// The master sends no set-points.
    pub silent: bool,
    pub switches: Switches,
    pub reset: bool,
    state: State,
    random: u64,
    encoder_at_trouble: Option<i32>,
    /// The rotor sensor only counts from power-up on.
    pub incremental: bool,
    /// The encoder has an index, and its line is connected.
    pub index: bool,
    /// Hall sensors show the rotor, if the settings say so.
    pub halls: Option<Halls>,
    /// Angles by which they are displaced.
    pub displaced: [Angle; 3],
    /// Width of its pulse, counts: it begins later if the rotor turns back.
    pub index_width: i32,
    /// Controlword that the master sends instead of those that lead to operation.
    pub word: Option<u16>,
    /// The motor has a brake, which follows its output at once.
    pub braked: bool,
    brake_released: bool,
    /// A client in bench mode commands the drive instead of a guard.
    pub bench: bool,
    /// Inputs of the last tick.
    pub inputs: Option<Inputs>,
    /// Largest current in the motor, A.
    pub largest_current: f64,
    /// The leads a and b are swapped, as the settings say.
    swapped_leads: bool,
    /// A supply whose voltage the bridge changes.
    pub supply: Option<Supply>,
    /// What keeps the bridge open.
    pub bridge_stop: Option<BridgeStop>,
    /// Angle, rad, that a sensor at the output shaft shows too much; `None` without a sensor.
    pub shaft_error: Option<f64>,
    shaft: Reading,
    model: MotorModel,
}

/// A battery that takes nothing back, and the capacitor of the bridge beside it.
///
/// What the bridge returns follows from the energy of rotor and winding: what these lose and a load
/// gives, minus friction and copper.
#[derive(Clone, Copy, Debug)]
pub struct Supply {
    pub battery: f64,
    pub capacitor: f64,
    pub voltage: f64,
    /// Voltage above which the board reports an over-voltage.
    pub bound: f64,
    stored: Option<f64>,
    /// Torque of the load in the PWM period that ends, N m.
    load: f64,
}

/// Current that the noise of the converters shows at most, A.
const NO_CURRENT: f64 = 0.15;

impl Supply {
    pub fn new(battery: f64, capacitor: f64, bound: f64) -> Self {
        Self {
            battery,
            capacitor,
            voltage: battery,
            bound,
            stored: None,
            load: 0.0,
        }
    }

    /// Takes what the bridge returned in the PWM period that ends. In the next one, a load resists
    /// with this torque.
    fn period(&mut self, model: &MotorModel, velocity: f64, load: f64, [a, b]: [f64; 2]) {
        let (resistance, inductance, c) = match model.winding {
            WindingModel::Brushed {
                resistance,
                inductance,
                ..
            } => (resistance, inductance, None),
            WindingModel::ThreePhase(winding) => {
                let [d, q] = winding.inductance;
                (winding.resistance, 0.5 * (d + q), Some(a + b))
            }
        };
        let squares = c.map_or(a * a, |c| a * a + b * b + c * c);
        let time = 1.0 / f64::from(STAGE.pwm_hz);
        let inertia = f64::from(model.rotor_inertia) * GEAR * GEAR;
        let stored = 0.5 * (inertia * velocity * velocity + f64::from(inductance) * squares);
        let friction = f64::from(model.friction_torque) * velocity.abs();
        let load = std::mem::replace(&mut self.load, load);
        let lost = time * (friction + load * velocity + f64::from(resistance) * squares);
        if let Some(before) = self.stored {
            let returned = before - stored - lost;
            // Without a current nothing comes back: it would be the rounding of the speed.
            let flows = squares > NO_CURRENT * NO_CURRENT;
            let returned = if flows { returned } else { returned.min(0.0) };
            let square = self.voltage * self.voltage + 2.0 * returned / self.capacitor;
            self.voltage = square.max(0.0).sqrt();
        }
        self.voltage = self.voltage.max(self.battery);
        self.stored = Some(stored);
    }
}

impl Rig {
    pub fn new(three_phase: bool, changes: &[(Setting, i32)]) -> Self {
        Self::with_model(model(three_phase), &settings(three_phase, changes))
    }

    pub fn with_model(model: MotorModel, settings: &Settings) -> Self {
        Self::with_seed(model, settings, 7)
    }

    /// The seed draws the noise, and the angle at which a three-phase rotor stands.
    pub fn with_seed(model: MotorModel, settings: &Settings, seed: u64) -> Self {
        let config = Config::from_settings(settings, PERIODS);
        Self {
            axle: Axle::new(settings),
            current_loop: CurrentLoop::new(&config, &STAGE).unwrap(),
            motor: Motor::new(model, STAGE, seed).unwrap(),
            counts: model.encoder_counts as i32,
            stage: PowerStage::Off,
            now_us: 0,
            trouble: Trouble::None,
            supply_voltage: 24.0,
            load: 0.0,
            temperatures: Temperatures::default(),
            mode: 3,
            target: 0,
            guard_alive: true,
            silent: false,
            switches: Switches::default(),
            reset: false,
            state: State::SwitchOnDisabled,
            random: 1,
            encoder_at_trouble: None,
            incremental: matches!(settings.get(Setting::RotorSensor), 1 | 3),
            index: settings.get(Setting::RotorSensor) == 3,
            halls: (settings.get(Setting::RotorSensor) >= 4).then(Halls::new),
            displaced: [Angle::ZERO; 3],
            index_width: 0,
            word: None,
            braked: false,
            brake_released: false,
            bench: false,
            inputs: None,
            largest_current: 0.0,
            swapped_leads: settings.get(Setting::PhaseOrder) < 0,
            supply: None,
            bridge_stop: None,
            shaft_error: None,
            shaft: Reading::default(),
            model,
        }
    }

    fn random(&mut self, bound: i32) -> i32 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let span = 2 * i64::from(bound) + 1;
        ((self.random >> 33) as i64 % span) as i32 - bound
    }

    /// Returns whether the drive is in operation.
    pub fn is_enabled(&self) -> bool {
        self.state == State::OperationEnabled
    }

    /// Turn of the output shaft since the start, rad.
    pub fn angle(&self) -> f64 {
        self.motor.shaft().position as f64 / 4_294_967_296.0 * TAU
    }

    fn pwm_period(&mut self, index: u32) {
        let mut readings = self.motor.readings();
        let amperes = readings
            .currents
            .map(|code| (f64::from(code) - 32_768.0) / 32_768.0 * f64::from(STAGE.full_scale));
        for amperes in amperes {
            self.largest_current = self.largest_current.max(amperes.abs());
        }
        if let Some(supply) = &mut self.supply {
            // The converter of the supply voltage is a period behind.
            readings.over_voltage = supply.voltage > supply.bound;
            let velocity = self.motor.shaft().velocity.into();
            supply.period(&self.model, velocity, self.load.into(), amperes);
            self.supply_voltage = supply.voltage as f32;
            self.motor.set_load(self.supply_voltage, self.load);
        }
        let swapped = self.swapped_leads != (self.trouble == Trouble::ReversedPhase);
        if swapped {
            readings.currents.swap(0, 1);
        }
        let turn = self.counts as u32;
        match self.trouble {
            Trouble::Slipped(degrees) => {
                let counts = degrees / 360.0 * f64::from(self.counts / POLE_PAIRS);
                readings.rotor =
                    (readings.rotor + (counts as i32).rem_euclid(self.counts) as u32) % turn;
            }
            Trouble::ReversedEncoder => readings.rotor = (turn - readings.rotor) % turn,
            Trouble::NoisyEncoder(bound) => {
                let noise = self.random(bound).rem_euclid(self.counts) as u32;
                readings.rotor = (readings.rotor + noise) % turn;
            }
            Trouble::CurrentCode(code) => readings.currents[0] = code,
            Trouble::CurrentOffset(phase, codes) => {
                let code = i32::from(readings.currents[phase]) + codes;
                readings.currents[phase] = code.clamp(0, 0xffff) as u16;
            }
            _ => {}
        }
        if self.incremental {
            readings.rotor = self.encoder() as u32;
        }
        if let Some(halls) = &mut self.halls {
            let code = self.motor.halls(self.displaced);
            readings.rotor = halls.update(self.trouble.code(code));
        }
        self.motor.integrate(match self.stage {
            _ if self.trouble == Trouble::NoTorque || self.bridge_stop.is_some() => PowerStage::Off,
            PowerStage::Drive([a, b, c]) if swapped => PowerStage::Drive([b, a, c]),
            stage => stage,
        });
        if self.trouble != Trouble::MissedInterrupts || index.is_multiple_of(3) {
            self.stage = self.current_loop.period(&readings);
        }
    }

    fn encoder(&mut self) -> i32 {
        if let Some(halls) = &self.halls {
            return halls.count();
        }
        let count = self.motor.encoder();
        self.shown(count)
    }

    /// Returns what the encoder shows instead of this count.
    fn shown(&mut self, count: i32) -> i32 {
        match self.trouble {
            Trouble::ReversedEncoder => {
                let origin = *self.encoder_at_trouble.get_or_insert(count);
                origin.wrapping_sub(count.wrapping_sub(origin))
            }
            Trouble::NoisyEncoder(bound) => count.wrapping_add(self.random(bound)),
            Trouble::LostCounts(lost) => count.wrapping_sub(lost),
            _ => count,
        }
    }

    /// Passes a pulse of the index to the current loop, if one came.
    fn pass_index(&mut self) {
        if let (Some(count), true) = (self.motor.take_index(), self.index) {
            let back = self.motor.shaft().velocity < 0.0;
            let width = if back { self.index_width } else { 0 };
            let shown = self.shown(count).wrapping_add(width);
            self.current_loop.index_pulse(shown as u32);
        }
    }

    /// Reads the shaft sensor every 10 ms. The axle gets the angle 13 ms late.
    fn read_shaft(&mut self, ticks: u64) {
        let Some(error) = self.shaft_error else {
            return;
        };
        if ticks.is_multiple_of(10) {
            let late = 0.013 * f64::from(self.motor.shaft().velocity);
            let turns = (self.angle() - late + error) / TAU;
            self.shaft = Reading {
                condition: Condition::Running,
                number: self.shaft.number.wrapping_add(1),
                angle: Angle::from_bits((turns * 4_294_967_296.0) as i64 as i32),
                ..self.shaft
            };
        }
        self.axle.locate(self.shaft);
    }

    /// Runs one control period.
    pub fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        self.motor.set_load(self.supply_voltage, self.load);
        self.motor
            .freeze_sensor(self.trouble == Trouble::FrozenEncoder);
        self.motor.open_lead(match self.trouble {
            Trouble::OpenLead(lead) => Some(lead),
            _ => None,
        });
        self.motor
            .release_brake(self.brake_released || !self.braked);
        for index in 0..PERIODS {
            self.pwm_period(index);
        }
        self.pass_index();
        let means = self.current_loop.take_means().unwrap();
        let ticks = self.now_us / 1_000;
        self.read_shaft(ticks);
        let controlword = if self.reset {
            0x80 * u16::from(ticks % 32 < 16)
        } else {
            self.word.unwrap_or_else(|| toward_operation(self.state))
        };
        let inputs = Inputs {
            now_us: self.now_us,
            encoder: self.encoder(),
            encoder_broken: self.halls.as_ref().is_some_and(Halls::are_broken),
            bridge_stop: self.bridge_stop,
            current: means.current,
            electrical: means.electrical,
            supply_voltage: self.supply_voltage,
            temperatures: self.temperatures,
            switches: self.switches,
            set_point: (ticks.is_multiple_of(4) && !self.silent).then_some(SetPoint {
                controlword,
                mode: self.mode,
                target: self.target,
            }),
            torque_offset: None,
            guard_received: self.guard_alive && !self.bench && ticks % 50 == 1,
            bench_mode: self.bench,
        };
        self.inputs = Some(inputs);
        let outputs = self.axle.tick(&inputs);
        self.brake_released = outputs.brake_released;
        self.state = State::from_statusword(outputs.status.statusword).unwrap();
        self.current_loop
            .demand(outputs.bridge, self.supply_voltage, outputs.velocity);
        outputs
    }

    /// Runs this many milliseconds without a fault.
    pub fn run(&mut self, milliseconds: usize) -> Outputs {
        let mut last = None;
        for millisecond in 0..milliseconds {
            let outputs = self.tick();
            assert!(
                outputs.faults.is_empty(),
                "{:?} after {millisecond} ms",
                outputs.faults
            );
            last = Some(outputs);
        }
        last.expect("at least one millisecond")
    }

    /// Runs until a fault is raised. Returns the outputs of that tick and the milliseconds.
    pub fn until_raised(&mut self, within: usize) -> Option<(Outputs, usize)> {
        (1..=within).find_map(|milliseconds| {
            let outputs = self.tick();
            (!outputs.faults.is_empty()).then_some((outputs, milliseconds))
        })
    }

    /// Runs until a fault opens or shorts the bridge. Returns the outputs of that tick, the
    /// milliseconds and the travel of the output shaft, rad, until then.
    pub fn until_fault(&mut self, within: usize) -> Option<(Outputs, usize, f64)> {
        let start = self.angle();
        (1..=within).find_map(|milliseconds| {
            let outputs = self.tick();
            let stopped = matches!(outputs.bridge, BridgeDemand::Off | BridgeDemand::Brake);
            (stopped && !outputs.faults.is_empty())
                .then(|| (outputs, milliseconds, (self.angle() - start).abs()))
        })
    }
}

/// Units of the velocity target per rad/s.
pub const PER_RADIAN: f64 = 1e6;
