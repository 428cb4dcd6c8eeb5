//! Inputs of the counted calls: sweeps, random numbers, and settings that the compiler cannot see
//! through.

use core::hint::black_box;
use tautrack::settings::Settings;
use tautrack::units::Angle;

/// Marsaglia's 32-bit xorshift generator, which gives the same numbers in every run.
pub struct Random(u32);

impl Random {
    /// Creates the generator at the start of its sequence.
    pub fn new() -> Self {
        Self(0x2545_f491)
    }

    /// Returns the next 32 random bits.
    pub fn bits(&mut self) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as i32
    }

    /// Returns a random number from -`bound` to `bound`.
    pub fn within(&mut self, bound: f32) -> f32 {
        self.bits() as f32 * (bound / 2_147_483_648.0)
    }
}

/// Returns the angle for call number `call`. The sweep starts with the four quarter turns and then
/// covers the full circle in steps of the golden section.
pub fn angle(call: u32) -> Angle {
    Angle::from_bits(match call {
        0..4 => (call << 30) as i32,
        _ => call.wrapping_mul(0x9e37_79b9) as i32,
    })
}

/// Returns a floating-point number of any magnitude and sign; the first calls return special
/// values.
pub fn number(call: u32, random: &mut Random) -> f32 {
    match call {
        0 => 0.0,
        1 => -0.0,
        2 => f32::INFINITY,
        3 => f32::NAN,
        4 => f32::MAX,
        _ => random.within(1.0) * f32::from_bits(0x3000_0000 + ((call & 0x1f) << 23)),
    }
}

/// Returns the nominal settings, with values that the compiler cannot know.
pub fn settings() -> Settings {
    black_box(Settings::default())
}
