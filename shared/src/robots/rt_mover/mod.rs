//! RT-Mover, the leg-wheel robot of Nakajima (Kinematics for a Rough Terrain Mobile Robot to Climb up a Step): four wheels on
//! two arms, each arm steered and rolled, under a seat that a pitch shaft keeps level.
//!
//! [`parameters`]: lengths and masses, and which of them are assumed. [`wheel`]: from shaft angles to wheels and the ground (eq. 2).
//! [`projection`]: how the robot stands on three wheels. [`lifting`]: the paper's laws of lifting, landing and swinging (eq. 3 to 12).
//! [`exact`]: what these approximate, solved. [`command`]: one entry to either. [`wheel_mode`]: all four on the ground (eq. 13).
//! [`support`]: centre of gravity and margin. [`prediction`]: a step gone through before it is taken. [`posture`]: the seat (eq. 1). All of these are
//! generic over [`crate::math::Scalar`]. [`gait`]: the step-up gait, a table of stages;
//! [`walk`]: what they do, in single precision, from shafts to shafts. [`body`]: the robot under the guard.
//!
//! Axes are the paper's: x to the right, y forward, z up, angles counter-clockwise about them. Origin is the middle of the body, between the two
//! steering shafts. A positive roll lifts the left wheel, a positive steering angle sends the left wheel back, a positive pitch lifts the front.
//! The body does not roll: posture control sees to that. Wheels are in the order front left, front right, rear left, rear right.

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
pub mod walk;
pub mod wheel;
pub mod wheel_mode;

pub use body::{RtMover, StepHeight};
pub use command::{Law, MotorCommand, Situation, Task, command};
pub use parameters::{Parameters, ParametersError};
pub use walk::Gait;
pub use wheel::{Axle, Shape, Wheel};
