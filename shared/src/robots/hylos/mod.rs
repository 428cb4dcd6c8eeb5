//! Hylos: model and controller of the wheel-legged robot of Besseron, Grand, Ben Amar and Bidaud
//! (Decoupled control of the high mobility robot Hylos based on a dynamic stability margin). It has
//! four legs of two joints, each with a steered and driven wheel.
//!
//! These modules are generic over [`crate::math::Scalar`]:
//!
//! * [`parameters`]: dimensions, masses and ranges, with all assumptions.
//! * [`attitude`]: attitude of the platform.
//! * [`posture`]: wheels and contacts, and the velocity model (eq. 6 to 12).
//! * [`potential`]: stability potential of the tip-over angles. [`stability`]: its gradient.
//! * [`velocity`]: the decoupled control (eq. 13 to 22).
//! * [`controller`]: from the operator's command to sixteen set-points.
//!
//! [`body`] is the interface to the guard. Legs count front left, front right, rear left, rear
//! right. Axes are x forward, y left, z up.

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
