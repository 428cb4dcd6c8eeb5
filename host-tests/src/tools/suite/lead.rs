//! Measures how early the guard acts before the last moment at which letting go saves the robot.

use crate::simulator::record::Sample;

/// Limits of how early the guard may act before the last moment at which letting go still saves the
/// robot, m and s. It acts too early if it exceeds both, and if the robot has moved by as much: the
/// tracks may slip under a robot that hangs on a steep ramp.
const EARLIEST_M: f64 = 0.25;
const EARLIEST_S: f64 = 1.0;

/// What the robot would still do without the guard, from the moment when the guard acts to the last
/// moment at which letting go saves it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lead {
    /// Travel of the belts, m.
    pub travel_m: f64,
    /// Distance that the centre of gravity moves, m.
    moved_m: f64,
    /// Time, s.
    time_s: f64,
}

impl Lead {
    /// Lead in a run without the guard; all zero if the run has no samples.
    pub fn between(without: &[Sample], acted_s: f64, savable_until_s: f64) -> Self {
        let at = |time_s: f64| {
            let until = without.partition_point(|sample| sample.time_s <= time_s);
            without.get(until.saturating_sub(1))
        };
        let time_s = savable_until_s - acted_s;
        let (Some(from), Some(to)) = (at(acted_s), at(savable_until_s)) else {
            return Self::default();
        };
        let [from_cog, to_cog] = [from, to].map(|sample| sample.truth.cog);
        let squares = from_cog.iter().zip(to_cog).map(|(a, b)| (b - a) * (b - a));
        Self {
            travel_m: to.received.odometry - from.received.odometry,
            moved_m: squares.sum::<f64>().sqrt(),
            time_s,
        }
    }

    /// Whether the guard acts too early.
    pub fn is_too_long(self) -> bool {
        self.travel_m.min(self.moved_m) > EARLIEST_M && self.time_s > EARLIEST_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lead of 4 s at 0.1 m/s by the belts, of a robot whose centre of gravity moves with `speed`,
    /// m/s.
    fn lead(speed: f64) -> Lead {
        let samples: Vec<Sample> = (0..10)
            .map(|time| {
                let mut sample = Sample {
                    time_s: f64::from(time),
                    ..Sample::default()
                };
                sample.received.odometry = 0.1 * sample.time_s;
                sample.truth.cog[0] = speed * sample.time_s;
                sample
            })
            .collect();
        Lead::between(&samples, 2.0, 6.0)
    }

    #[test]
    fn a_guard_acts_too_early_only_before_a_robot_that_moves() {
        assert!(lead(0.07).is_too_long());
        let slipping = lead(0.06);
        assert!((slipping.travel_m - 0.4).abs() < 1e-12);
        assert!((slipping.moved_m - 0.24).abs() < 1e-12);
        assert!(!slipping.is_too_long());
    }
}
