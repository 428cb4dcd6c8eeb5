//! Register-level models of the sensor chips on the guard's board, and their I2C bus.
//!
//! `inertial_unit` and `magnetometer` have the registers that the drivers use, and convert what
//! acts on the chip to its digits. `board` has both chips with their faults. `bus` is the board's
//! [`SensorBus`](crate::sensors::SensorBus): a transfer copies registers and takes no virtual time.
//! `outputs` converts what acts on a chip to the digits of its output registers.

mod board;
mod bus;
mod inertial_unit;
mod magnetometer;
mod outputs;

pub(super) use board::{measure, power_up};
pub use bus::start_sensors;

/// Passage of time at a chip that measures at a rate of its own.
struct Sampler {
    elapsed_us: u32,
}

impl Sampler {
    const NEW: Self = Self { elapsed_us: 0 };

    /// Advances by one step. Returns whether the chip, with this period in us, measures in it; it
    /// does so once at most.
    fn step(&mut self, period_us: u32) -> bool {
        self.elapsed_us += tautrack::link::STEP_US as u32;
        let due = self.elapsed_us >= period_us;
        if due {
            // A period that is shorter than a step leaves nothing over.
            self.elapsed_us = (self.elapsed_us - period_us).min(period_us);
        }
        due
    }
}
