//! Computes limits of acceleration, braking and yaw from the margins, so that the guard's own stop
//! does not tip the robot.

use super::evaluation::Evaluation;
use super::parameters::Parameters;
use crate::constants::GRAVITY;
use crate::math::{limit, max, min};

/// Minimum of the limits along the heading, as a fraction of the configured acceleration. A robot
/// that may not brake at all would drive on.
pub const LEAST_SHARE: f32 = 0.25;

/// Largest accelerations in each direction, m/s^2, and the speed scale of the posture. The limits
/// along the heading go up to the deceleration that the guard's own stops may use.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct MotionLimits {
    /// Forward: when the robot speeds up ahead, or stops from driving back.
    pub forward: f32,
    /// Backward: when the robot stops from driving ahead, or speeds up backward.
    pub backward: f32,
    /// To the left: in a left turn while driving ahead.
    pub left: f32,
    /// To the right.
    pub right: f32,
    /// Scale of the posture's own speed, 0 to 1.
    pub posture: f32,
}

impl MotionLimits {
    /// Limits by the settings alone.
    pub fn unlimited(parameters: &Parameters) -> Self {
        let (along, across) = (parameters.braking, parameters.acceleration);
        Self {
            forward: along,
            backward: along,
            left: across,
            right: across,
            posture: 1.0,
        }
    }

    /// Limits that leave each margin of the centre of gravity at least the trip margin:
    /// `a = g (m - m_trip) / h`.
    ///
    /// The maximum is the configured braking along the heading and the configured acceleration
    /// across it. The minimum is [`LEAST_SHARE`] of the acceleration along and zero across. If a
    /// margin is not finite, the limits are the minimum.
    ///
    /// The margins are those of the centre of gravity, because the margins with the measured force
    /// already contain the acceleration that is to be limited.
    pub fn of(found: &Evaluation, parameters: &Parameters) -> Self {
        let deduction = parameters.uncertainty.deduction();
        let configured = parameters.acceleration;
        let known = found.gravity.iter().all(|margin| margin.is_finite());
        let mut most = [parameters.braking, configured].map(|most| {
            let most = if known { most } else { f32::NAN };
            [most; 2]
        });
        for (margin, levers) in found.gravity.iter().zip(&found.levers) {
            let room = max(*margin - parameters.trip, 0.0) * GRAVITY;
            for (most, lever) in most.iter_mut().zip(levers) {
                // An acceleration uses up the margin of the edge that it loads, and not that of the
                // opposite edge.
                let cost = lever.abs() + deduction;
                let most = &mut most[usize::from(*lever > 0.0)];
                let bound = if *most * cost <= room {
                    *most
                } else {
                    room / cost
                };
                *most = if *lever == 0.0 {
                    *most
                } else {
                    min(*most, bound)
                };
            }
        }
        // The comparison is false for NaN.
        let at_least = |most: f32, least: f32| if most > least { most } else { least };
        let least = LEAST_SHARE * configured;
        let [[forward, backward], [left, right]] = most;
        Self {
            forward: at_least(forward, least),
            backward: at_least(backward, least),
            left: at_least(left, 0.0),
            right: at_least(right, 0.0),
            posture: 1.0,
        }
    }

    /// Limits `yaw_rate` so that the centripetal acceleration at `speed` stays within the limits:
    /// `|w| <= a / |v|`. Never increases its magnitude; 0 for NaN.
    pub fn yaw_rate(&self, yaw_rate: f32, speed: f32) -> f32 {
        let inward = yaw_rate * speed;
        let bearable = if inward > 0.0 { self.left } else { self.right };
        let most = bearable / (speed.abs() + 1e-3);
        limit(yaw_rate, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn standing(front: f32, height: f32) -> Evaluation {
        let gravity = [0.3, front, 0.1, 0.15];
        Evaluation {
            margins: gravity,
            gravity,
            levers: [[-height, 0.0], [height, 0.0], [0.0, height], [0.0, -height]],
            ..Evaluation::default()
        }
    }

    fn parameters() -> Parameters {
        Parameters {
            acceleration: 4.0,
            braking: 4.0,
            ..Parameters::new(&Settings::default())
        }
    }

    /// By its definition, the zero moment point of a mass at that height is at the trip margin when
    /// the robot brakes at the limit.
    #[test]
    fn braking_at_the_limit_leaves_the_trip_margin() {
        let limits = MotionLimits::of(&standing(0.1, 0.3), &parameters());
        let shift = 0.3 * f64::from(limits.backward) / 9.81;
        assert!((0.1 - shift - 0.01).abs() < 1e-5, "{limits:?}");
        assert_eq!(limits.forward, 4.0);
    }

    #[test]
    fn at_the_edge_a_gentle_stop_is_left_and_no_turn() {
        let mut found = standing(0.0, 0.3);
        assert_eq!(MotionLimits::of(&found, &parameters()).backward, 1.0);
        // A left turn loads the right edge.
        found.gravity[3] = 0.0;
        let limits = MotionLimits::of(&found, &parameters());
        assert_eq!(limits.yaw_rate(0.5, 0.3), 0.0);
        assert!(limits.yaw_rate(-0.5, 0.3) < 0.0);
    }

    #[test]
    fn margins_that_are_no_numbers_give_the_least() {
        let limits = MotionLimits::of(&standing(f32::NAN, 0.3), &parameters());
        assert_eq!((limits.forward, limits.left), (1.0, 0.0));
        assert_eq!(limits.yaw_rate(f32::NAN, 0.3), 0.0);
    }
}
