//! Tests which readings of the sensors on the body are believed, and in which axes they are.

mod mounting;
#[path = "../support/random.rs"]
#[allow(dead_code)] // the models need the joints
mod random;
mod rest;
mod watch;
