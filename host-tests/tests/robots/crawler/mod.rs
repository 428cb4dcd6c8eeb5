//! Tests of the crawler: its plant, the controller on the plant, and hazards. Its model and its
//! body controller are tested in `shared/tests/robots`.

mod closed_loop;
mod driven;
mod hazards;
mod plant;
