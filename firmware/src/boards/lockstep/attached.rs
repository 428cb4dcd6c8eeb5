//! The simulated motor at the board, and the rotor sensor that the settings name.

use tautrack::motor::bridge::Readings;
use tautrack::motor::halls::Halls;
use tautrack::motor::model::Motor;
use tautrack::motor::rotor::RotorSensor;
use tautrack::settings::Settings;
use tautrack::units::Angle;

/// A motor with its rotor sensor.
pub struct AttachedMotor {
    pub motor: Motor,
    /// The board reads Hall sensors instead of the encoder.
    halls: Option<Halls>,
}

impl AttachedMotor {
    /// Attaches a motor with its encoder.
    pub fn new(motor: Motor) -> Self {
        Self { motor, halls: None }
    }

    /// Reads the rotor sensor of these settings from now on.
    pub fn choose_sensor(&mut self, settings: &Settings) {
        let halls = RotorSensor::of(settings).is_some_and(RotorSensor::has_halls);
        self.halls = halls.then(Halls::new);
    }

    /// Readings of a PWM period.
    #[inline]
    pub fn readings(&mut self) -> Readings {
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

    /// Whether the rotor sensor is broken.
    pub fn encoder_broken(&self) -> bool {
        self.halls.as_ref().is_some_and(Halls::are_broken)
    }
}
