//! The images of the motor board: their sizes and addresses, and what they do on a model of the
//! chip that executes them.
//!
//! * `images`: sizes, sections and symbols
//! * `pins`: the pin table of docs/hardware.md
//! * `executed`: what the images do
//! * `defects`: images with one defect each are found
//! * `processor`: interrupts within conditional blocks

mod defects;
mod executed;
mod images;
mod pins;
mod processor;

use tautrack_host_tests::simulator::chip;
