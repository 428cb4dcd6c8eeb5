//! Geometry of the driving screw of a variable-geometry track: the extension that keeps the belt
//! taut at a chassis angle, and the slack that another extension leaves.
//!
//! Axles 1 and 2 are `L1` apart, and axle 3 is `r = L2 + L3` from axle 2. The tracks are taut when
//! the sides of this triangle satisfy `L + (L2 + L3) = K`, where `L` is the distance of axles 1 and
//! 3 (Paillat et al., Variable Geometry Tracked Unmanned Grounded Vehicle, eq. 1). Axle 3 then
//! moves on an ellipse around axles 1 and 2. Solved for the screw (eq. 2):
//! `r = (K^2 - L1^2) / (2 (K + L1 cos theta))`. Cosine is even, so the sign of `theta` does not
//! matter.

mod slack;
mod table;
mod tension;

pub use slack::SlackLaw;
pub use tension::Tension;

use crate::math::cubic::{mul_high, mul_high_add, quantize};
use crate::math::{atan2, max, sin_cos, sqrt};
use crate::units::Angle;
pub use crate::units::Length;
use core::f64::consts::PI;

/// Number of pieces over half a turn. It is 128 and not 64, so that the derivative of the same
/// cubic can serve as feed-forward.
const PIECES: usize = 128;
/// Bits of an angle within a piece. A folded angle has 31 bits for half a turn.
const PIECE_BITS: u32 = 24;
/// Fraction bits of the sums below the constant term in addition to those of a product's high word.
/// They give the derivative its resolution.
const EXTRA_BITS: u32 = 7;
/// Fractional bits of a [`Length`].
const Q: u32 = Length::FRAC_NBITS;
/// Rounding error of decimal lengths in fixed point, 2^-28 m. It makes a geometry exactly on a
/// bound acceptable.
const ROUNDING: i32 = 2;

/// Screw extension and its derivative with respect to the chassis angle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Extension {
    /// Extension `L3`, metres.
    pub length: Length,
    /// `dL3 / dtheta`, metres per radian.
    pub derivative: Length,
}

/// Reason why lengths do not describe a screw that can be driven.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GeometryError {
    /// The distance `L1` of axles 1 and 2 is outside of the range of the tables.
    L1OutOfRange {
        /// The given length.
        got: Length,
        /// Minimum length, [`Geometry::MIN_L1`].
        minimum: Length,
        /// Maximum length, [`Geometry::MAX_L1`].
        maximum: Length,
    },
    /// The fixed part `L2` is negative.
    L2BelowMinimum {
        /// The given length.
        got: Length,
        /// Minimum length: zero.
        minimum: Length,
    },
    /// The belt constant `K` is below `L1 + 2 L2`. With the front straight, the screw would need a
    /// negative extension.
    KBelowChain {
        /// The given length.
        got: Length,
        /// Minimum length: `L1 + 2 L2`.
        minimum: Length,
    },
    /// The belt constant `K` is below `2.4 L1`. The extension would then curve too sharply for the
    /// stated errors.
    KBelowRatio {
        /// The given length.
        got: Length,
        /// Minimum length: `2.4 L1`.
        minimum: Length,
    },
    /// The belt constant `K` is above the range of the tables.
    KAboveMaximum {
        /// The given length.
        got: Length,
        /// Maximum length, [`Geometry::MAX_K`].
        maximum: Length,
    },
}

/// Error: no chassis angle makes the belt taut at this extension.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LengthOutOfRange {
    /// The given extension.
    pub got: Length,
    /// Extension at angle zero, the minimum: [`Geometry::released_length`].
    pub minimum: Length,
    /// Extension at half a turn, the maximum.
    pub maximum: Length,
}

/// A checked geometry, with the table (2 KiB) that makes its extension cheap to evaluate.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Geometry {
    l1: Length,
    l2: Length,
    k: Length,
    pieces: [[i32; 4]; PIECES],
}

impl Geometry {
    /// Minimum distance of axles 1 and 2: 10 mm.
    pub const MIN_L1: Length = Length::lit("0.01");
    /// Maximum distance of axles 1 and 2: 1 m.
    pub const MAX_L1: Length = Length::lit("1");
    /// Maximum `K`: 4 m.
    pub const MAX_K: Length = Length::lit("4");

