//! Tests the robots' models and controllers against independent computations.

mod b2p2_clearance;
mod b2p2_feed_forward;
mod b2p2_model;
mod b2p2_zmp;
mod bodies;
#[path = "../support/counted.rs"]
mod counted;
mod crawler_controller;
mod crawler_model;
mod hylos_controller;
mod hylos_model;
mod hylos_potential;
#[path = "../support/random.rs"]
mod random;
mod rt_mover;
mod turning;
