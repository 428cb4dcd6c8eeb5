//! Limits that the margins hand down: how hard the robot may speed up, brake and turn, so that the
//! guard's own stop tips nothing.

use super::criterion::Evaluation;
use super::parameters::Parameters;
use crate::constants::GRAVITY;
use crate::math::{limit, max, min};

/// Share of the configured deceleration below which the limit never goes: a robot that may not brake at all drives on.
pub const LEAST_SHARE: f32 = 0.25;

/// Largest accelerations in each direction, m/s^2, and how fast the posture may change. Along, they go up to what the guard's own stops may use.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct MotionLimits {
    /// Forward: of a start ahead and of a stop from driving back.
    pub forward: f32,
    /// Backward: of a stop from driving ahead.
    pub backward: f32,
    /// To the left: of a left turn ahead.
    pub left: f32,
    /// To the right.
    pub right: f32,
    /// Share of the posture's own speed, 0 to 1.
    pub posture: f32,
}

impl MotionLimits {
    /// What the settings allow by themselves.
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

    /// Limits that leave each margin of the centre of gravity at least the trip margin: `a = g (m - m_trip) / h`, at most the configured
    /// braking along and acceleration across, at least [`LEAST_SHARE`] of the acceleration along and zero across.
    ///
    /// Margins of the centre of gravity, not those with the measured force: that already shows the acceleration which is to be limited.
    /// A margin that is no number gives the least.
    pub fn of(found: &Evaluation, parameters: &Parameters) -> Self {
        let widening = parameters.uncertainty.widening();
        let configured = parameters.acceleration;
        let known = found.gravity.iter().all(|margin| margin.is_finite());
        let mut most = [parameters.braking, configured].map(|most| {
            let most = if known { most } else { f32::NAN };
            [most; 2]
        });
        for (margin, levers) in found.gravity.iter().zip(&found.levers) {
            let room = max(*margin - parameters.trip, 0.0) * GRAVITY;
            for (most, lever) in most.iter_mut().zip(levers) {
                // An acceleration presses on an edge that loses by it; the opposite one costs it nothing.
                let cost = lever.abs() + widening;
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
        // False for NaN.
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

    /// `yaw_rate` as far as the centripetal acceleration at `speed` is bearable: `|w| <= a / |v|`. Never more than asked; 0 for NaN.
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

    /// Braking at the limit moves the zero moment point of a mass at that height to the trip margin, by its definition.
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
        // A left turn presses on the right.
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
