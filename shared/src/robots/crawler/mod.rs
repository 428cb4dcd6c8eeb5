//! The crawler, the two-track inspection robot of Kurc and Szybicki (Kinematics of a Robot with Crawler Drive): tracks that slip.
//!
//! [`parameters`]: the paper's numbers and what had to be assumed. [`kinematics`]: from sprockets to motion and back, with slip.
//! [`soil`]: how much the ground bears, and the slip it takes. These are generic over [`crate::math::Scalar`].
//! [`controller`]: the body controller, made of [`slip`] (how much the tracks slip now) and [`path`] (where the robot is and shall be).
//! [`shape`]: centre of gravity and edges, for the guard. [`body`]: what the guard drives.
//!
//! Track 1 is the left one. The heading `beta` turns counter-clockwise from above; forward speeds, sprocket rates and forces are
//! positive forward.

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
