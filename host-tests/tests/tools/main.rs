//! Tests of the commands, their input and their results.

mod cart;
mod checkout;
mod cost;
mod demo;
mod dictionary;
mod docs;
mod eds;
mod evaluate;
mod layers;
#[path = "../support/python.rs"]
mod python;
mod reference;
mod report;
mod results;
mod scenario;
mod scenario_page;
mod shared_build;
mod suite;
#[path = "../support/unchanged.rs"]
mod unchanged;
mod urdf;
mod weigh;
mod words;
