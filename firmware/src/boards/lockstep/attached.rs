//! The simulated motor at the board, and the rotor sensor that the settings name.

use super::POWER_STAGE;
use tautrack::link::{STEP_US, Sensors, Shaft};
use tautrack::motor::bridge::{PowerStage, Readings};
use tautrack::motor::halls::Halls;
use tautrack::motor::model::{Motor, MotorModel};
use tautrack::motor::rotor::RotorSensor;
use tautrack::settings::Settings;
use tautrack::units::Angle;

/// A motor with its rotor sensor.
pub struct AttachedMotor {
    motor: Motor,
    /// The board reads Hall sensors instead of the encoder.
    halls: Option<Halls>,
    stage: PowerStage,
}

impl AttachedMotor {
    /// Attaches a motor with its encoder. `None` if the model cannot be simulated.
    pub fn new(model: MotorModel, seed: u64) -> Option<Self> {
        Some(Self {
            motor: Motor::new(model, POWER_STAGE, seed)?,
            halls: None,
            stage: PowerStage::Off,
        })
    }

    /// Reads the rotor sensor of these settings from now on.
    pub fn choose_sensor(&mut self, settings: &Settings) {
        let halls = RotorSensor::of(settings).is_some_and(RotorSensor::has_halls);
        self.halls = halls.then(Halls::new);
    }

    /// Runs the PWM periods of one step. `interrupt` is the board's interrupt: it returns what the
    /// power stage does in the next period. Returns the motion of the output shaft. Not inlined:
    /// the emulator searches for the translation of the code whenever the program enters another
    /// page of 1 KiB. So the code that runs most often stands in as few pages as possible.
    #[inline(never)]
    pub fn step(
        &mut self,
        sensors: &Sensors,
        brake_released: bool,
        mut interrupt: impl FnMut(&Readings) -> PowerStage,
    ) -> Shaft {
        let motor = &mut self.motor;
        motor.set_load(sensors.supply_voltage, sensors.shaft_torque);
        motor.freeze_sensor(sensors.encoder_frozen);
        motor.release_brake(brake_released);
        for _ in 0..u64::from(POWER_STAGE.pwm_hz) * STEP_US / 1_000_000 {
            // As with preloaded compare registers, the interrupt's decision takes effect in the
            // next period.
            let next = interrupt(&self.readings());
            self.motor.integrate(self.stage);
            self.stage = next;
        }
        self.motor.shaft()
    }

    /// Readings of a PWM period.
    #[inline]
    fn readings(&mut self) -> Readings {
        let readings = self.motor.readings();
        match &mut self.halls {
            None => readings,
            Some(halls) => Readings {
                rotor: halls.update(self.motor.halls([Angle::ZERO; 3])),
                ..readings
            },
        }
    }

    /// Counts of the rotor sensor since power-up.
    pub fn encoder(&self) -> i32 {
        match &self.halls {
            None => self.motor.encoder(),
            Some(halls) => halls.count(),
        }
    }

    /// Whether the encoder's index gave a pulse since the last call.
    pub fn take_index(&mut self) -> bool {
        self.motor.take_index().is_some()
    }

    /// Whether the rotor sensor is broken.
    pub fn encoder_broken(&self) -> bool {
        self.halls.as_ref().is_some_and(Halls::are_broken)
    }
}
