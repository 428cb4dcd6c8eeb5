//! Object dictionary of each role, generated from the tables in `shared/dictionary`: the table of
//! objects, the place of each value (`OBJECT` and the index), and functions that publish.

macro_rules! dictionary {
    ($(#[doc = $doc:literal])* $name:ident, $file:literal) => {
        $(#[doc = $doc])*
        #[allow(missing_docs, dead_code, unused_imports, clippy::all, clippy::pedantic)]
        pub mod $name {
            use crate::bus::node::{Access, Field, PdoDefaults, Row, Table, Values};
            use crate::bus::scale::{centi, centidegrees, milli};
            include!(concat!(env!("OUT_DIR"), "/", $file));
        }
    };
}

dictionary!(
    /// The role axle.
    axle,
    "axle.rs"
);
dictionary!(
    /// The role screw.
    screw,
    "screw.rs"
);
dictionary!(
    /// The role guard.
    guard,
    "guard.rs"
);
