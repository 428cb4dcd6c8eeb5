//! Controls the posture of the seat (Nakajima, eq. 1).

use crate::math::Scalar;

/// Control law `T_d = -K theta - D theta_dot`, which keeps the seat level.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PostureControl<S> {
    /// `K`, N m/rad.
    pub gain: S,
    /// `D`, N m s/rad.
    pub damping: S,
}

impl<S: Scalar> PostureControl<S> {
    /// Torque that corrects the posture, N m, at an angle from level, rad, and its rate, rad/s.
    #[inline]
    pub fn torque(&self, angle: S, rate: S) -> S {
        -(self.gain * angle) - self.damping * rate
    }

    /// Rate for a drive that is commanded by rate, rad/s: the one at which [`Self::torque`]
    /// vanishes.
    ///
    /// Such a drive holds any load by itself. So a level seat needs no torque from the gain, and no
    /// error remains. Zero without damping.
    #[inline]
    pub fn rate(&self, angle: S) -> S {
        if self.damping > S::ZERO {
            -(self.gain * angle) / self.damping
        } else {
            S::ZERO
        }
    }
}

/// Rate that makes a drive, which is commanded by rate, apply a torque: the missing torque over
/// `compliance`, N m s/rad. So a load can turn the drive.
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
