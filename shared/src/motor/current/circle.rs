//! The circle in which a voltage vector stays: the voltages that three half bridges can give in
//! every direction.

use crate::math::cubic::{mul_high, mul_high_add};
use crate::math::{Bound, to_i32};

/// Limit of a voltage vector, or of one voltage; 2^24 is full scale.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Circle {
    radius: i32,
    /// The radius as a limit of one component.
    pub(super) bound: Bound,
    /// `2^50 / radius`, rounded up; it does not matter for a radius of 0.
    inverse: i32,
}

impl Default for Circle {
    /// Allows no voltage.
    fn default() -> Self {
        Self::new(0)
    }
}

/// Smallest radius above zero.
const MIN_RADIUS: i32 = (1 << 19) + 1;

/// The square of a ratio, 2^18 is one, has pieces of this number of bits. Each is centred on a
/// multiple of its width.
const PIECE_BITS: u32 = 13;

/// `sqrt(1 - y)` in pieces of `y`: its value in the middle of a chord, 2^30 is one, and half of the
/// chord's height, 2^31 is one. The last chord ends in the middle of its piece, at `y = 1`.
static ROOT: [[i32; 2]; 64] = {
    let mut table = [[0; 2]; 64];
    let mut piece = 0;
    while piece < 32 {
        let square = piece << PIECE_BITS;
        let half = 1 << (PIECE_BITS - 1);
        let (near, far) = (root_beside(square - half), root_beside(square + half));
        table[piece as usize] = [i64::midpoint(near, far) as i32, (far - near) as i32];
        table[piece as usize + 1] = [0, (-2 * far) as i32];
        piece += 1;
    }
    table
};

/// `sqrt(1 - square)`; 2^30 is one. It is rounded down, and taken two units of the square later,
/// because the square is rounded down.
const fn root_beside(square: i64) -> i64 {
    let left = (1_i64 << 18) - (square + 2);
    (left << 42).isqrt()
}

impl Circle {
    /// Creates a circle with this radius. A radius above full scale counts as full scale, and one
    /// below 2^19 (2 V) as 0.
    pub fn new(radius: i32) -> Self {
        let radius = match radius {
            ..MIN_RADIUS => 0,
            _ => radius.min((1 << 24) - 1),
        };
        // The smallest number above 2^50, so that the quotient is rounded up.
        let dividend = (1_u64 << 50) as f32 * (1.0 + f32::EPSILON);
        let inverse = dividend / radius.max(MIN_RADIUS) as f32;
        Self {
            radius,
            bound: Bound::new(radius),
            inverse: to_i32(inverse),
        }
    }

    /// Returns the radius; 0 if no voltage is allowed.
    #[inline]
    pub fn radius(&self) -> i32 {
        self.radius
    }

    /// Returns the limit of the component beside `leg`: of the other leg in a right-angled triangle
    /// with the radius as its hypotenuse. It is rounded down. A vector of the two legs leaves the
    /// circle by less than two units.
    ///
    /// Domain: `leg` within [`Self::bound`]. The root is interpolated with chords, which lie inside
    /// the circle: the result is at most 3.2 % of the radius too small, and 0.02 % while the leg is
    /// shorter than half of the radius.
    #[inline]
    pub(super) fn beside(&self, leg: i32) -> Bound {
        let ratio = mul_high(leg << 7, self.inverse); // 2^25 is one
        let square = mul_high(ratio, ratio);
        let piece = (square + (1 << (PIECE_BITS - 1))) as u32 >> PIECE_BITS;
        let [middle, slope] = ROOT[piece as usize % ROOT.len()];
        let along = square << (32 - PIECE_BITS); // -1 to 1, 2^31 is one
        let root = mul_high_add(middle, along, slope);
        Bound::new(mul_high(root, self.radius << 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest value that a bound allows.
    fn largest(bound: Bound) -> i32 {
        bound.limit(i32::MAX)
    }

    #[test]
    fn two_legs_stay_in_the_circle_and_use_what_there_is() {
        let radii = [MIN_RADIUS, 720_311, 3_450_881, 9_999_999, (1 << 24) - 1];
        for radius in radii {
            let circle = Circle::new(radius);
            assert_eq!(circle.radius(), radius);
            for step in -10_000_i32..=10_000 {
                let leg = (i64::from(step) * i64::from(radius) / 10_000) as i32;
                let beside = largest(circle.beside(leg));
                let exact = (f64::from(radius).powi(2) - f64::from(leg).powi(2)).sqrt();
                let missing = (exact - f64::from(beside)) / f64::from(radius);
                let most = if leg.abs() < radius / 2 { 2e-4 } else { 0.032 };
                assert!((0.0..=most).contains(&missing), "{radius} {leg} {missing}");
            }
            assert_eq!(largest(circle.beside(radius)), 0);
            assert_eq!(largest(circle.beside(-radius - 1)), 0);
        }
    }

    #[test]
    fn a_radius_out_of_its_domain_is_replaced() {
        for radius in [i32::MIN, -1, 0, 1, MIN_RADIUS - 1] {
            let circle = Circle::new(radius);
            assert_eq!(circle.radius(), 0);
            for leg in [-1, 0] {
                assert_eq!(largest(circle.beside(leg)), 0);
            }
        }
        assert_eq!(Circle::new(i32::MAX).radius(), (1 << 24) - 1);
        assert_eq!(Circle::default(), Circle::new(0));
    }
}
