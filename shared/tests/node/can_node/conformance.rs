//! Runs the table of exchanges against nodes of drives.

use super::{Node, SERIAL, exchange};
use crate::conformance::drive;

#[test]
fn a_node_answers_as_the_standards_say() {
    exchange::run_all(&drive::rows(drive::Role::Axle, SERIAL), Node::axle);
    exchange::run_all(&drive::rows(drive::Role::Screw, SERIAL), Node::screw);
}
