//! Tests of sessions with `cargo demo`: Python clients that join, and runs that end early.

mod demo;
mod end;
mod python;