    /// Creates a geometry with the distance `l1` of axles 1 and 2, the fixed part `l2` of the front
    /// segment and the belt constant `k`.
    ///
    /// Accepted: `l1` from 10 mm to 1 m, `l2 >= 0`, `k` up to 4 m, `k >= l1 + 2 l2` and
    /// `k >= 2.4 l1`, the last two to within the rounding of decimal lengths. The table is computed
    /// in integers, so it is bit-identical on every machine. Cost: about 13 000 products and
    /// quotients of 64 bits; it is meant for start-up.
    ///
    /// # Errors
    /// The first bound that is broken, with the given length.
    #[inline(never)] // its table is large, and each inlined copy takes stack
    pub fn new(l1: Length, l2: Length, k: Length) -> Result<Self, GeometryError> {
        Self::check(l1, l2, k)?;
        let mut geometry = Self::without_table(l1, l2, k);
        table::fill(&mut geometry.pieces, l1, l2, k);
        Ok(geometry)
    }

    /// Creates a geometry in `place` as [`Self::from_micrometres`] does: so its table is not copied
    /// through the stack.
    ///
    /// # Errors
    /// Those of [`Self::new`]; `place` does not change.
    #[inline(never)] // its table is large, and each inlined copy takes stack
    pub fn create_in(
        place: &mut Option<Self>,
        [l1_um, l2_um, k_um]: [i32; 3],
    ) -> Result<&Self, GeometryError> {
        let (l1, l2, k) = (micrometres(l1_um), micrometres(l2_um), micrometres(k_um));
        Self::check(l1, l2, k)?;
        let geometry = place.insert(Self::without_table(l1, l2, k));
        table::fill(&mut geometry.pieces, l1, l2, k);
        Ok(geometry)
    }

    fn without_table(l1: Length, l2: Length, k: Length) -> Self {
        let pieces = [[0; 4]; PIECES];
        Self { l1, l2, k, pieces }
    }

    /// Checks the lengths as [`Self::new`] does, without its cost.
    ///
    /// # Errors
    /// The first bound that is broken, with the given length.
    pub fn check(l1: Length, l2: Length, k: Length) -> Result<(), GeometryError> {
        if l1 < Self::MIN_L1 || l1 > Self::MAX_L1 {
            let (minimum, maximum) = (Self::MIN_L1, Self::MAX_L1);
            return Err(GeometryError::L1OutOfRange {
                got: l1,
                minimum,
                maximum,
            });
        }
        if l2 < Length::ZERO {
            return Err(GeometryError::L2BelowMinimum {
                got: l2,
                minimum: Length::ZERO,
            });
        }
        if k > Self::MAX_K {
            return Err(GeometryError::KAboveMaximum {
                got: k,
                maximum: Self::MAX_K,
            });
        }
        let with_rounding = k.saturating_add(Length::from_bits(ROUNDING));
        let chain = l1.saturating_add(l2).saturating_add(l2);
        if with_rounding < chain {
            return Err(GeometryError::KBelowChain {
                got: k,
                minimum: chain,
            });
        }
        // At most 2.4 m, so this product cannot overflow.
        let ratio = Length::from_bits((i64::from(l1.to_bits()) * 12 / 5) as i32);
        if with_rounding < ratio {
            return Err(GeometryError::KBelowRatio {
                got: k,
                minimum: ratio,
            });
        }
        Ok(())
    }

