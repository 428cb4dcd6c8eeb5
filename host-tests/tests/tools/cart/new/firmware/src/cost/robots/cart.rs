//! Counts the cart's guard.

use crate::cost::counter::Table;
use crate::cost::guards::{count_guard, still};
use tautrack::robots::cart::Cart;

pub fn count(table: &mut Table) -> Option<()> {
    count_guard::<Cart>(table, "guard tick of the cart", 4, 0.05, still)
}
