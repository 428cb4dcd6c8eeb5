//! Random drives, and the oracle that watches them.

pub mod generator;
pub mod oracle;
