//! The crawler: model and controller of the two-track inspection robot of Kurc and Szybicki
//! (Kinematics of a Robot with Crawler Drive), whose tracks slip.
//!
//! * [`parameters`]: the paper's numbers, and what had to be assumed.
//! * [`kinematics`]: from sprockets to motion and back, with slip.
//! * [`soil`]: the force that the ground carries, and the slip that a force needs. This and the
//!   kinematics are generic over [`crate::math::Scalar`].
//! * [`controller`]: the body controller, made of [`slip`] (estimates the slip of the tracks) and
//!   [`path`] (follows the commanded path by odometry).
//! * [`shape`]: centre of gravity and edges, for the guard.
//! * [`body`]: the interface to the guard.
//!
//! Track 1 is the left one. The heading `beta` turns counter-clockwise seen from above. Forward
//! speeds, sprocket rates and forces are positive forward.

pub mod body;
pub mod controller;
pub mod kinematics;
pub mod parameters;
pub mod path;
pub mod shape;
pub mod slip;
pub mod soil;

pub use body::Crawler;
pub use controller::{Configuration, Controller, Observation, SprocketCommand};
pub use kinematics::{BodyVelocity, Drive, Kinematics};
pub use parameters::ParametersError;
pub use shape::Shape;
pub use soil::{Footprint, Soil};
