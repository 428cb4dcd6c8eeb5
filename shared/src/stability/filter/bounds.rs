//! Defines the margins between which a command is scaled down, and how the robot turns about the
//! edges.

use crate::math::clamp;
use crate::stability::allowed::Command;
use crate::stability::energy::Tipping;
use crate::stability::support::Edge;

/// Margins between which the speed scale grows from 0 to 1, m.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// At and below this margin nothing passes.
    pub none: f32,
    /// At and above this margin everything passes, while the margin does not decay.
    pub all: f32,
}

impl Ramp {
    /// Difference of the two margins, m. It is at least 1 mm, which keeps divisions away from zero;
    /// margins are tens of millimetres.
    pub fn width(self) -> f32 {
        let width = self.all - self.none;
        if width > 1e-3 { width } else { 1e-3 }
    }

    /// Scale that a margin allows, 0 to 1; 0 for NaN.
    pub fn scale(self, margin: f32) -> f32 {
        scale((margin - self.none) / self.width())
    }
}

/// Bounds of the filter.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Ramp of an edge that a motion leads to.
    pub towards: Ramp,
    /// Ramp of an edge that a motion leads away from.
    pub away: Ramp,
    /// Time ahead for which the decay of a margin counts, s: `1 / gamma`.
    pub horizon: f32,
    /// Time ahead at which the shape of a posture motion is predicted, s.
    pub foresight: f32,
    /// How the robot turns about each edge.
    pub tipping: [Tipping; 4],
    /// Distance of the driving sides from the middle, m, for a robot that turns by the difference
    /// of their speeds.
    pub half_width: f32,
}

/// Speed, m/s, and pitch nose up, rad, from which the outer side of a turning robot fully counts as
/// driving forward and lifting the front.
const LIFTING_SPEED: f32 = 0.02;
const LIFTING_PITCH: f32 = 0.1;

impl Bounds {
    /// How much the outer side of a turning robot lifts the front of the robot by driving forward:
    /// 0 to 1, which it reaches at [`LIFTING_SPEED`] and [`LIFTING_PITCH`].
    pub(super) fn lifts(&self, command: Command<()>, pitch: f32) -> f32 {
        let outer = command.forward + self.half_width * command.yaw_rate.abs();
        scale(outer / LIFTING_SPEED) * scale(pitch / LIFTING_PITCH)
    }
}

/// Pitch from which the caution band is moved up by its whole width, rad.
const STEEP: f32 = 0.5;

/// Distance by which the caution band moves up to allow for sway, as a fraction of its width. At
/// the rear edge it grows with pitch up, at the front edge with pitch down. NaN for NaN.
pub fn sway(edge: Edge, pitch: f32) -> f32 {
    match edge {
        Edge::Back => clamp(pitch / STEEP, 0.0, 1.0),
        Edge::Front => clamp(-pitch / STEEP, 0.0, 1.0),
        Edge::Left | Edge::Right => 0.0,
    }
}

/// Limits a quotient to 0 to 1. Zero for NaN.
pub(super) fn scale(quotient: f32) -> f32 {
    let scale = clamp(quotient, 0.0, 1.0);
    if scale >= 0.0 { scale } else { 0.0 }
}
