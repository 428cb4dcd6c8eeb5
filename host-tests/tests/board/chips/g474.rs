//! The chip of the guard's board.

use stm32_metapac_of_g474 as metapac;

#[allow(dead_code)] // each chip uses a part of it
#[path = "description.rs"]
mod description;
pub use description::*;
