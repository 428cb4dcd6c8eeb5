//! Tests of sessions with `cargo demo`: Python clients that join, settings that clients save, the
//! commissioning of a guard, and runs that end early.

mod commissioning;
mod conformance;
mod demo;
mod end;
mod python;
mod settings;
