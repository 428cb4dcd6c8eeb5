//! Computes tip-over margins and limits commands accordingly.
//!
//! [`balance`] joins the parts for one robot. [`support`]: distances of the centre of gravity to
//! the edges of the support. `edge_margin`: the margins of one edge. [`criterion`]: which of them
//! counts, in an [`evaluation`]. [`bands`]: the band of the narrowest margin. [`tracker`]: margins
//! with their rates. [`allowed`]: what is commanded and allowed. [`filter`]: the scale of a
//! command, with its [`verdict`]. [`energy`]: margins that contain momentum. [`step_behind`] and
//! [`diagonal`]: falls that no margin shows. [`limits`]: limits of accelerations and yaw.
//! [`trip`]: the latch. [`parameters`]: the numbers of all these.
//! For any scalar: [`zmp`], where the reaction of the ground acts, and [`tipover`], the angle
//! between the forces and each edge.

pub mod allowed;
pub mod balance;
pub mod bands;
pub mod criterion;
pub mod diagonal;
mod edge_margin;
pub mod energy;
pub mod evaluation;
pub mod filter;
pub mod limits;
pub mod parameters;
pub mod step_behind;
pub mod support;
pub mod tipover;
pub mod tracker;
pub mod trip;
pub mod verdict;
pub mod zmp;
