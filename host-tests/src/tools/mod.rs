//! The commands: [`demo`], [`suite`], [`evaluate`], [`cost`], [`settings`] of the nodes on a bus,
//! [`flash_node`], and [`generate`], which writes the reference pages.

pub mod cost;
pub mod demo;
pub mod evaluate;
pub mod flash_node;
pub mod generate;
pub mod settings;
pub mod suite;
