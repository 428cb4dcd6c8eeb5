//! The simulator: plants, virtual bus, lockstep runner, scenarios and report, and `cargo evaluate`. No part of it runs on a robot.

pub mod balance;
pub mod bus;
pub mod cost;
pub mod demo;
pub mod evaluate;
pub mod log;
pub mod machines;
pub mod nodes;
pub mod plant;
pub mod record;
pub mod reference;
pub mod report;
pub mod run;
pub mod scenario;
pub mod setup;
pub mod slcan;
pub mod suite;
pub mod summary;
