//! The chip of the guard's board.

use stm32_metapac_of_g474 as metapac;

#[allow(dead_code, clippy::duplicate_mod)] // a part of it for each chip
#[path = "description.rs"]
mod description;
pub use description::*;
