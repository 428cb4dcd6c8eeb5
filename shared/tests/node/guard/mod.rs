//! Tests of the guard's tick with drives that follow every controlword at once.

mod arming;
pub mod bench;
mod commissioned;
mod commissioning;
mod drives;
mod driving;
mod holding;
mod identifiers;
mod operators;
mod postures;
mod published;
mod releasing;
mod sensing;
mod sequences;
mod trips;
