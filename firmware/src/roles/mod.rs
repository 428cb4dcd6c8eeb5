//! The tasks of each kind of node: objects in, one tick of the control core, objects out.

pub mod axle;
mod drive;
pub mod guard;
pub mod screw;

use crate::bus::{self, Bus, Dictionary, Listen};
use core::fmt::Write;
use embassy_executor::Spawner;
use heapless::String;
use tautrack::can::Frame;

/// Settings of a node, as key and value.
pub type Settings = [(u16, i32)];
/// Why a node refuses its settings, for a person to read.
pub type Refusal = String<160>;

/// One kind of node.
pub struct Role {
    /// Its name.
    pub name: &'static str,
    /// Checks the settings and spawns the tasks; called once, by the board.
    pub start: fn(Spawner, &Settings) -> Result<(), Refusal>,
}

/// Key of the node id.
const NODE_ID: u16 = 1;

/// Makes a [`Refusal`]; what does not fit is cut off.
fn refuse(arguments: core::fmt::Arguments) -> Refusal {
    let mut text = Refusal::new();
    let _ = text.write_fmt(arguments);
    text
}

fn setting(settings: &Settings, wanted: u16) -> Option<i32> {
    settings
        .iter()
        .find(|(key, _)| *key == wanted)
        .map(|(_, value)| *value)
}

/// Makes the bus of a role and spawns its task.
fn start_bus(
    spawner: Spawner,
    settings: &Settings,
    dictionary: Dictionary,
    listen: Option<Listen>,
    heard: fn(Frame),
) -> Result<(), Refusal> {
    let node_id = setting(settings, NODE_ID).unwrap_or_default();
    let bus = u8::try_from(node_id)
        .ok()
        .and_then(|id| Bus::new(dictionary, id, listen))
        .ok_or_else(|| {
            refuse(format_args!(
                "setting {NODE_ID}: node id {node_id} is not in 1..=127"
            ))
        })?;
    spawner.spawn(
        bus::task(bus, heard)
            .map_err(|_| refuse(format_args!("the bus task is running already")))?,
    );
    Ok(())
}

/// The generated dictionary of one role, as a module with a `DICTIONARY`.
macro_rules! dictionary {
    ($name:ident, $file:literal) => {
        #[allow(missing_docs, clippy::all, clippy::pedantic)]
        mod $name {
            include!(concat!(env!("OUT_DIR"), "/", $file));
            pub const DICTIONARY: crate::bus::Dictionary = crate::bus::Dictionary {
                mailbox: &NODE_MBOX,
                state: &NODE_STATE,
                table: &OD_TABLE,
            };
        }
    };
}
use dictionary;
