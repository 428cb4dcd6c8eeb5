//! Roles: the tasks of each kind of node. A tick reads the object dictionary, runs the control core
//! once, and writes the results back.

pub mod axle;
mod dead_man;
mod drive;
pub mod guard;
pub mod screw;

use crate::boards::{Board, Selected};
use crate::bus::{self, Bus, Dictionary, Listen, Master, Received};
use crate::storage::{Check, Found};
use crate::watchdog::{self, Party};
use core::fmt::Display;
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use tautrack::bus::heartbeat::Monitor;
use tautrack::can::Frame;
use tautrack::math::to_i16;
use tautrack::settings::{Setting, Settings};

/// Text that tells a person why a node refuses its settings.
#[cfg(any(not(target_os = "none"), feature = "mps2"))]
pub type Refusal = heapless::String<160>;

/// What of a node refuses its settings. A board without the simulator's link has no more text.
#[cfg(not(any(not(target_os = "none"), feature = "mps2")))]
pub type Refusal = &'static str;

/// Kind of node.
pub struct Role {
    /// Name of the role.
    pub name: &'static str,
    /// Its object dictionary.
    pub dictionary: Dictionary,
    /// Returns a [`Refusal`] if [`Self::start`] would refuse these settings.
    pub check: Check,
    /// Checks the settings and spawns the tasks. The board calls it once.
    pub start: fn(Spawners, &Settings) -> Result<(), Refusal>,
}

/// Executors of a node. A board may use the same one for both.
#[derive(Clone, Copy)]
pub struct Spawners {
    /// Runs the control task, and interrupts the tasks of [`Self::bus`].
    pub control: SendSpawner,
    /// Runs all other tasks.
    pub bus: Spawner,
}

/// Returns the text of a refusal.
pub fn text(refusal: &Refusal) -> &str {
    refusal
}

/// Makes a [`Refusal`] of `what` is refused and the reason `why`; cuts off what exceeds its
/// capacity. A board without the simulator's link has nobody to read the text, so its program
/// contains no code that formats the reason.
#[cfg(any(not(target_os = "none"), feature = "mps2"))]
pub fn refuse(what: &'static str, why: impl Display) -> Refusal {
    use core::fmt::Write;
    struct Cut(Refusal);
    impl Write for Cut {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            text.chars()
                .try_for_each(|letter| self.0.push(letter).map_err(|_| core::fmt::Error))
        }
    }
    let mut text = Cut(Refusal::new());
    let _ = write!(text, "{what}: {why}"); // the only error is a full text
    text.0
}

/// Makes a [`Refusal`] of `what` is refused, without the reason.
#[cfg(not(any(not(target_os = "none"), feature = "mps2")))]
pub fn refuse(what: &'static str, _: impl Display) -> Refusal {
    what
}

/// Creates the bus of a role and spawns its task. Requires the watchdog to monitor the bus task and
/// the control task, which every role has. `commanded` returns whether the role follows an NMT
/// command.
fn start_bus(
    spawner: Spawner,
    settings: &Settings,
    dictionary: Dictionary,
    listen: Option<Listen>,
    received: fn(Received),
    commanded: fn(&Frame) -> bool,
) -> Result<(), Refusal> {
    let node_id = settings.id(Setting::NodeId);
    let heartbeat_ms = settings.get(Setting::HeartbeatPeriod) as u16;
    let guard_id = settings.id(Setting::GuardId);
    let master = (guard_id != node_id).then(|| Master {
        node_id: guard_id,
        heartbeat: Monitor::new(settings.milliseconds(Setting::HeartbeatTimeout)),
        ready: false,
    });
    (dictionary.set_serial_number)(Selected::serial_number());
    watchdog::require(Party::Control);
    watchdog::require(Party::Bus);
    let bus = Bus::new(dictionary, node_id, heartbeat_ms, listen, master, commanded)
        .ok_or_else(|| refuse("the bus cannot be made for node id", node_id))?;
    spawner.spawn(startable(bus::task(bus, received))?);
    Ok(())
}

/// Starts a node that has no settings: its bus is mute until a master gives it a node id by LSS.
/// `found` is what was found in flash.
///
/// # Errors
/// A task cannot start.
pub fn start_blank(spawners: Spawners, role: &'static Role, found: Found) -> Result<(), Refusal> {
    watchdog::require(Party::Bus);
    let waiting = bus::wait_for_id(spawners, role, found);
    spawners.bus.spawn(startable(waiting)?);
    Ok(())
}

/// Returns the token of a task, or a [`Refusal`] if the task runs already.
fn startable<S>(task: Result<SpawnToken<S>, SpawnError>) -> Result<SpawnToken<S>, Refusal> {
    task.map_err(|error| refuse("a task cannot start", error))
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
        #[allow(missing_docs, dead_code, unused_imports, clippy::all, clippy::pedantic)]
        mod $name {
            use crate::roles::{centi, milli};
            include!(concat!(env!("OUT_DIR"), "/", $file));
            pub const DICTIONARY: crate::bus::Dictionary = crate::bus::Dictionary {
                state: &NMT_STATE,
                receive_pdos: &RPDOS,
                transmit_pdos: &TPDOS,
                table: &OD_TABLE,
                set_serial_number: |number| OBJECT1018.set_serial(number),
            };
        }
    };
}
use dictionary;
