//! Keeps the settings in flash, through power cuts and changes of the table.
//!
//! `flash` loads and saves. `schema` describes what a program knows: the rows of its table, and the
//! settings that an earlier schema had under other keys. `report` is the result of loading.
//! `copies` is the layout of the flash. `image` holds the items in memory.

mod copies;
mod flash;
mod image;
mod report;
mod schema;

pub use flash::{Saved, Store, StoreError};
pub use report::{Refused, Report, State};
pub use schema::{Move, SCHEMA, Schema};
