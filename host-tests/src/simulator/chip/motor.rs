//! Motor at the bridge of the motor board, with the board's analogue circuits between motor and
//! chip. Their values are those of docs/hardware.md, entered again.

use crate::simulator::chip::CORE_HZ;
use tautrack::link::{MotorModel, Shaft, WindingModel};
use tautrack::motor::bridge::{PowerStage, Ratings};
use tautrack::motor::model::Motor;
use tautrack::units::Angle;

/// Core clocks of half a PWM period: the time step of the motor.
const HALF_PERIOD: u64 = CORE_HZ / 40_000;
/// Shunt of a half bridge, ohm.
const SHUNT: f32 = 0.003;
/// Gain of an op-amp, 16, behind its divider.
const GAIN: f32 = 16.0 * 4.0 / 7.0;
/// Reference of the converters, V.
const REFERENCE: f32 = 3.3;
/// Voltage of an op-amp without current, V: 16 times that of 22 k to the reference against 1.5 k
/// and
/// 2.2 k to ground.
pub(super) const ZERO: f32 = 2.057;
/// Divider of the supply voltage.
const SUPPLY_DIVIDER: f32 = 18.0 / (18.0 + 169.0);
/// Time in which an op-amp follows its input after an edge, core clocks: 1.3 us.
const SETTLING: u32 = 221;
/// Codes of a converter.
const CODES: f32 = 4096.0;
/// Bridge for the model of the motor, which is called twice in a PWM period. Its codes have steps
/// of 5 mA, finer than those of the chip's converter.
const RATINGS: Ratings = Ratings {
    pwm_hz: 40_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 163.84,
    highest_supply: f32::INFINITY,
};

/// State of the bridge's timer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bridge {
    /// The gates of phases a and b follow the compare registers.
    pub live: bool,
    /// Compare registers of phases a, b and c.
    pub compares: [u32; 3],
    /// Compare value of a half bridge whose high side is always on.
    pub reload: u32,
}

/// A motor, its encoder and its current measurement.
pub(super) struct AttachedMotor {
    motor: Motor,
    /// Clock at which the next half period ends.
    next: u64,
    /// The counter counts up in this half period.
    rising: bool,
    /// Compare values in force.
    compares: [u32; 3],
    reload: u32,
    is_brushed: bool,
    stage: PowerStage,
    /// Encoder counts at which the timer was started.
    encoder_start: i32,
    /// Encoder counts at the newest pulse of the index that nobody has read.
    index: Option<i32>,
    /// Its Hall sensors are connected instead of the encoder.
    halls: bool,
}

impl AttachedMotor {
    /// Creates a motor at rest; `None` if the model's values are out of their bounds.
    pub fn new(model: MotorModel, seed: u64) -> Option<Self> {
        let model = MotorModel {
            // Each half bridge has one edge in each half period.
            dead_time: 0.5 * model.dead_time,
            current_quantum: 0.0,
            ..model
        };
        Some(Self {
            motor: Motor::new(model, RATINGS, seed)?,
            next: HALF_PERIOD,
            rising: true,
            compares: [0; 3],
            reload: 0,
            is_brushed: matches!(model.winding, WindingModel::Brushed { .. }),
            stage: PowerStage::Off,
            encoder_start: 0,
            index: None,
            halls: false,
        })
    }

    /// Sets the supply voltage (V) and the torque at the output shaft (N m), and whether the
    /// encoder is frozen.
    pub fn set_load(&mut self, supply_voltage: f32, shaft_torque: f32, encoder_frozen: bool) {
        self.motor.set_load(supply_voltage, shaft_torque);
        self.motor.freeze_sensor(encoder_frozen);
    }

    /// Starts a PWM period: the timer was started, with the counter at 0.
    pub fn start_period(&mut self, clock: u64, bridge: &Bridge) {
        self.next = clock + HALF_PERIOD;
        self.rising = true;
        self.compares = bridge.compares;
        self.reload = bridge.reload;
    }

    /// Clock at which [`AttachedMotor::half_period`] must be called next.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Integrates half a PWM period that ends now. New compare values take effect at the underflow
    /// of the counter.
    pub fn half_period(&mut self, bridge: &Bridge) {
        let scaled = |compare: u32| (compare * 4_250 / bridge.reload.max(1)).min(4_250) as u16;
        self.stage = match (bridge.live, self.compares) {
            (false, _) => PowerStage::Off,
            // Without pulses there is no dead time.
            (true, [0, 0, _]) => PowerStage::Brake,
            (true, compares) => PowerStage::Drive(compares.map(scaled)),
        };
        self.motor.integrate(self.stage);
        self.index = self.motor.take_index().or(self.index);
        self.next += HALF_PERIOD;
        if !self.rising {
            self.compares = bridge.compares;
        }
        self.rising = !self.rising;
    }

    /// Codes of the converters for the currents of all phases. `dead_clocks` is the dead time, and
    /// `zeros` are the voltages of the op-amps without current, V.
    pub fn current_codes(&mut self, dead_clocks: u32, zeros: [f32; 3]) -> [u16; 3] {
        let open = self.stage == PowerStage::Off;
        let [a, b] = self
            .motor
            .readings()
            .currents
            .map(|code| (f32::from(code) - 32_768.0) * (RATINGS.full_scale / 32_768.0));
        let c = if self.is_brushed { 0.0 } else { -a - b };
        let compares = self.compares;
        let reload = self.reload;
        let currents = [a, b, c];
        std::array::from_fn(|phase| {
            let (current, zero) = (currents[phase], zeros[phase]);
            // The low side conducts from its edge, and the op-amp follows 1.3 us later.
            let low = reload.saturating_sub(compares[phase]);
            if !open && low < dead_clocks + SETTLING {
                return code_of(zero);
            }
            // With all transistors open, a current into the bridge flows through the diode of the
            // high side, past the shunt.
            let seen = if open { current.max(0.0) } else { current };
            code_of(zero - seen * SHUNT * GAIN)
        })
    }

    /// Connects the Hall sensors instead of the encoder.
    pub fn connect_halls(&mut self) {
        self.halls = true;
    }

    /// Levels of the Hall sensors in the lowest three bits, if they are connected.
    pub fn hall_levels(&self) -> Option<u32> {
        self.halls.then(|| self.motor.halls([Angle::ZERO; 3]))
    }

    /// Starts the encoder's timer.
    pub fn start_encoder(&mut self, count: u32) {
        self.encoder_start = self.motor.encoder().wrapping_sub(count.cast_signed());
    }

    /// Counter of the encoder's timer.
    pub fn encoder_counter(&self) -> u32 {
        self.counter(self.motor.encoder())
    }

    /// Whether a pulse of the index waits to be read.
    pub fn has_index(&self) -> bool {
        self.index.is_some()
    }

    /// Counter at the newest pulse of the index, if one waits to be read.
    pub fn take_index(&mut self) -> Option<u32> {
        self.index.take().map(|count| self.counter(count))
    }

    fn counter(&self, count: i32) -> u32 {
        count.wrapping_sub(self.encoder_start).cast_unsigned() & 0xffff
    }

    /// Motion of the output shaft.
    pub fn shaft(&self) -> Shaft {
        self.motor.shaft()
    }
}

/// Code of a converter for a supply voltage, V.
pub(super) fn supply_code(voltage: f32) -> u16 {
    code_of(voltage * SUPPLY_DIVIDER)
}

/// Code of a converter with 12 bits for a voltage at its input, V.
fn code_of(voltage: f32) -> u16 {
    // The conversion to an integer saturates at 0.
    ((voltage / REFERENCE * CODES) as u16).min(4095)
}
