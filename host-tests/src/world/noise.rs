//! Noise that depends only on seed, step and channel, not on the order of calls.

/// Source of noise for one plant.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    seed: u64,
}

impl Noise {
    /// Creates the noise of a run with this seed.
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// Returns a standard normal number for this step and channel (Box and Muller's transform).
    pub fn normal(&self, step: u64, channel: u64) -> f64 {
        let bits = mix(self.seed ^ mix(step.wrapping_mul(64).wrapping_add(channel)));
        // Two uniform numbers in (0, 1), of 32 bits each.
        let uniform = |half: u64| ((half & 0xffff_ffff) as f64 + 0.5) / 4_294_967_296.0;
        libm::sqrt(-2.0 * libm::log(uniform(bits)))
            * libm::cos(core::f64::consts::TAU * uniform(bits >> 32))
    }

    /// Returns `value` with noise of standard deviation `sigma`, rounded to a multiple of `quantum`
    /// (0: not rounded).
    pub fn reading(&self, step: u64, channel: u64, value: f64, sigma: f64, quantum: f64) -> f64 {
        let noisy = value + sigma * self.normal(step, channel);
        if quantum > 0.0 {
            libm::round(noisy / quantum) * quantum
        } else {
            noisy
        }
    }
}

/// Finalizer of the splittable generator of Steele, Lea and Flood (2014).
pub fn mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_standard_normal_and_depends_on_seed_step_and_channel_alone() {
        let noise = Noise::new(7);
        let count = 100_000;
        let (mut mean, mut square, mut beyond_two) = (0.0, 0.0, 0);
        for step in 0..count {
            let value = noise.normal(step, 3);
            mean += value / count as f64;
            square += value * value / count as f64;
            beyond_two += u64::from(value.abs() > 2.0);
        }
        assert!(
            mean.abs() < 0.02 && (square - 1.0).abs() < 0.03,
            "mean {mean}, variance {square}"
        );
        // 4.55 % of a normal distribution are more than two standard deviations from the mean.
        assert!(beyond_two.abs_diff(4_550) < 300, "{beyond_two}");
        assert_eq!(noise.normal(5, 3), Noise::new(7).normal(5, 3));
        let others = [
            noise.normal(6, 3),
            noise.normal(5, 4),
            Noise::new(8).normal(5, 3),
        ];
        assert!(others.iter().all(|other| *other != noise.normal(5, 3)));
    }
}
