//! Which margin counts: that of the centre of gravity while the robot is slow; that of the measured
//! force as well when it is fast.
//!
//! Slow means: even an instant stop cannot tip the robot over an edge from which its centre of
//! gravity is as far as the stop margin ([`stopping_speed`]), and the measured acceleration eats
//! less than half of that margin. Above either, the centre of gravity is projected along the
//! measured specific force instead of straight down (the zero moment point of a robot whose parts
//! do not turn), and the force-angle of Papadopoulos and Rey ([`super::tipover`]) is asked too:
//! `|l| sin(nu)`, with `l` the perpendicular to the edge, is the arm of the force about it, so that
//! an angle `nu` above its stop level is an arm above `|l| sin(nu_stop)`, and no arc tangent is
//! needed.

use super::edge_margin::weigh;
use super::parameters::Parameters;
use super::stopping::stopping_speed;
use super::support::Stance;
use crate::math::vector::Vector;
use crate::math::{max, root_of_sum};

/// Margins of one moment.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Evaluation {
    /// What counts, m, indexed by [`super::support::Edge`], the uncertainty taken off. NaN if an
    /// input is no number, and if the robot is fast and the ground would have to pull.
    pub margins: [f32; 4],
    /// Of the centre of gravity straight down, m, the uncertainty taken off.
    pub gravity: [f32; 4],
    /// What a margin gains with each `g` of acceleration forward and to the left, m.
    pub levers: [[f32; 2]; 4],
    /// The measured force counts.
    pub fast: bool,
    /// Because of the speed: so fast that an instant stop could tip the robot.
    pub quick: bool,
}

/// Evaluates margins and remembers which of them count.
#[derive(Clone, Debug, Default)]
pub struct Criterion {
    fast: bool,
}

impl Criterion {
    /// Margins of a `stance` with specific `force` in level axes (upward at rest), m/s^2, and
    /// `speed` over ground, m/s.
    ///
    /// Total. Every margin is always computed, whichever counts, so that the cost does not depend
    /// on it. Edges that are not there have the margins of [`Stance::margins`].
    #[inline(never)]
    pub fn evaluate(
        &mut self,
        stance: &Stance,
        force: Vector<f32>,
        speed: f32,
        parameters: &Parameters,
    ) -> Evaluation {
        let widening = parameters.uncertainty.widening();
        let tilt = [force[0] / force[2], force[1] / force[2]];
        let uncertain = widening * (tilt[0].abs() + tilt[1].abs());
        let missing = stance.missing();
        let mut found = Evaluation {
            gravity: [missing; 4],
            ..Evaluation::default()
        };
        let (mut with_force, mut shift, mut height) = ([missing; 4], 0.0_f32, 0.0_f32);
        for (edge, there, ends) in stance.edges() {
            if !there {
                continue;
            }
            let index = edge as usize;
            let weighed = weigh(ends, stance.cog, force, tilt, uncertain, parameters);
            found.gravity[index] = weighed.gravity - widening;
            found.levers[index] = weighed.lever;
            with_force[index] = weighed.with_force - widening;
            shift = max(shift, weighed.shift);
            height = if weighed.height > height {
                weighed.height
            } else {
                height
            };
        }
        let critical = stopping_speed(parameters.stop, root_of_sum(height) + widening);
        // A hysteresis of a tenth in speed and a half in shift; false for NaN.
        let (speed_share, shift_share) = if self.fast { (0.9, 0.25) } else { (1.0, 0.5) };
        found.quick = !(speed.abs() < critical * speed_share);
        let slow = !found.quick && shift < parameters.stop * shift_share;
        self.fast = !slow;
        found.fast = self.fast;
        found.margins = if slow {
            found.gravity
        } else if force[2] > 0.0 {
            with_force
        } else {
            [f32::NAN; 4]
        };
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::tipover;
    use super::*;
    use crate::constants::GRAVITY;
    use crate::settings::Settings;

    const SUPPORT: [Vector<f32>; 4] = [
        [0.0, -0.2, 0.0],
        [0.8, -0.2, 0.1],
        [0.8, 0.2, 0.1],
        [0.0, 0.2, 0.0],
    ];
    const LEVEL: Vector<f32> = [0.0, 0.0, GRAVITY];
    const COG: Vector<f32> = [0.3, 0.02, 0.25];

    fn judged(force: Vector<f32>, speed: f32) -> Evaluation {
        // The force-angle has a test of its own.
        let parameters = Parameters {
            stop_sine: 0.0,
            ..Parameters::new(&Settings::default())
        };
        Criterion::default().evaluate(&Stance::on(SUPPORT, COG), force, speed, &parameters)
    }

    #[test]
    fn at_rest_the_margins_are_those_of_the_centre_of_gravity() {
        let expected = Stance::on(SUPPORT, COG).margins();
        for speed in [0.0, 3.0] {
            let found = judged(LEVEL, speed);
            assert_eq!(found.fast, speed > 0.0);
            for (margin, expected) in found.gravity.iter().zip(expected) {
                assert!((margin - expected).abs() < 1e-6, "{found:?}");
            }
        }
        assert_eq!(judged(LEVEL, 0.0).margins, judged(LEVEL, 0.0).gravity);
    }

    /// The point where the line through the centre of gravity along the force meets the plane of
    /// the support, in double precision.
    #[test]
    fn with_force_the_margin_is_that_of_the_projection_along_it() {
        let force = [-2.0_f32, 0.7, 9.0];
        let found = judged(force, 0.0);
        assert!(
            found.fast,
            "2 m/s^2 at 0.25 m is more than half of the stop margin"
        );
        assert!(
            found.margins[0] <= 0.3 + 1e-6,
            "never wider than without: {found:?}"
        );
        // Over the front edge, at z = 0.1; the force moves the point forward.
        let forward = 0.3 + 0.15 * 2.0 / 9.0;
        let error = f64::from(found.margins[1]) - (0.8 - forward);
        assert!(error.abs() < 1e-5, "{found:?}");
    }

    /// An edge at the stop angle is at the stop margin, one inside of it is above, by the angle of
    /// Papadopoulos and Rey.
    #[test]
    fn the_force_angle_at_its_stop_level_is_the_stop_margin() {
        let parameters = Parameters {
            stop_sine: crate::math::sin_cos(crate::units::Angle::from_radians(0.7)).0,
            ..Parameters::new(&Settings::default())
        };
        let mut last_above = None;
        for step in 0..200 {
            let cog = [0.1 + 1e-3 * step as f32, 0.02, 0.15];
            let stance = Stance::on(SUPPORT, cog);
            let found = Criterion::default().evaluate(&stance, LEVEL, 9.0, &parameters);
            let (_, _, [from, to]) = stance.edges().last().expect("a rear edge");
            let [angle, _] = tipover::angles(&[*from, *to], cog, [0.0, 0.0, -GRAVITY], [0.0; 3]);
            assert_eq!(
                angle > 0.7,
                found.margins[0] > parameters.stop,
                "{cog:?} {angle}"
            );
            last_above = Some(angle > 0.7);
        }
        assert_eq!(last_above, Some(true));
    }

    #[test]
    fn a_free_fall_a_pull_and_no_number_are_no_margin() {
        for force in [[0.0, 0.0, 0.0], [0.0, 0.0, -9.81], [f32::NAN, 0.0, 9.81]] {
            let found = judged(force, 1.0);
            assert!(
                found.margins.iter().all(|margin| !(*margin > 0.0)),
                "{found:?}"
            );
        }
    }
}
