//! Hylos, the wheel-legged robot of Besseron, Grand, Ben Amar and Bidaud (Decoupled control of the high mobility robot Hylos based
//! on a dynamic stability margin): four legs of two joints, each with a steered and driven wheel.
//!
//! [`parameters`]: measures, all of the assumptions. [`attitude`]: how the platform lies.
//! [`posture`]: wheels and contacts, the velocity model (eq. 6 to 12). [`potential`] of the tip-over
//! angles, and [`stability`]: its gradient. [`velocity`]: the decoupled control (eq. 13 to 22).
//! [`controller`]: from the operator's command to sixteen set-points. All of these are generic over
//! [`crate::math::Scalar`]. [`body`]: what the guard drives.
//!
//! Legs count front left, front right, rear left, rear right. Axes are x forward, y left, z up.

pub mod attitude;
pub mod body;
pub mod controller;
mod least_squares;
pub mod parameters;
pub mod posture;
pub mod potential;
pub mod stability;
pub mod velocity;

pub use attitude::Attitude;
pub use body::{Clearance, Hylos};
pub use controller::{Assessment, Controller, Desired, Sensed, SetPoints};
pub use parameters::{Measures, Parameters, ParametersError};
pub use posture::{Posture, Wheel};
pub use potential::{Potential, PotentialError};
pub use stability::{Gradient, Pull};
pub use velocity::{Form, MotorGoals, Trajectory};

/// Number of legs.
pub const LEGS: usize = 4;
/// Hip and knee of each leg.
pub type Legs<S> = [[S; 2]; LEGS];
