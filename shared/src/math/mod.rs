//! Elementary functions that are bit-identical on every target. They use no platform libm and no
//! `f32::min`, `max` or `clamp`.
//!
//! * [`trig`]: sine and cosine of binary angles, arc tangent
//! * [`float`]: square root, minimum, maximum, limiters
//! * [`cubic`]: tables of cubics in fixed point, for the sines and the screw
//! * [`scalar`]: `f32` or `f64`, for models that have one source for both
//! * [`vector`]: points, directions, frames and symmetric matrices of scalars
//! * [`Turns`]: positions of shafts
//! * [`exponential`]: decaying exponentials
//! * [`Crc32`]: checksum of images and settings

mod crc;
pub mod cubic;
pub mod exponential;
pub mod float;
mod radians;
pub mod scalar;
pub mod trig;
mod turns;
pub mod vector;

pub use crc::Crc32;
pub(crate) use float::root_of_sum;
pub use float::{Bound, clamp, limit, max, min, saturate, sqrt, to_i16, to_i32};
pub use scalar::Scalar;
pub use trig::{atan2, sin_cos, sin_cos_q30};
pub use turns::Turns;
