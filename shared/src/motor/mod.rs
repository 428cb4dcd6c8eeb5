//! What moves one motor.
//!
//! [`current`] is the innermost loop, in the PWM interrupt.

pub mod current;
