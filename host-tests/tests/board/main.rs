//! The images of the boards: their sizes and addresses, and what they do on a model of the
//! chip that executes them.
//!
//! * `images`: sizes, sections and symbols
//! * `chips`: the manufacturer's data about the chips
//! * `index`: a three-phase motor whose encoder has an index
//! * `pins`: the pin tables of docs/hardware.md and docs/guard-board.md
//! * `executed`: what the images do
//! * `guard`: what the images of the guards do; `guard_images` has their sizes and addresses,
//!   and `guard_panics` what they log when they panic
//! * `sensors`: how the guard reads its sensor chips, and what it does when they fail
//! * `checks`: what the images of all boards do
//! * `settings`: what the settings pages hold after resets and power cuts
//! * `shaft_sensor`: how an axle reads the sensor at its shaft, and what it does when this fails
//! * `analogue`: zero, scale and thresholds of the current measurement
//! * `breaks`: what opens the bridge without software
//! * `bus_errors`: what they do when the bus fails
//! * `gates`: the gates are off after every failure
//! * `masked`: how long interrupts are masked
//! * `reserved`: which reserved bits are written
//! * `connected`: a connected board, if there is one, against the model
//! * `footprint`: the figures of `cargo footprint`
//! * `defects`: images with one defect each are found
//! * `flash_node`: what `cargo flash-node` prints and refuses
//! * `processor`: interrupts within conditional blocks

mod analogue;
mod breaks;
mod bus_errors;
mod checks;
mod chips;
mod connected;
mod defects;
mod executed;
mod flash_node;
mod footprint;
mod gates;
mod guard;
mod guard_images;
mod guard_panics;
mod halls;
mod images;
mod index;
mod masked;
mod pins;
mod processor;
mod reserved;
mod sensors;
mod settings;
mod shaft_sensor;
#[path = "../support/unchanged.rs"]
mod unchanged;

use tautrack_host_tests::programs::MotorBoard;
use tautrack_host_tests::simulator::chip;

/// Stamp of a test of the images, see [`unchanged::stamp_of_programs`]. A test that must find a
/// defect runs each time.
fn stamp(test: &str) -> Option<unchanged::Stamp> {
    if executed::DEFECT.get().is_some() {
        return Some(unchanged::Stamp::default());
    }
    let MotorBoard {
        loader,
        axle,
        screw,
    } = images::programs();
    let all = [loader, axle, screw]
        .into_iter()
        .chain(guard_images::guards());
    let digests = all.map(|program| program.sha256.clone());
    unchanged::stamp_of_programs(&format!("board-{test}"), digests)
}
