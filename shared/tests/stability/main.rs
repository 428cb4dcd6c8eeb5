//! Tests margins and filter against integrated falls and against any input.

mod supervision;
mod tipover;
