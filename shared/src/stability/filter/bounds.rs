//! The margins between which a command is scaled down, and what is kept of them.

use super::SpeedCommand;
use crate::math::clamp;
use crate::stability::support::Edge;

/// Margins between which the scale that passes grows from nothing to all, m.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// At and below this margin nothing passes.
    pub none: f32,
    /// At and above this margin, while it does not decay, all passes.
    pub all: f32,
}

impl Ramp {
    /// Distance of the two, m, above zero. Margins are tens of millimetres; the least keeps divisions
    /// away from zero.
    pub fn width(self) -> f32 {
        let width = self.all - self.none;
        if width > 1e-3 { width } else { 1e-3 }
    }

    /// The same at margins that are wider by `reserve`, m.
    #[must_use]
    pub fn moved(self, reserve: f32) -> Self {
        Self {
            none: self.none + reserve,
            all: self.all + reserve,
        }
    }

    /// Share that a margin leaves, 0 to 1; 0 for NaN.
    pub fn scale(self, margin: f32) -> f32 {
        scale((margin - self.none) / self.width())
    }
}

/// Bounds of the filter.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Of an edge that a motion leads to.
    pub towards: Ramp,
    /// Of an edge from which it leads away.
    pub away: Ramp,
    /// How far ahead decay counts, s: `1 / gamma`.
    pub horizon: f32,
    /// The same for posture motions: how far ahead the shape is that they lead to, s.
    pub foresight: f32,
    /// What driving keeps at the rear edge for the sway of a body that is lifted, m.
    pub reserve: f32,
    /// Distance of the driving sides from the middle, m, of a robot that turns by their speeds.
    pub half_width: f32,
}

/// Speed, m/s, and pitch nose up, rad, from which on the outer side of a turning robot counts as one
/// that drives forward and lifts the front.
const LIFTING_SPEED: f32 = 0.02;
const LIFTING_PITCH: f32 = 0.1;

impl Bounds {
    /// How much the outer side of a turning robot lifts the front of the robot by driving forward:
    /// from 0 to 1 at [`LIFTING_SPEED`] and [`LIFTING_PITCH`].
    pub(super) fn lifts(&self, command: SpeedCommand, pitch: f32) -> f32 {
        let outer = command.forward + self.half_width * command.yaw_rate.abs();
        scale(outer / LIFTING_SPEED) * scale(pitch / LIFTING_PITCH)
    }
}

/// Pitch from which on the whole caution band is kept for sway, rad.
const STEEP: f32 = 0.5;

/// Share of the caution band that is kept for sway toward an edge at this pitch: nose up to the back,
/// nose down to the front. NaN for NaN.
pub fn sway(edge: Edge, pitch: f32) -> f32 {
    match edge {
        Edge::Back => clamp(pitch / STEEP, 0.0, 1.0),
        Edge::Front => clamp(-pitch / STEEP, 0.0, 1.0),
        Edge::Left | Edge::Right => 0.0,
    }
}

/// Limited to 0 to 1. Zero for NaN.
pub(super) fn scale(quotient: f32) -> f32 {
    let scale = clamp(quotient, 0.0, 1.0);
    if scale >= 0.0 { scale } else { 0.0 }
}
