//! The seat's posture (Nakajima, eq. 1).

use crate::math::Scalar;

/// `T_d = -K theta - D theta_dot`: what keeps the seat level.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PostureControl<S> {
    /// `K`, N m/rad.
    pub gain: S,
    /// `D`, N m s/rad.
    pub damping: S,
}

impl<S: Scalar> PostureControl<S> {
    /// Torque to put on the posture, N m, at an angle from level and its rate, rad and rad/s.
    #[inline]
    pub fn torque(&self, angle: S, rate: S) -> S {
        -(self.gain * angle) - self.damping * rate
    }

    /// The same for a drive that takes a rate, rad/s: the rate at which torque over `D` vanishes. Such a drive holds any load by itself, so a
    /// level seat needs no torque from the gain, and there is no error left.
    ///
    /// Zero without damping.
    #[inline]
    pub fn rate(&self, angle: S) -> S {
        if self.damping > S::ZERO {
            -(self.gain * angle) / self.damping
        } else {
            S::ZERO
        }
    }
}

/// Makes a drive that takes a rate push with a torque: the rate is what the torque lacks over `compliance`, N m s/rad, so that a load can turn it.
///
/// Zero without compliance.
#[inline]
pub fn yielding<S: Scalar>(asked_torque: S, felt_torque: S, compliance: S) -> S {
    if compliance > S::ZERO {
        (asked_torque - felt_torque) / compliance
    } else {
        S::ZERO
    }
}
