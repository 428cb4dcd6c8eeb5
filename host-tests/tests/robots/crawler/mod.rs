//! Tests of the crawler: its model, its body controller, its plant, the controller on the plant,
//! and hazards.

mod closed_loop;
mod controller;
mod driven;
mod hazards;
mod model;
mod plant;
