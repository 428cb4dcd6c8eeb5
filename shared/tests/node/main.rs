//! What a node does in its ticks.

mod any_input;
mod drive_faults;
mod guard;
