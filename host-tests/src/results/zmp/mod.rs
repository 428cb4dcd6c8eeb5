//! Computes centre of gravity and zero moment point along the robot's heading from the simulator's
//! ground truth, as in Fig. 8 of Paillat, Lucidarme and Hardouin (Variable Geometry Tracked
//! Unmanned Grounded Vehicle).
//!
//! The model is the one of the nodes, in double precision: [`Posture`], its Newton-Euler pass and
//! [`zero_moment_point`]. The ground truth has the joints q of each sample. q' and q'' are central
//! differences of the samples before and after it, so an acceleration is a mean over 20 ms.
//!
//! The paper computes accelerations from encoders and does not say how it filters them. It also
//! does not say to which length its percentage refers. Here it is the [whole length](length) of the
//! straight robot.
//!
//! `moment` computes one sample, `smoothing` smooths the difference, `figures` computes mean and
//! peak, `balance` follows a run sample by sample.

mod balance;
mod figures;
mod moment;
mod smoothing;

pub use balance::{Area, Balance, BalanceOfRun};
pub use figures::{Figures, MeanAndPeak};
pub use moment::Moment;
pub use smoothing::SMOOTHING_S;

use crate::robots::b2p2::plant::B2p2Parameters;

/// Mean difference that the paper reports for its climb, %.
pub const PAPER_PERCENT: f64 = 0.21;

/// Length of the straight robot, pulleys included, m.
pub fn length(parameters: &B2p2Parameters) -> f64 {
    parameters.l1 + parameters.taut_length(0.0) + 2.0 * parameters.pulley_radius
}
