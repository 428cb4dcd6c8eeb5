//! Roles: the node of each kind on its board, and the task that carries frames and readings to it.

pub mod axle;
pub(crate) mod drive;
pub mod guard;
pub mod screw;

use crate::boards::{Board, Selected};
use crate::bus::{self, RECEIVED, TRANSMIT};
use crate::refusal::{Refusal, refuse};
use crate::storage::Check;
use crate::watchdog::{self, Party};
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker};
use tautrack::bus::network::NmtState;
use tautrack::bus::node::{Condition, Table};
use tautrack::can::Frame;
use tautrack::constants::CONTROL_HZ;
use tautrack::fault_log::FaultLog;
use tautrack::roles::settings::Found;
use tautrack::settings::Settings;

/// Kind of node.
pub struct Role {
    /// Name of the role.
    pub name: &'static str,
    /// Its objects.
    pub table: &'static Table,
    /// Whether it reads a sensor at its output shaft. The program of a role that does not is
    /// smaller.
    pub shaft_sensor: bool,
    /// Returns a [`Refusal`] if [`Self::start`] would refuse these settings.
    pub check: Check,
    /// Checks the settings and spawns the tasks, with what was found in flash. The board calls it
    /// once.
    pub start: fn(Spawners, &Settings, Found) -> Result<(), Refusal>,
}

/// Executors of a node. A board may use the same one for both.
#[derive(Clone, Copy)]
pub struct Spawners {
    /// Runs the node, and interrupts the tasks of [`Self::bus`].
    pub control: SendSpawner,
    /// Runs all other tasks.
    pub bus: Spawner,
}

/// A node on its board. Each method passes the frames that the node sends to the board.
pub trait Node: Send {
    /// Sends the boot-up message.
    fn boot(&mut self, now_us: u64);
    /// Follows a frame from the bus.
    fn receive(&mut self, frame: &Frame, now_us: u64);
    /// Takes the condition of the CAN controller, before a tick.
    fn note_bus(&mut self, condition: Condition);
    /// Runs one control tick. Returns whether the board is to restart.
    fn tick(&mut self, now_us: u64) -> bool;
    /// Returns the state of the network management.
    fn state(&self) -> NmtState;
    /// Returns the history of faults.
    fn errors(&mut self) -> &mut FaultLog;
}

static OPERATIONAL: AtomicBool = AtomicBool::new(false);

/// Whether NMT has set this node to "operational". Process data is exchanged only in this state.
pub fn operational() -> bool {
    OPERATIONAL.load(Ordering::Relaxed)
}

/// Time from one control tick to the next.
const PERIOD: Duration = Duration::from_hz(CONTROL_HZ as u64);

/// A control tick is due.
static TICK: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Spawns the tasks of `node`.
fn spawn(spawners: Spawners, node: &'static mut dyn Node) -> Result<(), Refusal> {
    watchdog::require(Party::Control);
    spawners.control.spawn(startable(run(node))?);
    spawners.control.spawn(startable(keep_time())?);
    watchdog::require(Party::Thread);
    spawners.bus.spawn(startable(attend())?);
    Ok(())
}

/// Shows the watchdog that the tasks of the thread run.
#[embassy_executor::task]
async fn attend() -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(5));
    loop {
        ticker.next().await;
        watchdog::ran(Party::Thread);
    }
}

#[embassy_executor::task]
async fn keep_time() -> ! {
    let mut ticker = Ticker::every(PERIOD);
    loop {
        ticker.next().await;
        TICK.signal(());
    }
}

/// Runs the node: frames first, because a tick uses what they bring.
#[embassy_executor::task]
async fn run(node: &'static mut dyn Node) -> ! {
    *node.errors() = Selected::kept_faults();
    node.boot(Instant::now().as_micros());
    let mut earliest = Instant::MIN;
    loop {
        match select(RECEIVED.next(), TICK.wait()).await {
            Either::First(frame) => node.receive(&frame, Instant::now().as_micros()),
            // Behind a save, ticks come in quick succession. A tick would miss samples of the
            // current if it followed another one within half a period.
            Either::Second(()) if Instant::now() < earliest => {}
            Either::Second(()) => {
                earliest = Instant::now() + PERIOD / 2;
                node.note_bus(bus::condition(Selected::bus_condition()));
                if node.tick(Instant::now().as_micros()) {
                    Selected::restart();
                }
                watchdog::ran(Party::Control);
            }
        }
        if node.errors().take_changed() {
            Selected::keep_faults(node.errors());
        }
        let operational = node.state() == NmtState::Operational;
        OPERATIONAL.store(operational, Ordering::Relaxed);
    }
}

/// Sends a frame of the node.
fn send(frame: Frame) {
    TRANSMIT.push(frame);
}

/// Starts a node that has no settings: its bus is mute until a master gives it a node id by LSS.
/// `found` is what was found in flash.
///
/// # Errors
/// A task cannot start.
pub fn start_blank(spawners: Spawners, role: &'static Role, found: Found) -> Result<(), Refusal> {
    watchdog::require(Party::Thread);
    let waiting = bus::wait_for_id(spawners, role, found);
    spawners.bus.spawn(startable(waiting)?);
    Ok(())
}

/// Returns the token of a task, or a [`Refusal`] if the task runs already.
fn startable<S>(task: Result<SpawnToken<S>, SpawnError>) -> Result<SpawnToken<S>, Refusal> {
    task.map_err(|error| refuse("a task cannot start", error))
}
