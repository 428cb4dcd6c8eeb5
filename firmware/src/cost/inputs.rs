//! Inputs of the counted calls: sweeps, random numbers, and settings that the compiler cannot see
//! through.

use core::hint::black_box;
use tautrack::screw::Geometry;
use tautrack::settings::{Setting, Settings};
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

    /// Returns a random place, each coordinate at most `bound` from `place`.
    pub fn near<const N: usize>(&mut self, place: [f32; N], bound: f32) -> [f32; N] {
        place.map(|value| value + self.within(bound))
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

/// Returns the nominal settings with these changes. The compiler cannot know the values. Returns
/// `None` if a value is outside of its bounds.
pub fn settings(changes: &[(Setting, i32)]) -> Option<Settings> {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings.set(setting.description().key, *value).ok()?;
    }
    Some(black_box(settings))
}

/// Returns the geometry of the screw with these settings.
pub fn geometry(settings: &Settings) -> Option<Geometry> {
    let [l1, l2, k] = [Setting::LengthL1, Setting::LengthL2, Setting::LengthK]
        .map(|setting| settings.get(setting));
    Geometry::from_micrometres(l1, l2, k).ok()
}
