//! The images of the motor board: their sizes and addresses, and what they do on a model of the
//! chip that executes them.
//!
//! * `images`: sizes, sections and symbols
//! * `pins`: the pin table of docs/hardware.md
//! * `executed`: what the images do
//! * `settings`: what the settings pages hold after resets and power cuts
//! * `bus_errors`: what they do when the bus fails
//! * `gates`: the gates are off after every failure
//! * `masked`: how long interrupts are masked
//! * `reserved`: which reserved bits are written
//! * `connected`: a connected board, if there is one, against the model
//! * `footprint`: the figures of `cargo footprint`
//! * `defects`: images that write other values to one register are found
//! * `defective`: images with one defect each in their program are found
//! * `flash_node`: what `cargo flash-node` prints and refuses
//! * `processor`: interrupts within conditional blocks

mod bus_errors;
mod connected;
mod defective;
mod defects;
mod executed;
mod flash_node;
mod footprint;
mod gates;
mod images;
mod masked;
mod pins;
mod processor;
mod reserved;
mod settings;

use tautrack_host_tests::simulator::chip;
