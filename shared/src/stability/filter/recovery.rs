//! Limits how fast the scale of a speed grows after the filter has lowered it.
//!
//! A robot that brakes rocks. As it rocks back, its margin widens and a larger scale would pass, and
//! it would speed up and brake again in time with the rocking, each time with a larger swing.

use super::Verdict;

/// Time in which the scale of a speed grows from 0 to 1, s: longer than a period of the rocking,
/// which is some 0.4 s in the crawler's simulation.
const RECOVERY_TIME: f32 = 1.0;

/// Scale of the speed that passed at the last evaluation.
#[derive(Clone, Copy, Debug)]
pub struct Recovery {
    scale: f32,
    verdict: Verdict,
    forward: f32,
}

impl Default for Recovery {
    fn default() -> Self {
        Self {
            scale: 1.0,
            verdict: Verdict::Passed,
            forward: 0.0,
        }
    }
}

impl Recovery {
    /// Limits the scale of the commanded speed `forward` (m/s), `period` s after the last call. A
    /// command in another direction begins anew, since it may lead out of danger.
    pub fn limit(
        &mut self,
        (scale, verdict): (f32, Verdict),
        forward: f32,
        period: f32,
    ) -> (f32, Verdict) {
        let direction = |speed: f32| (speed > 0.0, speed < 0.0);
        let most = if direction(forward) == direction(self.forward) {
            self.scale + period / RECOVERY_TIME
        } else {
            1.0
        };
        if scale > most {
            self.scale = most;
            if let Verdict::Refused(edge) = self.verdict {
                self.verdict = Verdict::Scaled(edge);
            }
        } else {
            (self.scale, self.verdict) = (scale, verdict);
        }
        self.forward = forward;
        (self.scale, self.verdict)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::support::Edge;
    use super::*;

    const PERIOD: f32 = 4e-3;
    const PASSED: (f32, Verdict) = (1.0, Verdict::Passed);

    #[test]
    fn a_scale_falls_at_once_and_grows_in_a_second() {
        let mut recovery = Recovery::default();
        assert_eq!(recovery.limit(PASSED, 0.4, PERIOD), PASSED);
        let refused = (0.0, Verdict::Refused(Edge::Front));
        assert_eq!(recovery.limit(refused, 0.4, PERIOD), refused);
        let mut before = 0.0;
        for _ in 0..249 {
            let (scale, verdict) = recovery.limit(PASSED, 0.4, PERIOD);
            assert_eq!(verdict, Verdict::Scaled(Edge::Front));
            assert!(scale > before && scale < before + 1.01 * PERIOD, "{scale}");
            before = scale;
        }
        assert!(before > 0.99);
        recovery.limit(PASSED, 0.4, PERIOD);
        assert_eq!(recovery.limit(PASSED, 0.4, PERIOD), PASSED);
    }

    #[test]
    fn another_direction_begins_anew() {
        let refused = (0.0, Verdict::Refused(Edge::Front));
        for [before, after] in [[0.4, -0.4], [-0.4, 0.4], [0.4, 0.0], [0.0, 0.4]] {
            let mut recovery = Recovery::default();
            recovery.limit(refused, before, PERIOD);
            assert_eq!(recovery.limit(PASSED, after, PERIOD), PASSED);
        }
    }

    #[test]
    fn a_scale_that_rocks_passes_as_its_smallest_values_do() {
        let mut recovery = Recovery::default();
        let mut most = 0.0_f32;
        for step in 0..2_500 {
            let rocking = 0.3 * libm::sinf(step as f32 * PERIOD * 20.0);
            let scale = if rocking > 0.0 { rocking } else { 0.0 };
            let verdict = Verdict::Scaled(Edge::Front);
            let (passed, _) = recovery.limit((scale, verdict), 0.4, PERIOD);
            if step > 250 {
                most = most.max(passed);
            }
        }
        assert!(most < 0.15, "{most}");
    }
}
