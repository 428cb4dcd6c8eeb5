//! The simulator: plants, virtual bus, lockstep runner, scenarios and report. No part of it runs on a robot.

pub mod plant;
pub mod log;
pub mod record;
pub mod report;
pub mod scenario;
pub mod summary;
