//! The crawler: its model, its body controller, its plant, the two together, and what turns it over.

mod closed_loop;
mod controller;
mod driven;
mod hazards;
mod model;
mod plant;
