//! The commands: [`demo`], [`suite`], [`evaluate`], [`cost`], [`tool`], [`flash_node`], and
//! [`generate`], which writes the reference pages. [`page`] makes the page on the web. With the
//! feature `image`, `footprint` measures the memory of the motor board's programs.

pub mod cost;
pub mod demo;
pub mod evaluate;
pub mod flash_node;
#[cfg(feature = "image")]
pub mod footprint;
pub mod generate;
pub mod page;
pub(crate) mod robot;
mod settings;
pub mod suite;
pub mod tool;
