//! Sweeps over all binary angles against double precision.

pub mod sweep;

use std::thread;
use tautrack::units::Angle;

/// Radians of one bit of an [`Angle`].
pub const RADIANS_PER_BIT: f64 = std::f64::consts::PI / 2_147_483_648.0;

/// Largest absolute value of each of `errors(angle, sin, cos)` over all 2^32 angles.
///
/// The reference sines come from the platform's library for 2^16 coarse and 2^16 fine angles, added
/// by the addition theorem (a few 1e-16 off), on two threads.
pub fn worst_over_all_angles<const N: usize>(
    errors: impl Fn(Angle, f64, f64) -> [f64; N] + Sync,
) -> [f64; N] {
    let fine: Vec<(f64, f64)> = (0..1 << 16)
        .map(|low| (f64::from(low) * RADIANS_PER_BIT).sin_cos())
        .collect();
    let half = |blocks: std::ops::Range<i32>| {
        let mut worst = [0.0; N];
        for block in blocks {
            let (sin_block, cos_block) = (f64::from(block << 16) * RADIANS_PER_BIT).sin_cos();
            for (low, (sin_low, cos_low)) in fine.iter().enumerate() {
                let angle = Angle::from_bits((block << 16) | low as i32);
                let sin = sin_block * cos_low + cos_block * sin_low;
                let cos = cos_block * cos_low - sin_block * sin_low;
                for (worst, error) in worst.iter_mut().zip(errors(angle, sin, cos)) {
                    // A NaN must not look like a small error.
                    let error = if error.is_nan() {
                        f64::INFINITY
                    } else {
                        error.abs()
                    };
                    *worst = if error > *worst { error } else { *worst };
                }
            }
        }
        worst
    };
    thread::scope(|scope| {
        let negative = scope.spawn(|| half(-(1 << 15)..0));
        let positive = half(0..1 << 15);
        let negative = negative.join().expect("a sweep does not panic");
        std::array::from_fn(|i| positive[i].max(negative[i]))
    })
}
