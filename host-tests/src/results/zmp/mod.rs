//! Computes centre of gravity and zero moment point along the robot's heading from the simulator's
//! ground truth, as in Fig. 8 of Paillat, Lucidarme and Hardouin (Variable Geometry Tracked
//! Unmanned Grounded Vehicle).
//!
//! The robot computes them at one sample ([`OwnBalance`]), from the joints q of the ground truth.
//! q' and q'' are central differences of the samples before and after it, so an acceleration is a
//! mean over 20 ms.
//!
//! The paper computes accelerations from encoders and does not say how it filters them. It also
//! does not say to which length its percentage refers. Here it is the whole length of the
//! straight robot.
//!
//! `moment` is one sample, `smoothing` smooths the difference, `figures` computes mean and
//! peak, `balance` follows a run sample by sample.

mod balance;
mod figures;
mod moment;
mod smoothing;

pub use balance::{Area, Balance, BalanceOfRun};
pub use figures::{Figures, MeanAndPeak};
pub use moment::Moment;
pub use smoothing::SMOOTHING_S;

use crate::world::truth::Truth;

/// Mean difference that the paper reports for its climb, %.
pub const PAPER_PERCENT: f64 = 0.21;

/// A robot's own computation of centre of gravity and zero moment point.
pub struct OwnBalance {
    /// Computes a sample from its time, s, and the ground truth before, at and after it; `None` if
    /// the robot has no valid model.
    pub moment: Box<MomentOf>,
    /// Length of the straight robot, m.
    pub length_m: f64,
}

/// Function of [`OwnBalance::moment`].
pub type MomentOf = dyn Fn(f64, [&Truth; 3]) -> Option<Moment> + Send;
