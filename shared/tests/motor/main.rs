//! Tests of the loops of a motor against its equations.

mod cascade;
mod current;
#[cfg(feature = "lockstep")]
mod model;
