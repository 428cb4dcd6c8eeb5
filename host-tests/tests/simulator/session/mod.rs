//! Sessions with `cargo demo`: clients in Python that join, and runs that do not come to their end.

mod demo;
mod end;
mod python;
