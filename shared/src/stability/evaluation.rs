//! The margins at one evaluation.

/// Margins at one evaluation, and which of them count.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Evaluation {
    /// Margins that count, m, indexed by [`super::support::Edge`], the uncertainty subtracted. NaN
    /// if an input is not finite, and if the robot is fast and the ground would have to pull.
    pub margins: [f32; 4],
    /// Margins of the centre of gravity projected straight down, m, the uncertainty subtracted.
    pub gravity: [f32; 4],
    /// Change of each margin per `g` of acceleration forward and to the left, m.
    pub levers: [[f32; 2]; 4],
    /// Whether the robot is fast, so that the measured force counts.
    pub force_counts: bool,
    /// Whether the robot is fast because of its speed: an instant stop could tip it.
    pub stop_would_tip: bool,
}
