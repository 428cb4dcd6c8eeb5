//! Margins and filter against falls that are integrated, and against any input.

mod supervision;
mod tipover;
