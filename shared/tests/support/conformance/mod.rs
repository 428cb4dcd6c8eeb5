//! Exchanges with a node whose answers CiA 301 and CiA 402 fix, in one [`notation`]. The table is
//! that of a [`drive`]. The tests run it against nodes as values, and against emulated nodes on the
//! bus of a simulation.

pub mod drive;
pub mod notation;

use notation::Step;

/// Node id of the node in the tables.
pub const NODE: u16 = 5;

/// Exchange with a node after its boot-up message.
pub struct Row {
    /// State before the exchange, and clause of the standard.
    pub name: String,
    /// Steps, of which the first ones lead to the state.
    pub steps: Vec<Step>,
}

impl Row {
    /// `serial` is the serial number of the node's board.
    pub fn new(name: &str, before: &str, exchange: &str, serial: u32) -> Self {
        let exchange = exchange.replace("serial", &format!("{serial:08x}"));
        let steps = notation::steps(&format!("{before}; {exchange}"));
        Self {
            name: name.to_owned(),
            steps,
        }
    }
}

/// Exchange after which a node sends no heartbeat.
pub const NO_HEARTBEAT: &str = "2b 1017:00 0000 > 60 1017:00";
