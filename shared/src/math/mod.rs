//! Elementary functions that end in the same bits on every target: no platform libm, no `f32::min`, `max` or `clamp`.
//!
//! [`trig`]: sine and cosine of binary angles, arc tangent. [`limits`]: root, minimum, maximum, limiters.
//! [`cubic`]: tables of cubics in fixed point, which sines and screw share.

pub mod cubic;
pub mod limits;
pub mod trig;

pub(crate) use limits::root_of_sum;
pub use limits::{clamp, limit, max, min, sqrt, to_i16, to_i32};
pub use trig::{atan2, sin_cos, sin_cos_q30};
