//! An axle with its current loop and the motor model of the lockstep boards, and a client in bench
//! mode or a guard.

use std::f64::consts::TAU;
use tautrack::bus::cia402::{State, controlword};
use tautrack::motor::bridge::{PowerStage, Ratings};
use tautrack::motor::current::{Config, CurrentLoop, Electrical};
use tautrack::motor::model::{Motor, MotorModel, WindingModel};
use tautrack::node::axle::{Axle, Inputs, Outputs, SetPoint};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};

const STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 160.0,
    highest_supply: f32::INFINITY,
};
const SUPPLY: f32 = 24.0;

/// One drive, and who commands it.
pub struct Bench {
    pub axle: Axle,
    pub motor: Motor,
    current_loop: CurrentLoop,
    stage: PowerStage,
    now_us: u64,
    /// The newest outputs.
    pub outputs: Outputs,
    pub word: u16,
    pub mode: i8,
    pub target: i32,
    /// A guard commands the axle; otherwise a client in bench mode.
    pub guard: bool,
    /// Torque of the load at the output shaft, N m.
    pub load: f32,
    /// Torque feed-forward that the master sends.
    pub torque_offset: Option<i16>,
    /// Times in which a brake releases and engages, ms; `None` if it takes none.
    pub brake_ms: Option<[usize; 2]>,
    /// For how long the output to the brake has had its state, ms.
    brake_since: usize,
    pub switches: fn(f64) -> Switches,
}

/// Motor that fits the default settings: 0.05 kg m^2 at the output shaft and 2.4 N m/A.
pub const MOTOR: MotorModel = MotorModel {
    winding: WindingModel::Brushed {
        resistance: 0.6,
        inductance: 3e-4,
        torque_constant: 0.04,
    },
    rotor_inertia: 0.05 / 3_600.0,
    gear_ratio: 60.0,
    friction_torque: 0.3,
    brake_torque: 0.0,
    encoder_counts: 4_096,
    current_noise: 0.02,
    current_quantum: 0.005,
    dead_time: 0.0,
};

/// Position in bus units of 2^-16 turn.
pub fn turns(radians: f64) -> i32 {
    (radians / TAU * 65_536.0).round() as i32
}

impl Bench {
    /// Creates a drive with these settings, at rest, that a client in bench mode commands. The
    /// limits of bench mode are those of operation, unless they are changed.
    pub fn new(changes: &[(Setting, i32)], model: MotorModel) -> Self {
        let mut settings = Settings::default();
        let bench = [
            (Setting::BenchCurrent, 10_000),
            (Setting::BenchSpeed, 6_000),
        ];
        for (setting, value) in bench.iter().chain(changes) {
            settings.set(setting.description().key, *value).unwrap();
        }
        let config = Config::from_settings(&settings, 20);
        let mut bench = Self {
            axle: Axle::new(&settings),
            motor: Motor::new(model, STAGE, 1).unwrap(),
            current_loop: CurrentLoop::new(&config, &STAGE).unwrap(),
            stage: PowerStage::Off,
            now_us: 0,
            outputs: Axle::new(&settings).tick(&inputs_at_rest()),
            word: 0,
            mode: 0,
            target: 0,
            guard: false,
            load: 0.0,
            torque_offset: None,
            brake_ms: None,
            brake_since: usize::MAX / 2,
            switches: |_| Switches::default(),
        };
        bench.tick();
        bench
    }

    /// Angle of the output shaft, rad.
    pub fn angle(&self) -> f64 {
        self.motor.shaft().position as f64 / 4_294_967_296.0 * TAU
    }

    /// Velocity of the output shaft, rad/s.
    pub fn velocity(&self) -> f64 {
        f64::from(self.motor.shaft().velocity)
    }

    pub fn tick(&mut self) {
        self.now_us += 1_000;
        self.motor.set_load(SUPPLY, self.load);
        let [release, engage] = self.brake_ms.unwrap_or_default();
        self.motor.release_brake(if self.outputs.brake_released {
            self.brake_since >= release
        } else {
            self.brake_since < engage
        });
        for _ in 0..20 {
            let next = self.current_loop.period(&self.motor.readings());
            self.motor.integrate(self.stage);
            self.stage = next;
        }
        let tick = self.now_us / 1_000;
        let means = self.current_loop.take_means();
        let inputs = Inputs {
            now_us: self.now_us,
            encoder: self.motor.encoder(),
            encoder_broken: false,
            bridge_stop: None,
            current: means.map_or(f32::NAN, |means| means.current),
            electrical: means.map(|means| means.electrical).unwrap_or_default(),
            temperatures: Temperatures::default(),
            supply_voltage: SUPPLY,
            switches: (self.switches)(self.angle()),
            set_point: tick.is_multiple_of(4).then_some(SetPoint {
                controlword: self.word,
                mode: self.mode,
                target: self.target,
            }),
            torque_offset: self.torque_offset.filter(|_| tick.is_multiple_of(16)),
            guard_received: self.guard && tick % 50 == 1,
            bench_mode: !self.guard,
        };
        let outputs = self.axle.tick(&inputs);
        self.brake_since += 1;
        if outputs.brake_released != self.outputs.brake_released {
            self.brake_since = 0;
        }
        self.outputs = outputs;
        let velocity = self.outputs.velocity;
        self.current_loop
            .demand(self.outputs.bridge, SUPPLY, velocity);
    }

    pub fn run(&mut self, milliseconds: usize) {
        for _ in 0..milliseconds {
            self.tick();
        }
    }

    /// Sends a controlword for this time.
    pub fn send(&mut self, word: u16, milliseconds: usize) {
        self.word = word;
        self.run(milliseconds);
    }

    /// Enables operation in `mode` with `target`.
    pub fn enable(&mut self, mode: i8, target: i32) {
        (self.mode, self.target) = (mode, target);
        self.run(60);
        for word in [controlword::SHUTDOWN, controlword::SWITCH_ON] {
            self.send(word, 8);
        }
        self.send(controlword::ENABLE_OPERATION, 8);
        assert_eq!(self.state(), State::OperationEnabled);
    }

    pub fn state(&self) -> State {
        State::from_statusword(self.status()).expect("a state")
    }

    pub fn status(&self) -> u16 {
        self.outputs.status.statusword
    }

    /// Runs until the bridge is off; returns the milliseconds, or `None` after two seconds.
    pub fn until_off(&mut self) -> Option<usize> {
        (0..2_000).find(|_| {
            self.tick();
            self.outputs.bridge == tautrack::node::axle::BridgeDemand::Off
        })
    }

    /// Writes one parameter as a client does.
    pub fn set(
        &mut self,
        write: impl FnOnce(&mut tautrack::bus::drive_parameters::DriveParameters),
    ) {
        let mut parameters = self.axle.parameters();
        write(&mut parameters);
        self.axle.configure(&parameters);
    }
}

fn inputs_at_rest() -> Inputs {
    Inputs {
        now_us: 0,
        encoder: 0,
        encoder_broken: false,
        bridge_stop: None,
        current: 0.0,
        electrical: Electrical::default(),
        temperatures: Temperatures::default(),
        supply_voltage: SUPPLY,
        switches: Switches::default(),
        set_point: None,
        torque_offset: None,
        guard_received: false,
        bench_mode: false,
    }
}
