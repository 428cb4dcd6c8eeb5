//! B2P2: model and controller of the tracked robot of Paillat, Lucidarme and Hardouin (Variable
//! Geometry Tracked Unmanned Grounded Vehicle; its appendix has the Denavit-Hartenberg table and
//! the constants).
//!
//! * [`parameters`]: masses and lengths of the paper. [`masses`]: those of the settings.
//! * [`model`]: the paper's equations, generic over [`crate::math::Scalar`]. [`model::posture`]:
//!   the chain of eight joints. [`model::jacobian`] and [`model::dynamics`]: Jacobians, inertia and
//!   Coriolis matrix, gravity. [`model::newton_euler`]: joint torques and ground reaction by the
//!   fast path. [`model::actuation`]: from motor torques to generalized forces. [`model::belt`]:
//!   the motion of joint 8 that taut tracks require.
//! * [`shape`]: the few positions that the guard needs at every tick, from binary angles.
//! * [`feed_forward`]: the load of the front part on its two drives.
//! * [`clearance`]: clears stairs, curbs and ramps by itself.
//! * [`body`]: the interface to the guard.
//!
//! The joints `q`, m and rad: 1 forward (y0), 2 to the right (x0), 3 up (z0), 4 yaw, 5 roll, 6
//! pitch (nose up), 7 the chassis joint (front up), 8 the screw. At `q = 0` the robot stands at the
//! origin of R0 and heads along y0. Arrays count from 0: `q[0]` is `q1`.

pub mod body;
pub mod clearance;
pub mod feed_forward;
pub mod masses;
pub mod model;
pub mod parameters;
pub mod shape;

pub use body::{B2p2, Front};
pub use feed_forward::FrontPart;
pub use masses::Masses;
pub use model::posture::Posture;
pub use parameters::{Parameters, ParametersError, Tabulated};
pub use shape::{Model, Shape};

/// Number of joints.
pub const JOINTS: usize = 8;
/// One value for each joint.
pub type Joints<S> = [S; JOINTS];
/// One value for each pair of joints, row by row.
pub type JointMatrix<S> = [[S; JOINTS]; JOINTS];
