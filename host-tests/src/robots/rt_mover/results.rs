//! The results of RT-Mover: it adds nothing.

use super::section::RtMover;
use crate::results::robot::Results;

impl Results for RtMover {}
