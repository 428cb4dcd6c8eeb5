//! Tests of the loops of a motor against its equations.

#[cfg(feature = "lockstep")]
mod calibration;
mod cascade;
mod current;
mod limits;
#[cfg(feature = "lockstep")]
mod model;
#[cfg(feature = "lockstep")]
#[path = "../support/parallel.rs"]
mod parallel;
#[allow(dead_code)] // the models need the joints
#[cfg(feature = "lockstep")]
#[path = "../support/random.rs"]
mod random;
#[cfg(feature = "lockstep")]
#[path = "../support/sweep.rs"]
mod sweep;
