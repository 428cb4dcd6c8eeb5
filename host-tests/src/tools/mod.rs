//! The commands: [`demo`], [`suite`], [`evaluate`], [`cost`], and [`generate`], which writes the
//! reference pages.

pub mod cost;
pub mod demo;
pub mod evaluate;
pub mod generate;
pub mod suite;
