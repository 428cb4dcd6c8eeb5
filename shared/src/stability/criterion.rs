//! Computes the margins that count: those of the centre of gravity for a slow robot, and also those
//! with the measured force for a fast one.
//!
//! A robot is slow if two conditions hold. First, an instant stop cannot tip it over an edge whose
//! distance to the centre of gravity is the stop margin ([`stopping_speed`]). Second, the measured
//! acceleration shifts the margins by less than half of the stop margin.
//!
//! For a fast robot two more margins count. The first is that of the centre of gravity projected
//! along the measured specific force instead of straight down (the zero moment point of a robot
//! whose parts do not rotate). The second follows from the force-angle of Papadopoulos and Rey
//! ([`super::tipover`]). With `l` the perpendicular to the edge, `|l| sin(nu)` is the lever arm of
//! the force about the edge. So an angle `nu` above its stop level `nu_stop` is an arm above
//! `|l| sin(nu_stop)`, and no arc tangent is needed.

use super::edge_margin::weigh;
use super::energy::stopping_speed;
use super::evaluation::Evaluation;
use super::parameters::Parameters;
use super::support::Stance;
use crate::math::vector::Vector;
use crate::math::{max, root_of_sum};

/// Computes margins and decides with a hysteresis which of them count.
#[derive(Clone, Debug, Default)]
pub struct Criterion {
    fast: bool,
}

impl Criterion {
    /// Computes the margins of a `stance` with the specific `force` in level axes (upward at rest),
    /// m/s^2, and the `speed` over ground, m/s.
    ///
    /// Accepts any input, also NaN. Computes every margin whichever counts, so that the cost is
    /// constant. Edges that do not exist have the margins of [`Stance::margins`].
    #[inline(never)]
    pub fn evaluate(
        &mut self,
        stance: &Stance,
        force: Vector<f32>,
        speed: f32,
        parameters: &Parameters,
    ) -> Evaluation {
        let deduction = parameters.uncertainty.deduction();
        let tilt = [force[0] / force[2], force[1] / force[2]];
        let uncertain = deduction * (tilt[0].abs() + tilt[1].abs());
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
            found.gravity[index] = weighed.gravity - deduction;
            found.levers[index] = weighed.lever;
            with_force[index] = weighed.with_force - deduction;
            shift = max(shift, weighed.shift);
            height = if weighed.height > height {
                weighed.height
            } else {
                height
            };
        }
        let critical = stopping_speed(parameters.stop, root_of_sum(height) + deduction);
        // Hysteresis: a tenth of the speed and half of the shift. The comparisons are false for
        // NaN.
        let (speed_share, shift_share) = if self.fast { (0.9, 0.25) } else { (1.0, 0.5) };
        found.stop_would_tip = !(speed.abs() < critical * speed_share);
        let slow = !found.stop_would_tip && shift < parameters.stop * shift_share;
        self.fast = !slow;
        found.force_counts = self.fast;
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
        // The force-angle has its own test and is switched off here.
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
            assert_eq!(found.force_counts, speed > 0.0);
            for (margin, expected) in found.gravity.iter().zip(expected) {
                assert!((margin - expected).abs() < 1e-6, "{found:?}");
            }
        }
        assert_eq!(judged(LEVEL, 0.0).margins, judged(LEVEL, 0.0).gravity);
    }

    /// The expected margin is that of the point where the line through the centre of gravity along
    /// the force meets the plane of the support, in double precision.
    #[test]
    fn with_force_the_margin_is_that_of_the_projection_along_it() {
        let force = [-2.0_f32, 0.7, 9.0];
        let found = judged(force, 0.0);
        assert!(
            found.force_counts,
            "2 m/s^2 at 0.25 m is more than half of the stop margin"
        );
        assert!(
            found.margins[0] <= 0.3 + 1e-6,
            "never wider than without: {found:?}"
        );
        // The front edge is at z = 0.1; the force moves the point forward.
        let forward = 0.3 + 0.15 * 2.0 / 9.0;
        let error = f64::from(found.margins[1]) - (0.8 - forward);
        assert!(error.abs() < 1e-5, "{found:?}");
    }

    /// The margin is above the stop margin if and only if the angle of Papadopoulos and Rey is
    /// above the stop angle.
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
