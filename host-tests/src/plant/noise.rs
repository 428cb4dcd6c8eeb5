//! Randomness that depends on nothing but seed, step and channel: no order of calls can change it.

/// Source of noise of one plant.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    seed: u64,
}

impl Noise {
    /// Noise of a run with this seed.
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// A number from the standard normal distribution for this step and channel (Box and Muller's transform).
    pub fn normal(&self, step: u64, channel: u64) -> f64 {
        let bits = mix(self.seed ^ mix(step.wrapping_mul(64).wrapping_add(channel)));
        // Two uniform numbers in (0, 1), 32 bits each.
        let uniform = |half: u64| ((half & 0xffff_ffff) as f64 + 0.5) / 4_294_967_296.0;
        libm::sqrt(-2.0 * libm::log(uniform(bits)))
            * libm::cos(core::f64::consts::TAU * uniform(bits >> 32))
    }

    /// `value` with noise of standard deviation `sigma`, rounded to a multiple of `quantum` (0: not rounded).
    pub fn reading(&self, step: u64, channel: u64, value: f64, sigma: f64, quantum: f64) -> f64 {
        let noisy = value + sigma * self.normal(step, channel);
        if quantum > 0.0 {
            libm::round(noisy / quantum) * quantum
        } else {
            noisy
        }
    }
}

/// The finalizer of Steele, Lea and Flood's splittable generator (2014).
fn mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
