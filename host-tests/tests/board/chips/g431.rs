//! The motor board's chip.

use stm32_metapac as metapac;

#[allow(dead_code, clippy::duplicate_mod)] // a part of it for each chip
#[path = "description.rs"]
mod description;
pub use description::*;
