//! Margins and their rates from one evaluation to the next.

use super::criterion::Evaluation;
use super::support::Stance;
use crate::math::min;

/// Margins with their rates, and the speed with which they came about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Margins {
    /// m, indexed by [`Edge`].
    pub now: [f32; 4],
    /// m/s, without the decay that the robot's own change of shape explains.
    pub rate: [f32; 4],
    /// Forward speed, as late as the rates are, m/s.
    pub speed: f32,
}

/// Tracks margins and their rates from one evaluation to the next.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    /// Margins of the centre of gravity at the evaluation before, with rates and speed.
    before: Option<Margins>,
    standing: [bool; 4],
}

impl Tracker {
    /// Time in which rates and speed follow, s: a single sample moves them little.
    const RATE_TIME: f32 = 0.1;

    /// Takes the margins of a stance `period` s after the evaluation before, the rates that the motion
    /// of the robot's shape gives them, and the forward speed that was passed on, m/s.
    ///
    /// The rates of the shape are taken off where they narrow a margin: they end when the guard ends
    /// the motion, so they say nothing of what else will happen.
    /// Rates are those of the centre of gravity alone: the measured force counts by how far it has
    /// moved a margin, but it comes and goes with every bump. Rates begin anew when other wheels
    /// stand than before. A rate from or to a margin that is not finite is zero.
    #[inline(never)]
    pub fn update(
        &mut self,
        stance: &Stance,
        found: &Evaluation,
        shape: &[f32; 4],
        speed: f32,
        period: f32,
    ) -> Margins {
        let share = period / (Self::RATE_TIME + period);
        let standing = stance.standing();
        let same = self.standing == standing;
        self.standing = standing;
        let before = self.before.filter(|_| same).unwrap_or(Margins {
            now: found.gravity,
            rate: [0.0; 4],
            speed,
        });
        let mut rate = before.rate;
        for (index, rate) in rate.iter_mut().enumerate() {
            let slope =
                (found.gravity[index] - before.now[index]) / period - min(shape[index], 0.0);
            let next = *rate + (slope - *rate) * share;
            *rate = if next.is_finite() { next } else { 0.0 };
        }
        let gravity = Margins {
            now: found.gravity,
            rate,
            speed: before.speed + (speed - before.speed) * share,
        };
        self.before = Some(gravity);
        Margins {
            now: found.margins,
            ..gravity
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shape does not change.
    const STILL: [f32; 4] = [0.0; 4];

    fn found(gravity: [f32; 4]) -> Evaluation {
        Evaluation {
            margins: gravity,
            gravity,
            ..Evaluation::default()
        }
    }

    #[test]
    fn a_rate_follows_a_slope_but_not_one_sample() {
        let stance = Stance::default();
        let mut tracker = Tracker::default();
        for step in 0..500 {
            let sinking = found([0.3 - 0.001 * step as f32, 0.3, 0.15, 0.15]);
            tracker.update(&stance, &sinking, &STILL, 0.1, 4e-3);
        }
        let last = [0.3 - 0.001 * 500.0, 0.3, 0.15, 0.15];
        let after = tracker.update(&stance, &found(last), &STILL, 0.1, 4e-3);
        assert!((after.rate[0] + 0.25).abs() < 1e-3, "{after:?}");
        let jump = tracker.update(
            &stance,
            &found([last[0], 0.3, 0.10, 0.15]),
            &STILL,
            0.1,
            4e-3,
        );
        assert!(jump.rate[2] > -0.6, "{jump:?}");
    }

    /// The front narrows with 0.4 m/s as the shape foresees, the back with 0.3 m/s instead of 0.1.
    #[test]
    fn decay_that_the_shape_explains_is_left_out_and_growth_of_the_shape_hides_nothing() {
        let mut tracker = Tracker::default();
        let shape = [-0.1, -0.4, 0.2, 0.2];
        let mut last = Margins::default();
        for step in 0..500 {
            let time = 4e-3 * step as f32;
            let now = found([1.0 - 0.3 * time, 1.0 - 0.4 * time, 1.0 + 0.2 * time, 1.0]);
            last = tracker.update(&Stance::default(), &now, &shape, 0.1, 4e-3);
        }
        for (rate, expected) in last.rate.into_iter().zip([-0.2, 0.0, 0.2, 0.0]) {
            assert!((rate - expected).abs() < 1e-3, "{last:?}");
        }
    }

    #[test]
    fn a_bump_narrows_a_margin_but_is_no_decay() {
        let mut tracker = Tracker::default();
        let still = found([0.3; 4]);
        tracker.update(&Stance::default(), &still, &STILL, 0.1, 4e-3);
        let bump = Evaluation {
            margins: [0.2; 4],
            ..still
        };
        let after = tracker.update(&Stance::default(), &bump, &STILL, 0.1, 4e-3);
        assert_eq!((after.now, after.rate), ([0.2; 4], [0.0; 4]));
    }

    #[test]
    fn a_margin_that_is_no_number_does_not_outlive_itself() {
        let mut tracker = Tracker::default();
        tracker.update(&Stance::default(), &found([f32::NAN; 4]), &STILL, 0.0, 4e-3);
        for _ in 0..2 {
            let after = tracker.update(&Stance::default(), &found([0.3; 4]), &STILL, 0.0, 4e-3);
            assert_eq!(after.rate, [0.0; 4]);
        }
    }
}
