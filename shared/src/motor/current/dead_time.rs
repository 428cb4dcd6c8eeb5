//! Compensation of the dead time, during which both transistors of a half bridge are off.
//!
//! In the dead time a diode conducts, and its side depends on the direction of the current. So the
//! half bridge gives less voltage than commanded if current flows out of it, and more otherwise.

/// Returns the direction of `current`, from -2^22 to 2^22; 2^30 is full scale.
///
/// Close to zero the current changes its direction within a PWM period. So the result is
/// proportional to the current up to 1/256 of full scale.
#[inline]
pub(super) fn sign(current: i32) -> i32 {
    current.clamp(-(1 << 22), (1 << 22) - 1)
}
