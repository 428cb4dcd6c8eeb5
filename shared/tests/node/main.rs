//! Tests of the ticks of the nodes.

#[cfg(feature = "lockstep")]
mod alignment;
mod any_input;
mod can_node;
#[cfg(feature = "lockstep")]
mod cogging;
#[allow(dead_code)] // for a node as a value, every time is exact
#[path = "../support/conformance/mod.rs"]
mod conformance;
#[cfg(feature = "lockstep")]
mod current_zero;
#[cfg(feature = "lockstep")]
mod drive_bench;
#[cfg(feature = "lockstep")]
mod drive_brake;
mod drive_faults;
#[cfg(feature = "lockstep")]
mod drive_options;
#[cfg(feature = "lockstep")]
mod drive_stops;
#[cfg(feature = "lockstep")]
mod fault_times;
mod foreign;
mod guard;
#[cfg(feature = "lockstep")]
mod halls;
#[cfg(feature = "lockstep")]
mod homing;
#[cfg(feature = "lockstep")]
mod index;
#[cfg(feature = "lockstep")]
mod limit_switches;
mod live_settings;
#[cfg(feature = "lockstep")]
mod motor_faults;
#[allow(dead_code)] // the models need the joints
#[cfg(feature = "lockstep")]
#[path = "../support/random.rs"]
mod random;
mod releasing;
mod sequences;
#[cfg(feature = "lockstep")]
mod shaft_sensor;
#[path = "../support/sweep.rs"]
mod sweep;
mod wire;
