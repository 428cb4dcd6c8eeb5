//! The images of the motor board: their sizes and addresses, and what they do on a model of the
//! chip that executes them.
//!
//! * `images`: sizes, sections and symbols
//! * `chip`: the model of the STM32G431
//! * `flash_memory`: its flash memory, and power cuts
//! * `pins`: the pin table of docs/hardware.md
//! * `executed`: what the images do
//! * `settings`: what the settings pages hold after resets and power cuts
//! * `defects`: images with one defect each are found

mod chip;
mod defects;
mod executed;
mod flash_memory;
mod images;
mod pins;
mod settings;
