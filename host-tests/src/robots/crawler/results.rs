//! The results of the crawler: it adds nothing.

use super::section::Crawler;
use crate::results::robot::Results;

impl Results for Crawler {}
