//! Elementary functions that end in the same bits on every target: no platform libm, no `f32::min`, `max` or `clamp`.
//!
//! [`trig`]: sine and cosine of binary angles, arc tangent. [`limits`]: root, minimum, maximum, limiters.
//! [`cubic`]: tables of cubics in fixed point, which sines and screw share. [`scalar`]: `f32` or `f64`, for models that are
//! written once for both; [`vector`]: places, directions and symmetric matrices in them; [`exponential`]: decays.

pub mod cubic;
pub mod exponential;
pub mod limits;
mod radians;
pub mod scalar;
pub mod trig;
pub mod vector;

pub(crate) use limits::root_of_sum;
pub use limits::{Bound, clamp, limit, max, min, saturate, sqrt, to_i16, to_i32};
pub use scalar::Scalar;
pub use trig::{atan2, sin_cos, sin_cos_q30};
