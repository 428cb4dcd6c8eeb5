//! Calibration: measures the motor and its sensors on request.
//!
//! * [`Calibration`] in `sequence`: the state machine, one tick per control period
//! * `plan`: bounds and known values
//! * `zero`: offsets of the current converter
//! * `resistance`: resistance of the phases of a three-phase motor
//! * `drag`: pole pairs, direction and electrical offset
//! * `inductance`: inductances from the ripple that a square wave causes
//! * `spin`: flux linkage, or torque constant of a brushed motor, from the back-EMF
//! * `swing`: resistance of a brushed motor
//! * `tick`: what the steps share
//! * `record`: the results, and why a result is refused
//!
//! The calibration controls no current in the PWM interrupt. It excites the motor with voltages
//! ([`super::current::Excitation`]) and changes them slowly, so that it needs to know nothing of
//! the motor. The interrupt opens the bridge at 150 % of the current limit as always, and the
//! excitation expires as a demand does.

mod drag;
mod inductance;
mod plan;
mod record;
mod resistance;
mod sequence;
mod spin;
mod swing;
mod tick;
mod zero;

pub use plan::Plan;
pub use record::{Quantity, Record, Refusal, Residuals, SETTINGS, sensing};
pub use sequence::{Calibration, Inputs, Progress, Step};
