//! RT-Mover: model and controller of the leg-wheel robot of Nakajima (Kinematics for a Rough
//! Terrain Mobile Robot to Climb up a Step). It has four wheels on two arms. Each arm is steered
//! and rolled, and a pitch shaft keeps the seat above them level.
//!
//! These modules are generic over [`crate::math::Scalar`]:
//!
//! * [`parameters`]: lengths and masses, and which of them are assumed.
//! * [`wheel`]: from shaft angles to wheels and the ground (eq. 2).
//! * [`projection`]: how the robot stands on three wheels.
//! * [`task`]: what a lifted wheel has to do.
//! * [`lifting`]: the paper's laws of lifting, landing and swinging (eq. 3 to 12).
//! * [`exact`]: the motion that these laws approximate.
//! * [`command`]: one entry point to all these laws.
//! * [`wheel_mode`]: motion with all four wheels on the ground (eq. 13).
//! * [`support`]: centre of gravity and margin.
//! * [`prediction`]: predicts a step and its margins.
//! * [`posture`]: keeps the seat level (eq. 1).
//!
//! These compute in single precision: [`gait`], the step-up gait as a table of stages; [`walk`],
//! which carries the stages out, from shaft angles to shaft rates; and [`body`], the interface to
//! the guard.
//!
//! Axes are the paper's: x to the right, y forward, z up, angles counter-clockwise about them. The
//! origin is the middle of the body, between the two steering shafts. A positive roll lifts the
//! left wheel, a positive steering angle moves the left wheel back, a positive pitch lifts the
//! front. The body does not roll, because posture control prevents it. Wheels are in the order
//! front left, front right, rear left, rear right.

pub mod body;
pub mod command;
pub mod exact;
pub mod gait;
pub mod lifting;
pub mod parameters;
pub mod posture;
pub mod prediction;
pub mod projection;
pub mod support;
pub mod task;
pub mod walk;
pub mod wheel;
pub mod wheel_mode;

pub use body::{RtMover, StepHeight};
pub use command::{Law, command};
pub use parameters::{Parameters, ParametersError};
pub use task::{MotorCommand, Situation, Task};
pub use walk::Gait;
pub use wheel::{Axle, Shape, Wheel};
