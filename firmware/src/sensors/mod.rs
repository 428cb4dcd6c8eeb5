//! Chips of the sensors on the robot's body, on one I2C bus. They are read below the control tick,
//! which takes the newest readings and never waits for a transfer.
//!
//! [`bus`] is what a board provides: its I2C bus, and a way to free it · `device` limits the time
//! of every transfer · `inertial_unit`, `magnetometer` and `inclinometer` start and read one chip
//! with the driver of its maker · [`service`] is the task: it starts the chips, reads them at their
//! rates and starts them again after a failure · [`condition`] says how each chip does · [`newest`]
//! has the newest readings. The task has no static variables: [`Published`] is what it tells.
//!
//! The inclinometer is a chip of its own, because the guard compares it with the inertial unit.

pub mod bus;
pub mod condition;
mod device;
mod inclinometer;
mod inertial_unit;
mod magnetometer;
pub mod newest;
pub mod service;

pub use bus::SensorBus;
pub use inertial_unit::Address;
pub use service::{Rates, run};

use condition::Conditions;
use newest::Newest;

/// What the chips' task tells the rest of the node.
pub struct Published {
    /// Newest readings.
    pub newest: Newest,
    /// How the chips do.
    pub conditions: Conditions,
}

impl Published {
    /// What is published before the task has begun.
    pub(crate) const fn new() -> Self {
        Self {
            newest: Newest::new(),
            conditions: Conditions::new(),
        }
    }
}
