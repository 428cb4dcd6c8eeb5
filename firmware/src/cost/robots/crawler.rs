//! Counts the crawler's guard.

use crate::cost::counter::Table;
use crate::cost::guards::{count_guard, still};
use tautrack::robots::crawler::Crawler;

pub fn count(table: &mut Table) -> Option<()> {
    count_guard::<Crawler>(table, "guard tick of the crawler", 4, 0.05, still)
}
