//! Tests of the loops of a motor against its equations.

mod cascade;
mod current;
mod limits;
#[cfg(feature = "lockstep")]
mod model;
