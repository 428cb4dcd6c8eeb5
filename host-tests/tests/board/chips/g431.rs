//! The motor board's chip.

use stm32_metapac as metapac;

#[allow(dead_code)] // each chip uses a part of it
#[path = "description.rs"]
mod description;
pub use description::*;
