//! Tests of sessions with `cargo demo`: Python clients that join, settings that clients save, and
//! runs that end early.

mod demo;
mod end;
mod python;
mod settings;
