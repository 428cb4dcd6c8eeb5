//! Tracks margins and their rates from one evaluation to the next.

use super::evaluation::Evaluation;
use super::support::Stance;
use crate::math::max;

/// Margins with their rates, and the forward speed at which these rates arose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Margins {
    /// Margins, m, indexed by [`super::support::Edge`].
    pub now: [f32; 4],
    /// Rates of the margins, m/s, without the decay that the robot's own change of shape explains.
    pub rate: [f32; 4],
    /// Forward speed, low-pass filtered like the rates, m/s.
    pub speed: f32,
}

/// Tracker of margins and their rates.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    /// Margins of the centre of gravity at the previous evaluation, with rates and speed.
    before: Option<Margins>,
    standing: [bool; 4],
}

impl Tracker {
    /// Time constant of the low-pass of rates and speed, s. A single sample changes them little.
    const RATE_TIME: f32 = 0.1;

    /// Updates the rates with the margins of a stance, `period` s after the previous evaluation,
    /// and the forward speed that was passed on, m/s. `kept` are the margins that the robot would
    /// have now with its shape of the previous evaluation, m.
    ///
    /// A margin that the robot loses by its own change of shape does not count as decay, because
    /// the guard limits it where it limits the posture. So each rate uses the larger of the present
    /// margin and the margin with the kept shape.
    ///
    /// The rates are those of the centre of gravity alone. The measured force counts in the margin
    /// itself, but it comes and goes with every bump, so it does not count in the rate. The rates
    /// start again from zero when the set of wheels on the ground changes. A rate from or to a
    /// margin that is not finite is zero.
    #[inline(never)]
    pub fn update(
        &mut self,
        stance: &Stance,
        found: &Evaluation,
        kept: &[f32; 4],
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
            let slope = (max(found.gravity[index], kept[index]) - before.now[index]) / period;
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

    fn found(gravity: [f32; 4]) -> Evaluation {
        Evaluation {
            margins: gravity,
            gravity,
            ..Evaluation::default()
        }
    }

    /// Next evaluation, with a shape that does not change.
    fn next(tracker: &mut Tracker, stance: &Stance, found: &Evaluation) -> Margins {
        tracker.update(stance, found, &found.gravity, 0.1, 4e-3)
    }

    #[test]
    fn a_rate_follows_a_slope_but_not_one_sample() {
        let stance = Stance::default();
        let mut tracker = Tracker::default();
        for step in 0..500 {
            let sinking = found([0.3 - 0.001 * step as f32, 0.3, 0.15, 0.15]);
            next(&mut tracker, &stance, &sinking);
        }
        let last = [0.3 - 0.001 * 500.0, 0.3, 0.15, 0.15];
        let after = next(&mut tracker, &stance, &found(last));
        assert!((after.rate[0] + 0.25).abs() < 1e-3, "{after:?}");
        let jump = next(&mut tracker, &stance, &found([last[0], 0.3, 0.10, 0.15]));
        assert!(jump.rate[2] > -0.6, "{jump:?}");
    }

    /// Rear edge: the change of shape takes 0.1 of the 0.3 m/s by which the margin falls. Front
    /// edge: it takes all of 0.4 m/s. Left edge: it widens the margin by 0.2 m/s, but the margin
    /// falls by 0.1 m/s. Right edge: only the shape changes, and it widens the margin.
    #[test]
    fn decay_is_what_the_change_of_shape_does_not_explain() {
        let mut tracker = Tracker::default();
        let (rates, shape) = ([-0.3, -0.4, -0.1, 0.2], [-0.1, -0.4, 0.2, 0.2]);
        let mut last = Margins::default();
        for step in 0..500 {
            let margins = rates.map(|rate| 1.0 + rate * 4e-3 * step as f32);
            let kept: [f32; 4] = core::array::from_fn(|index| margins[index] - shape[index] * 4e-3);
            last = tracker.update(&Stance::default(), &found(margins), &kept, 0.1, 4e-3);
        }
        for (rate, expected) in last.rate.into_iter().zip([-0.2, 0.0, -0.1, 0.2]) {
            assert!((rate - expected).abs() < 2e-3, "{last:?}");
        }
    }

    #[test]
    fn a_bump_narrows_a_margin_but_is_no_decay() {
        let mut tracker = Tracker::default();
        let still = found([0.3; 4]);
        next(&mut tracker, &Stance::default(), &still);
        let bump = Evaluation {
            margins: [0.2; 4],
            ..still
        };
        let after = next(&mut tracker, &Stance::default(), &bump);
        assert_eq!((after.now, after.rate), ([0.2; 4], [0.0; 4]));
    }

    #[test]
    fn a_margin_that_is_no_number_does_not_outlive_itself() {
        let mut tracker = Tracker::default();
        next(&mut tracker, &Stance::default(), &found([f32::NAN; 4]));
        for _ in 0..2 {
            let after = next(&mut tracker, &Stance::default(), &found([0.3; 4]));
            assert_eq!(after.rate, [0.0; 4]);
        }
    }
}
