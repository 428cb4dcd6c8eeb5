//! Tests margins and filter against integrated falls and against any input.

mod bands;
mod limits;
mod margins;
#[path = "../support/random.rs"]
#[allow(dead_code)] // the models need the joints
mod random;
mod supervision;
mod support;
mod tipover;
mod trip;
