//! The law of a belt that is released: `L + (L2 + L3) = K - slack`. 0 is the taut belt.

use super::{Extension, Geometry, metres};
use crate::math::to_i32;
use crate::units::Length;

/// What a slack of the belt changes in the extension of the screw, for one [`Geometry`].
///
/// By eq. 2 of Paillat et al. the length of the front is
/// `r = (K^2 - L1^2) / (2 (K + L1 cos theta))`. The difference between this length for `K` and for
/// `K - s` is `s r (2 K - s - 2 r) / (K^2 - L1^2 - 2 s r)`, which does not contain `theta`. So the
/// table of the taut belt serves every slack.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SlackLaw {
    /// `L2`, m; `2 K`, m; and `K^2 - L1^2`, m^2.
    pub(super) l2: f32,
    pub(super) two_k: f32,
    pub(super) squares: f32,
    /// Half of `K - L1`, m.
    most: f32,
}

impl SlackLaw {
    /// Creates the law of this geometry.
    pub fn new(geometry: &Geometry) -> Self {
        let [l1, l2, k] = [geometry.l1(), geometry.l2(), geometry.k()].map(metres);
        Self {
            l2,
            two_k: k + k,
            squares: (k - l1) * (k + l1),
            most: 0.5 * (k - l1),
        }
    }

    /// Returns the extension, and its derivative with respect to the chassis angle, that leave the
    /// belt this slack, m, at the angle at which `taut` is the extension of the taut belt.
    ///
    /// Domain: any `slack`. A negative one and NaN count as 0, for which the result is `taut`
    /// itself. One above half of `K - L1`, which no extension can give, counts as that. The result
    /// may be below [`Geometry::released_length`]. Worst errors of the nominal geometry: 0.015 um
    /// and 1.5e-7 m/rad over all 2^32 angles at a slack of 50 mm, 0.12 um and 2e-7 m/rad over a
    /// dense grid of slacks and angles (`shared/tests/screw.rs`, `extension_with_*`). Cost on
    /// Cortex-M4: 44 instructions more than the taut extension.
    #[inline]
    pub fn extension(&self, taut: Extension, slack: f32) -> Extension {
        let slack = self.within(slack);
        if slack <= 0.0 {
            return taut;
        }
        let rest = self.two_k - slack;
        let r = metres(taut.length) + self.l2;
        let sr = slack * r;
        let inverse = 1.0 / (self.squares - (sr + sr));
        let retreat = sr * (rest - (r + r)) * inverse;
        // The derivative of `r` is proportional to `r^2 / (K^2 - L1^2)`.
        let steepness = self.squares * (self.squares - slack * rest) * (inverse * inverse);
        // Both are below 8 m.
        let fixed = |metres: f32| to_i32(metres * 268_435_456.0);
        Extension {
            length: taut
                .length
                .saturating_sub(Length::from_bits(fixed(retreat))),
            derivative: Length::from_bits(fixed(metres(taut.derivative) * steepness)),
        }
    }

    /// Returns the slack from 0 to half of `K - L1` that counts for `slack`; 0 for NaN.
    #[inline]
    pub(super) fn within(&self, slack: f32) -> f32 {
        if !(slack > 0.0) {
            0.0
        } else if slack < self.most {
            slack
        } else {
            self.most
        }
    }

    /// Returns the second derivative of an extension that leaves the belt this slack, m/rad^2:
    /// `2 r'^2 / r + r - 2 k r^2 / (k^2 - L1^2)` with `k = K - slack`, where the primes are
    /// derivatives by `theta`. The extension must be that of [`Self::extension`].
    pub fn second_derivative(&self, extension: Extension, slack: f32) -> f32 {
        let bend = (self.two_k - (slack + slack)) / (self.squares - slack * (self.two_k - slack));
        let (r, slope) = (
            self.l2 + metres(extension.length),
            metres(extension.derivative),
        );
        2.0 * slope * slope / r + r - bend * r * r
    }
}
