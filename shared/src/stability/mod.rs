//! Computes tip-over margins and limits commands accordingly.
//!
//! [`attitude`]: pitch, roll and heading. [`watch`]: whether the sensors are believed, with
//! [`sensor_watch`] (age and rate of one sensor), `noise_watch` (its noise), `stuck` and
//! `field_watch` (repeated readings) and [`trust`] (the result). [`support`]: distances of the
//! centre of gravity to the edges of the support. [`specific_force`]: the measured force.
//! `edge_margin`: the margins of one edge. [`criterion`]: which of them counts. [`bands`]: the band
//! of the narrowest margin. [`tracker`]: margins with their rates. [`filter`]: the scale of a
//! command, with its [`verdict`]. [`stopping`]: the speed limit of a posture. [`step_behind`] and
//! [`diagonal`]: falls that no margin shows. [`limits`]: limits of accelerations and yaw.
//! [`trip`]: the latch. [`parameters`]: the numbers of all these.
//! For any scalar: [`zmp`], where the reaction of the ground acts, and [`tipover`], the angle
//! between the forces and each edge.

pub mod attitude;
pub mod bands;
pub mod criterion;
pub mod diagonal;
mod edge_margin;
mod field_watch;
pub mod filter;
pub mod limits;
mod noise_watch;
pub mod parameters;
pub mod sensor_watch;
pub mod specific_force;
pub mod step_behind;
pub mod stopping;
mod stuck;
pub mod support;
pub mod tipover;
pub mod tracker;
pub mod trip;
pub mod trust;
pub mod verdict;
pub mod watch;
pub mod zmp;
