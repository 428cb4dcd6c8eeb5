//! Noise of simulated sensors. A counter-based generator makes sample `n` of seed `s` the same in
//! every run.

/// Stream of samples with mean 0 and standard deviation 1.
#[derive(Clone, Debug)]
pub struct Noise {
    seed: u64,
    counter: u64,
}

impl Noise {
    /// The stream of `seed`.
    pub const fn new(seed: u64) -> Self {
        Self { seed, counter: 0 }
    }

    /// Next 64 uniform bits.
    pub fn bits(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(1);
        mix(self.seed ^ mix(self.counter))
    }

    /// Next sample, nearly normal: the sum of four 16-bit uniforms, bounded by 3.47. It is
    /// bit-identical on every machine.
    pub fn sample(&mut self) -> f32 {
        let bits = self.bits();
        let sum = (0..4).fold(0_i32, |sum, lane| sum + (bits >> (16 * lane)) as u16 as i32);
        // A uniform on 0..=65535 has variance (2^32 - 1) / 12; four of them have a deviation of
        // 37836.9.
        (sum - 2 * 65_535) as f32 / 37_836.9
    }
}

/// Finalizer of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
/// Generators"): every bit of the input changes about half the bits of the output.
fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_mean_zero_and_deviation_one() {
        let mut noise = Noise::new(7);
        let count = 100_000;
        let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
        for _ in 0..count {
            let sample = f64::from(noise.sample());
            sum += sample;
            squares += sample * sample;
        }
        let mean = sum / f64::from(count);
        assert!(mean.abs() < 0.02, "{mean}");
        assert!((squares / f64::from(count) - 1.0).abs() < 0.02, "{squares}");
    }

    #[test]
    fn seeds_give_different_streams() {
        let (mut first, mut second) = (Noise::new(1), Noise::new(2));
        assert!((0..8).any(|_| first.sample() != second.sample()));
    }
}
