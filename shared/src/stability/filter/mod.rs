//! Scales a command down, between the operator's value and zero, so that the decay of every margin
//! stays within bounds (a control-barrier filter). It never adds motion of its own.
//!
//! The barrier is `m - m_stop` for the margin `m` of each edge. With the scale `s` of the commanded
//! speed `u`, the margin decays with `dm/dt = r_0 + k s u`: `k u` is the part of the measured rate
//! that the command causes, `r_0` the rest. Within the stopping horizon `T` (the time until a stop
//! begins, and the time that it takes) this must hold:
//!
//! `dm/dt >= -gamma (m - m_stop - s w)`, `gamma = 1/T`,
//!
//! where `w` is the caution band `m_caution - m_stop`: the more of a command passes, the earlier a
//! margin counts as used up. Hence `s = (m - m_stop + r_0 T) / (w + |k u| T)`, limited to 0 to 1.
//!
//! All four edges are watched in every motion. A motion that leads away from an edge has no caution
//! band there. Example: a robot that is pitched up at the nose of a step backs down. Its front
//! sinks, so the motion leads away from the rear edge of the support. The motion slows down from
//! the stop margin to the trip margin, and it stops if the margin would decay to the trip margin
//! within the horizon. So the robot has little momentum if a track slips or the ground ends.
//!
//! [`speed_scale`] computes the scale of a speed, [`posture`] that of a change of shape, within
//! [`Bounds`]. [`super::allowed::Allowed::ramp`] applies it to the operator's speed.

mod bounds;
#[cfg(test)]
mod examples;
mod posture;
mod speed;

pub use super::tracker::{Margins, Tracker};
pub use super::verdict::Verdict;
pub use bounds::{Bounds, Ramp, sway};
pub(super) use posture::SMALLEST_SHARE;
pub use posture::posture;
pub use speed::{speed_scale, within_limit};
