//! The simulator: plants, virtual bus, lockstep runner, scenarios and report. No part of it runs on a robot.

pub mod bus;
pub mod nodes;
pub mod record;
pub mod setup;
pub mod slcan;
