//! Defines the margins between which a command is scaled down, and how the robot turns about the
//! edges.

use crate::math::{clamp, min, root_of_sum, sin_cos};
use crate::stability::allowed::Command;
use crate::stability::energy::Tipping;
use crate::stability::support::Edge;
use crate::units::Angle;

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
    /// Largest speed of a side, m/s.
    pub fastest: f32,
    /// Deceleration of the guard's stop, m/s^2.
    pub braking: f32,
    /// Whether the bottom of the robot can rest on the nose of a step.
    pub noses: bool,
}

/// Speed, m/s, and pitch nose up, rad, from which the outer side of a turning robot fully counts as
/// driving forward and lifting the front.
const LIFTING_SPEED: f32 = 0.02;
const LIFTING_PITCH: f32 = 0.1;

impl Bounds {
    /// How much the outer side of a turning robot lifts the front of the robot by driving forward:
    /// 0 to 1, which it reaches at [`LIFTING_SPEED`] and [`LIFTING_PITCH`].
    pub(super) fn lifts(&self, command: Command<()>, pitch: f32) -> f32 {
        scale(self.outer(command) / LIFTING_SPEED) * scale(pitch / LIFTING_PITCH)
    }

    /// Returns the nose on which the bottom of a robot at this `pitch` may rest while `command`
    /// pushes its rear; `None` if there is none, or if nothing pushes.
    pub(super) fn nose(&self, command: Command<()>, pitch: f32) -> Option<Nose> {
        let (sine, cosine, fading) = if pitch.is_finite() {
            let (sine, cosine) = sin_cos(Angle::from_radians(pitch));
            (sine, cosine, scale(pitch / LIFTING_PITCH))
        } else {
            (f32::NAN, f32::NAN, 1.0)
        };
        let speed = min(self.outer(command), self.fastest) * fading;
        // Both comparisons are false for NaN.
        if !self.noses || speed <= 0.0 || pitch <= 0.0 {
            return None;
        }
        Some(Nose {
            sine,
            cosine,
            speed,
            steep: scale(pitch / STEEP - 1.0),
            latency: self.foresight,
            braking: self.braking,
        })
    }

    /// Speed of the side that drives forward faster, m/s.
    fn outer(&self, command: Command<()>) -> f32 {
        command.forward + self.half_width * command.yaw_rate.abs()
    }
}

/// Nose of a step below the centre of gravity of a robot that is pitched up. The tracks push the
/// rear under the robot.
///
/// The nose is not behind the centre of gravity, or the robot would tip forward. It is `margin` in
/// front of the rear edge, and `margin tan(pitch)` above it, and stays there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nose {
    sine: f32,
    cosine: f32,
    /// Speed at which the whole command pushes the rear, m/s.
    speed: f32,
    /// 0 up to the pitch [`STEEP`], 1 from twice this pitch.
    steep: f32,
    /// Time until the guard's stop begins, s.
    latency: f32,
    braking: f32,
}

impl Nose {
    /// Margin of the rear edge after the robot has stopped from `scale` times the command, m.
    /// `margin` and `height` (m) are those before. NaN for NaN.
    pub fn left(&self, margin: f32, height: f32, scale: f32) -> f32 {
        let speed = scale * self.speed;
        self.reared(
            margin,
            height,
            speed * (self.latency + 0.5 * speed / self.braking),
        )
    }

    /// Margin that must be left on the nose, m. A steep robot keeps half of the caution band: if
    /// its rear loses the ground, it swings about the nose, and lands with momentum.
    pub fn least(&self, ramp: Ramp) -> f32 {
        ramp.none + 0.5 * self.steep * ramp.width()
    }

    /// Margin of the rear edge after the rear was pushed by `way`, m. The robot turns by the angle
    /// whose sine is `way sin(pitch)` over the distance from the rear to the nose. If the way is
    /// the whole margin, it stands upright.
    fn reared(&self, margin: f32, height: f32, way: f32) -> f32 {
        // The comparison is false for NaN.
        if margin <= 0.0 {
            return margin;
        }
        let way = if way > margin { margin } else { way };
        // All lengths times the cosine, which may be zero.
        let [ahead, up] = [(margin - way) * self.cosine, margin * self.sine];
        let over = 1.0 / root_of_sum(ahead * ahead + up * up + SMALLEST);
        let across = way * self.sine * self.cosine;
        let along = ahead * self.cosine + up * self.sine;
        (margin * along - height * across) * over
    }
}

/// Keeps a division away from zero, m^2.
const SMALLEST: f32 = 1e-12;

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
