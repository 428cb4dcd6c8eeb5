//! Register-level models of the sensor chips on the guard's board.
//!
//! `inertial_unit`, `magnetometer` and `inclinometer` have the registers that the drivers use, and
//! convert what acts on the chip to its digits, which `outputs` writes. `board` has the chips with
//! their faults. The node programs of the simulator contain them; the model of a board's chip
//! connects them to its I2C bus.

mod board;
mod inclinometer;
mod inertial_unit;
mod magnetometer;
mod outputs;

pub use board::{Chips, NoAcknowledge};

/// Passage of time at a chip that measures at a rate of its own.
struct Sampler {
    elapsed_us: u32,
}

impl Sampler {
    const NEW: Self = Self { elapsed_us: 0 };

    /// Advances by one step. Returns whether the chip, with this period in us, measures in it; it
    /// does so once at most.
    fn step(&mut self, period_us: u32) -> bool {
        self.elapsed_us += super::STEP_US as u32;
        let due = self.elapsed_us >= period_us;
        if due {
            // A period that is shorter than a step leaves nothing over.
            self.elapsed_us = (self.elapsed_us - period_us).min(period_us);
        }
        due
    }
}
