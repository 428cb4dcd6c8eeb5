//! Keeps the settings in flash, through power cuts and changes of the table.
//!
//! `flash` loads and saves. `schema` describes what a program knows: the rows of its table, the
//! groups that change together, and the settings that an earlier schema had under other keys.
//! `report` is the result of loading. `erase` is the flash below the crate that keeps the items:
//! it completes an erase that a power cut interrupted. `image` holds the items in memory.

mod erase;
mod flash;
mod image;
mod report;
mod schema;

pub use flash::{Saved, Store, StoreError};
pub use report::{Refused, Report, State};
pub use schema::{Move, RECORDS, Record, SCHEMA, Schema};
