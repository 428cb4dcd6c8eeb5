//! Limits of the current: what a motor, a bridge and a supply can carry.
//!
//! * [`Limiter`]: the current limiter of the control task
//! * [`ActiveLimit`]: which limit acts
//! * `heat`: thermal models of winding and bridge
//! * `supply`: power, supply current and supply voltage
//! * `voltage`: what the bridge's voltage allows, and the field that a current in d weakens

mod active;
mod heat;
mod limiter;
mod supply;
mod voltage;

pub use active::ActiveLimit;
pub use limiter::{Conditions, Limited, Limiter, OVERSPEED};
