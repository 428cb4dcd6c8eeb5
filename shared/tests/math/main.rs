//! Tests of the mathematics against double precision and brute force.

mod functions;
mod scalar;
#[path = "../support/mod.rs"]
mod support;
