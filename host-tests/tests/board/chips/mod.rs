//! The manufacturer's data about the chips of the boards: `description` reads them.

pub mod g431;
pub mod g474;