    /// Creates a geometry as [`Self::new`] does, from lengths in micrometres, as the settings have
    /// them. Each length is rounded to the nearest 2^-28 m and saturates at 8 m.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn from_micrometres(l1_um: i32, l2_um: i32, k_um: i32) -> Result<Self, GeometryError> {
        Self::new(micrometres(l1_um), micrometres(l2_um), micrometres(k_um))
    }

    /// Checks lengths in micrometres as [`Self::from_micrometres`] does, without its cost.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn check_micrometres(l1_um: i32, l2_um: i32, k_um: i32) -> Result<(), GeometryError> {
        Self::check(micrometres(l1_um), micrometres(l2_um), micrometres(k_um))
    }

    /// Returns the distance `L1` of axles 1 and 2.
    #[inline]
    pub fn l1(&self) -> Length {
        self.l1
    }

    /// Returns the fixed part `L2` of the front segment.
    #[inline]
    pub fn l2(&self) -> Length {
        self.l2
    }

    /// Returns the belt constant `K`.
    #[inline]
    pub fn k(&self) -> Length {
        self.k
    }

    /// Returns the extension `L3` that keeps the tracks taut at chassis angle `theta` (Paillat et
    /// al., eq. 2).
    ///
    /// Domain: every `Angle`. Worst error: 0.068 of 2^-24 m over all 2^32 angles of the nominal
    /// geometry, 0.081 of 2^-24 m over sampled geometries (`shared/tests/screw.rs`,
    /// `extension_keeps_its_errors_*`). Cost on Cortex-M4: 16 instructions as a function, 13
    /// inlined.
    #[inline]
    pub fn length(&self, theta: Angle) -> Length {
        let (_, u, [c0, c1, c2, c3]) = self.piece(theta);
        let slope = mul_high_add(c1, u, mul_high_add(c2, u, c3));
        Length::from_bits(c0.wrapping_add(mul_high(slope, u) >> EXTRA_BITS))
    }

    /// Returns the extension `L3` that keeps the tracks taut at chassis angle `theta` (Paillat et
    /// al., eq. 2), with its derivative, which is the feed-forward of the screw:
    /// `dL3 / dtheta = r L1 sin(theta) / (K + L1 cos(theta))`.
    ///
    /// Domain: every `Angle`. Worst error of the length: as for [`Self::length`]. Worst error of
    /// the derivative: 1.4e-7 m/rad over all 2^32 angles of the nominal geometry, 1.0e-6 m/rad over
    /// sampled geometries, at `L1` = 1 m (`shared/tests/screw.rs`). Cost on Cortex-M4: 24
    /// instructions as a function.
    #[inline]
    pub fn extension(&self, theta: Angle) -> Extension {
        /// One radian in half pieces, without the scale of the coefficients:
        /// `2 PIECES / pi = 2^8 / pi`.
        const PER_RADIAN: i32 = quantize(1.0 / PI, 32);
        let (sign, u, [c0, c1, c2, c3]) = self.piece(theta);
        let bend = mul_high_add(c2, u, c3);
        let slope = mul_high_add(c1, u, bend);
        let length = c0.wrapping_add(mul_high(slope, u) >> EXTRA_BITS);
        // Horner's scheme, applied once more to its own sums, differentiates the cubic.
        let tangent = mul_high_add(slope, u, mul_high_add(bend, u, c3));
        let derivative = mul_high_add(0, tangent, PER_RADIAN);
        Extension {
            length: Length::from_bits(length),
            derivative: Length::from_bits(derivative ^ sign),
        }
    }

    /// Returns the sign mask of `theta`, its position within its piece (-1 to 1 in Q31), and the
    /// coefficients of the piece.
    #[inline]
    fn piece(&self, theta: Angle) -> (i32, i32, [i32; 4]) {
        let sign = theta.to_bits() >> 31;
        // The complement mirrors negative angles about minus half a bit. So half a turn needs no
        // special case.
        let folded = theta.to_bits() ^ sign;
        let index = (folded as u32 >> PIECE_BITS) as usize % PIECES;
        let u = (folded << (32 - PIECE_BITS)) ^ i32::MIN;
        (sign, u, self.pieces[index])
    }

    /// Returns the chassis angle, from 0 to half a turn, at which the belt is taut at extension
    /// `length`. The extension does not tell the sign of the angle.
    ///
    /// The formula is `tan^2(theta / 2) = (K + L1)(2 r - (K - L1)) / ((K - L1)((K + L1) - 2 r))`.
    /// It follows from eq. 2 and keeps its precision at both ends, where a cosine would lose it. A
    /// length beyond an end by at most 2^-24 m counts as that end. Other lengths beyond an end are
    /// refused.
    ///
    /// # Errors
    /// [`LengthOutOfRange`] if no angle makes the belt taut at `length`.
    pub fn inverse(&self, length: Length) -> Result<Angle, LengthOutOfRange> {
        const TOLERANCE: i64 = 1 << (Q - 24);
        let twice = |x: Length| 2 * i64::from(x.to_bits());
        let (l1, k) = (i64::from(self.l1.to_bits()), i64::from(self.k.to_bits()));
        let twice_r = twice(self.l2) + twice(length);
        let (above, below) = (twice_r - (k - l1), (k + l1) - twice_r);
        if above < -2 * TOLERANCE || below < -2 * TOLERANCE {
            return Err(LengthOutOfRange {
                got: length,
                minimum: self.released_length(),
                maximum: Length::from_bits(((k + l1) >> 1) as i32 - self.l2.to_bits()),
            });
        }
        let y = sqrt((k + l1) as f32 * above.max(0) as f32);
        let x = sqrt((k - l1) as f32 * below.max(0) as f32);
        let half_angle = atan2(y, x);
        // The cast saturates. So half a turn is the largest positive angle, not the most negative
        // one.
        Ok(Angle::from_bits(
            (half_angle * (2.0 * 2_147_483_648.0 / PI) as f32) as i32,
        ))
    }

    /// Returns the largest extension that never tightens the belt: `(K - L1) / 2 - L2`. There the
    /// belt is just tight at angle zero, and slack at every other chassis angle.
    pub fn released_length(&self) -> Length {
        // Both terms are at most 4 m.
        Length::from_bits(((self.k.to_bits() - self.l1.to_bits()) >> 1) - self.l2.to_bits())
    }

    /// Returns the slack of the belt at chassis angle `theta` and extension `length`: `K - r - L`.
    /// Negative slack is strain.
    ///
    /// With `r*` as the taut side, `(K - r)^2 - L^2 = (K^2 - L1^2)(r* - r) / r*`. So the slack is
    /// computed from the difference to the taut extension: there is no cancellation, and the slack
    /// is exactly zero at [`Self::length`]. It is defined for every input and saturates at the
    /// range of [`Length`].
    pub fn slack(&self, theta: Angle, length: Length) -> Length {
        let taut = self.length(theta);
        let bits = |x: Length| i64::from(x.to_bits());
        let float = |bits: i64| bits as f32 / (1 << Q) as f32;
        let (k, l1) = (bits(self.k), bits(self.l1));
        let loose = float(bits(taut) - bits(length));
        let belt = float(k - bits(self.l2) - bits(length));
        let side = float(bits(taut) + bits(self.l2));
        let difference = float(k + l1) * float(k - l1) * loose / side;
        // The law of cosines with the half angle is a sum of squares. It is precise even where axle
        // 3 comes close to axle 1.
        let r = bits(self.l2) + bits(length);
        let (_, half_cosine) = sin_cos(Angle::from_bits(theta.to_bits() >> 1));
        let chord = 4.0 * float(l1) * float(r) * half_cosine * half_cosine;
        let distance = sqrt(max(float(r - l1) * float(r - l1) + chord, 0.0));
        // A screw longer than the whole belt leaves no triangle to tighten. The definition still
        // holds.
        let slack = if belt > 0.0 {
            difference / (belt + distance)
        } else {
            belt - distance
        };
        Length::from_bits((slack * (1 << Q) as f32) as i32)
    }
}

/// Converts `length` to metres in single precision, rounded to nearest. The general conversion of
/// its type costs ten times as much.
#[inline]
pub fn metres(length: Length) -> f32 {
    length.to_bits() as f32 * (1.0 / (1u64 << Q) as f32)
}

/// Converts micrometres, rounded to nearest; saturates at 8 m.
fn micrometres(um: i32) -> Length {
    let scaled = i64::from(um) << Q;
    let half = if scaled < 0 { -500_000 } else { 500_000 };
    let bits = (scaled + half) / 1_000_000;
    Length::from_bits(bits.clamp(i32::MIN.into(), i32::MAX.into()) as i32)
}
