//! Limits how fast a speed grows after the filter has scaled it down.
//!
//! A robot that brakes rocks. As it rocks back, its margin widens and a larger speed would pass,
//! and it would speed up and brake again in time with the rocking, each time with a larger swing.

use super::super::support::Edge;
use super::{Verdict, within_limit};

/// Largest speeds that pass.
#[derive(Clone, Copy, Debug)]
pub struct Recovery {
    /// Backward and forward, m/s.
    most: [f32; 2],
    /// Edge that the last restriction protects.
    edge: Edge,
}

impl Default for Recovery {
    fn default() -> Self {
        Self {
            most: [f32::INFINITY; 2],
            edge: Edge::Back,
        }
    }
}

impl Recovery {
    /// Limits the scale of the commanded speed `forward`; `present` is the speed that is passed on
    /// (m/s). Both directions recover by `rise` (m/s) in each call, whatever is commanded.
    ///
    /// A restriction that is over before the robot has slowed down limits nothing.
    pub fn limit(
        &mut self,
        (scale, verdict): (f32, Verdict),
        forward: f32,
        present: f32,
        rise: f32,
    ) -> (f32, Verdict) {
        self.most = self.most.map(|most| most + rise);
        if forward == 0.0 {
            return (scale, verdict);
        }
        let most = &mut self.most[usize::from(forward > 0.0)];
        if let Verdict::Scaled(edge) | Verdict::Refused(edge) = verdict {
            let driven = if forward > 0.0 { present } else { -present };
            let passes = scale * forward.abs();
            let passes = if driven > passes { driven } else { passes };
            *most = if passes < *most { passes } else { *most };
            self.edge = edge;
        }
        within_limit((scale, verdict), forward, (*most, self.edge))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RISE: f32 = 2e-3;
    const PASSED: (f32, Verdict) = (1.0, Verdict::Passed);
    const REFUSED: (f32, Verdict) = (0.0, Verdict::Refused(Edge::Front));

    /// Speed that passes of a command.
    fn passes(recovery: &mut Recovery, found: (f32, Verdict), forward: f32, present: f32) -> f32 {
        forward * recovery.limit(found, forward, present, RISE).0
    }

    #[test]
    fn a_speed_falls_at_once_and_grows_slowly() {
        let mut recovery = Recovery::default();
        assert_eq!(passes(&mut recovery, PASSED, 0.4, 0.0), 0.4);
        assert_eq!(passes(&mut recovery, REFUSED, 0.4, 0.0), 0.0);
        for step in 1..200 {
            let (scale, verdict) = recovery.limit(PASSED, 0.4, 0.1, RISE);
            assert!((0.4 * scale - RISE * step as f32).abs() < 1e-5, "{step}");
            assert_eq!(verdict, Verdict::Scaled(Edge::Front));
        }
        passes(&mut recovery, PASSED, 0.4, 0.4);
        assert_eq!(passes(&mut recovery, PASSED, 0.4, 0.4), 0.4);
    }

    #[test]
    fn an_operator_cannot_hurry_it() {
        for other in [0.0, -0.4] {
            let mut recovery = Recovery::default();
            passes(&mut recovery, REFUSED, 0.4, 0.0);
            for step in 1..100 {
                passes(&mut recovery, PASSED, other, 0.0);
                let most = 2.0 * RISE * step as f32;
                assert!((passes(&mut recovery, PASSED, 0.4, 0.0) - most).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn less_than_what_passes_and_the_other_direction_pass_whole() {
        let mut recovery = Recovery::default();
        let half = (0.5, Verdict::Scaled(Edge::Front));
        assert_eq!(passes(&mut recovery, half, 0.4, 0.0), 0.2);
        assert_eq!(passes(&mut recovery, PASSED, 0.2, 0.2), 0.2);
        assert_eq!(passes(&mut recovery, PASSED, -0.4, 0.2), -0.4);
    }

    #[test]
    fn a_restriction_of_one_moment_limits_the_present_speed() {
        let mut recovery = Recovery::default();
        passes(&mut recovery, REFUSED, 0.4, 0.39);
        assert!((passes(&mut recovery, PASSED, 0.4, 0.385) - 0.392).abs() < 1e-6);
    }

    #[test]
    fn a_speed_that_rocks_passes_as_its_smallest_values_do() {
        let mut recovery = Recovery::default();
        let (mut most, mut present) = (0.0_f32, 0.0_f32);
        for step in 0..2_500 {
            let rocking = 0.5 * libm::sinf(step as f32 * 0.08);
            let scale = if rocking > 0.0 { rocking } else { 0.0 };
            let found = (scale, Verdict::Scaled(Edge::Front));
            // It brakes and speeds up with 3 m/s^2, in steps of 4 ms.
            let passed = passes(&mut recovery, found, 0.4, present);
            present += (passed - present).clamp(-0.012, 0.012);
            if step > 250 {
                most = most.max(present);
            }
        }
        assert!(most < 0.1, "{most}");
    }
}
