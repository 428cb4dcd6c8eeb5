//! Scales a command down, between the operator's value and zero, so that the energy that is left
//! before the robot tips over an edge stays positive by a margin. It never adds motion of its own.
//!
//! With the scale `s` of the commanded speed `u`, the margin `m` of an edge decays with
//! `dm/dt = r_0 + k s u`: `k u` is the part of the measured rate that the command causes, `r_0` the
//! rest. After the horizon `T` (the time until the guard's stop begins, and the time that it takes)
//! the robot has the margin `m + T dm/dt`, turns about the edge as it does now, and is stopped at
//! once. The largest `s` passes with which
//!
//! `M(m + (r_0 + k s u) T, s u) >= m_stop + s w`,
//!
//! where `M` is the margin in terms of energy ([`super::energy::Tipping::margin`]) and `w` the
//! caution band `m_caution - m_stop`: the more of a command passes, the earlier a margin counts as
//! used up. This is a control barrier with the guard's stop as its backup.
//!
//! All four edges are watched in every motion. A motion that leads away from an edge has no caution
//! band there. Example: a robot that is pitched up at the nose of a step backs down. Its front
//! sinks, so the motion leads away from the rear edge of the support. The motion slows down from
//! the stop margin to the trip margin, and it stops if the margin would decay to the trip margin
//! within the horizon. So the robot has little momentum if a track slips or the ground ends.
//!
//! A robot that is pitched up may rest on the nose of a step. The margin that a push of its rear
//! towards this nose would leave must not be below `m_stop` ([`Bounds::noses`]). For a steep robot
//! it must not be below the middle of the caution band.
//!
//! [`speed_scale`] computes the scale of a speed, [`posture`] that of a change of shape, within
//! [`Bounds`]. [`Recovery`] limits how fast a speed grows after a restriction.
//! [`super::allowed::Allowed::ramp`] applies it to the operator's speed.

mod bounds;
#[cfg(test)]
mod examples;
mod posture;
mod recovery;
mod speed;

pub use super::tracker::{Margins, Tracker};
pub use super::verdict::Verdict;
pub use bounds::{Bounds, Ramp};
pub(super) use posture::SMALLEST_SHARE;
pub use posture::posture;
pub use recovery::Recovery;
pub use speed::{speed_scale, within_limit};
