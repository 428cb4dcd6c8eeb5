//! Parts of the boards with a chip of ST's family STM32G4.
//!
//! * `clock`: 170 MHz from the crystal
//! * `can`: FDCAN and the frame queues
//! * `i2c`: bus of the sensor chips
//! * `storage`: the settings pages
//! * `reset`: watchdog, cause of the last reset, panic and `HardFault`
//! * `stack_guard`: a stack that overflows is a fault
//! * `led`: what the LED shows
//! * `critical_section`, `square_root`: functions of libraries, smaller than theirs
//! * `copy`: a function of the library, faster than its own
//!
//! The selected board has more functions for them: `make_safe` switches off what moves, `stopped`
//! says whether an input of the board prevents motion, and `note_crash` is told what led to a
//! reset. Its crystal is in constants.

pub(super) mod can;
pub(super) mod clock;
mod copy;
mod critical_section;
#[cfg(feature = "g474")]
pub(super) mod i2c;
pub(super) mod led;
pub(super) mod reset;
mod square_root;
pub(super) mod stack_guard;
pub(super) mod storage;
