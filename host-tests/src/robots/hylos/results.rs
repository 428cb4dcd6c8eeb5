//! The results of Hylos: it adds nothing.

use super::section::Hylos;
use crate::results::robot::Results;

impl Results for Hylos {}
