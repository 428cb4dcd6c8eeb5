//! Tension of the belts by the force of the screw.

use super::{Extension, SlackLaw, metres};

/// Time constant of the low-pass, s.
const TIME_CONSTANT: f32 = 0.02;

/// Estimate of the tension of the belts, N: the mean of both.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Tension {
    newtons: f32,
}

impl Tension {
    /// Returns the estimate, N; negative where the belts cannot be what loads the screw.
    pub fn newtons(self) -> f32 {
        self.newtons
    }

    /// Adds the tension `newtons` of one more period, s, which the low-pass of 20 ms smooths. One
    /// that is not finite does not change the estimate.
    #[inline]
    pub fn add(&mut self, newtons: f32, period: f32) {
        if newtons.abs() < f32::INFINITY {
            self.newtons += (newtons - self.newtons) * (period / TIME_CONSTANT);
        }
    }
}

impl SlackLaw {
    /// Returns the tension, N for each of two belts, at which the belts load the screw with 1 N.
    ///
    /// A belt is a loop around the three axles. It pulls with its tension times
    /// `1 + (r + L1 cos theta) / L`, by which the loop grows with the front's length `r`. By the
    /// law of the belt with `k = K - slack`, `L` is `k - r`, and this is
    /// `(k^2 - L1^2) / (2 r (k - r))`. So neither the angle nor a root is needed.
    ///
    /// `extension` must be one of [`Self::extension`], for which the worst relative error is 3e-7,
    /// or the released length, where it is 0.18 if the belt has less slack than `slack`
    /// (`shared/tests/screw.rs`). Bad slack counts as it does there.
    /// Cost: see "tension of the belts" of `cargo cost`, with the low-pass.
    #[inline]
    pub fn tension_per_force(&self, extension: Extension, slack: f32) -> f32 {
        let slack = self.within(slack);
        let r = metres(extension.length) + self.l2;
        let k = 0.5 * self.two_k - slack;
        r * (k - r) / (self.squares - slack * (self.two_k - slack))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_pass_takes_20_ms_and_ignores_what_is_not_finite() {
        let mut tension = Tension::default();
        for _ in 0..20 {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                tension.add(bad, 1e-3);
            }
            tension.add(100.0, 1e-3);
        }
        assert!((62.0..66.0).contains(&tension.newtons()), "{tension:?}");
    }
}
