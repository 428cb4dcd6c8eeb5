//! Roles: the tasks of each kind of node. A tick reads the object dictionary, runs the control core
//! once, and writes the results back.

pub mod axle;
mod drive;
pub mod guard;
pub mod screw;

use crate::boards::{Board, Selected};
use crate::bus::{self, Bus, Dictionary, Listen, Master, Received};
use crate::watchdog::{self, Party};
use core::fmt::Write;
use embassy_executor::{SpawnError, SpawnToken, Spawner};
use heapless::String;
use tautrack::bus::heartbeat::Monitor;
use tautrack::math::to_i16;
use tautrack::settings::{Setting, Settings};

/// Text that tells a person why a node refuses its settings.
pub type Refusal = String<160>;

/// Kind of node.
pub struct Role {
    /// Name of the role.
    pub name: &'static str,
    /// Its object dictionary.
    pub dictionary: Dictionary,
    /// Checks the settings and spawns the tasks. The board calls it once.
    pub start: fn(Spawner, &Settings) -> Result<(), Refusal>,
}

/// Formats a [`Refusal`]; cuts off what exceeds its capacity.
pub fn refuse(arguments: core::fmt::Arguments) -> Refusal {
    struct Cut(Refusal);
    impl Write for Cut {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            text.chars()
                .try_for_each(|letter| self.0.push(letter).map_err(|_| core::fmt::Error))
        }
    }
    let mut text = Cut(Refusal::new());
    let _ = text.write_fmt(arguments); // the only error is a full text
    text.0
}

/// Creates the bus of a role and spawns its task. Requires the watchdog to monitor the bus task and
/// the control task, which every role has.
fn start_bus(
    spawner: Spawner,
    settings: &Settings,
    dictionary: Dictionary,
    listen: Option<Listen>,
    received: fn(Received),
) -> Result<(), Refusal> {
    let node_id = settings.id(Setting::NodeId);
    let heartbeat_ms = settings.get(Setting::HeartbeatPeriod) as u16;
    let guard_id = settings.id(Setting::GuardId);
    let master = (guard_id != node_id).then(|| Master {
        node_id: guard_id,
        heartbeat: Monitor::new(settings.milliseconds(Setting::HeartbeatTimeout)),
    });
    (dictionary.set_serial_number)(Selected::serial_number());
    watchdog::require(Party::Control);
    watchdog::require(Party::Bus);
    let bus = Bus::new(dictionary, node_id, heartbeat_ms, listen, master)
        .ok_or_else(|| refuse(format_args!("the bus cannot be made for node id {node_id}")))?;
    spawn(spawner, bus::task(bus, received))
}

/// Starts a node that has no settings: its bus is mute until a master gives it a node id by LSS.
///
/// # Errors
/// A task cannot start.
pub fn start_blank(spawner: Spawner, role: &'static Role) -> Result<(), Refusal> {
    watchdog::require(Party::Bus);
    spawn(spawner, bus::wait_for_id(spawner, role))
}

fn spawn<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) -> Result<(), Refusal> {
    spawner.spawn(task.map_err(|error| refuse(format_args!("a task cannot start: {error:?}")))?);
    Ok(())
}

/// Converts `value` to thousandths, as objects hold metres and metres per second.
fn milli(value: f32) -> i16 {
    to_i16(value * 1e3)
}

/// Converts `value` to hundredths, as objects hold degrees and m/s^2.
fn centi(value: f32) -> i16 {
    to_i16(value * 1e2)
}

/// Includes the generated dictionary of one role as a module with a `DICTIONARY`.
macro_rules! dictionary {
    ($name:ident, $file:literal) => {
        #[allow(missing_docs, unused_imports, clippy::all, clippy::pedantic)]
        mod $name {
            use crate::roles::{centi, milli};
            include!(concat!(env!("OUT_DIR"), "/", $file));
            pub const DICTIONARY: crate::bus::Dictionary = crate::bus::Dictionary {
                mailbox: &NODE_MBOX,
                state: &NODE_STATE,
                table: &OD_TABLE,
                set_serial_number: |number| OBJECT1018.set_serial(number),
            };
        }
    };
}
use dictionary;
