//! The trait that hides a board from the rest of the firmware.

use super::OperatorSwitches;
use crate::roles::Role;
use crate::sensors::{Published, Rates};
use embassy_executor::{SpawnError, Spawner};
use embedded_storage::nor_flash::NorFlash;
use tautrack::bus::node::Condition;
use tautrack::fault_log::FaultLog;
use tautrack::motor::board_limits::Limit;
use tautrack::motor::bridge::{BridgeStop, Ratings};
use tautrack::motor::shaft_sensor;
use tautrack::sensors::{Switches, Temperatures};

/// Interface between a board and the rest of the firmware. A board is a singleton, so its methods
/// take no `self`.
///
/// Besides implementing these methods, a board does the following by itself:
/// * It calls [`crate::current_loop::pwm_period`] once in every PWM period, in its highest-priority
///   interrupt, and applies the returned [`PowerStage`](tautrack::motor::bridge::PowerStage) from
///   the next period on. Before the first call, and after a panic, its bridge is off and its brake
///   is engaged.
/// * It puts every frame that it receives from the bus into [`crate::bus::RECEIVED`], and sends
///   those of [`crate::bus::TRANSMIT`] as the bus has room, oldest first. Both queues may be used
///   in an interrupt.
/// * It puts every byte that it receives on its serial line into [`crate::serial::put`], if it
///   has such a line.
/// * It drives the clock of `embassy-time` in microseconds since power-up, and polls the executor.
/// * Its panic handler opens the bridge before anything else.
pub trait Board {
    /// Name of the board, equal to the name of its folder.
    const NAME: &'static str;
    /// Power stage. Its PWM rate is also the rate at which the board calls
    /// [`crate::current_loop::pwm_period`].
    const POWER_STAGE: Ratings;

    /// Bounds and defaults of the settings that depend on what the board is built of.
    const LIMITS: &'static [Limit] = &[];

    /// Flash for the settings: whole pages, at least two, that nothing else uses.
    type Storage: NorFlash;

    /// Starts the board, reads the settings, calls `role` to spawn its tasks, and runs them for
    /// ever. The simulator may ask for one of the `others` instead; hardware ignores them.
    fn run(role: &'static Role, others: &'static [&'static Role]) -> !;
    /// Counts of the rotor sensor since power-up; wraps at both ends of `i32`. Hall sensors count
    /// as [`tautrack::motor::halls::Halls`] says.
    fn encoder() -> i32;
    /// Whether the rotor sensor is broken. A board that cannot know keeps this method.
    fn encoder_broken() -> bool {
        false
    }
    /// Returns the faults that the board has kept over the last reset. A board without such memory
    /// keeps this method, and the next one.
    fn kept_faults() -> FaultLog {
        FaultLog::default()
    }
    /// Keeps the faults over the next reset.
    fn keep_faults(_log: &FaultLog) {}
    /// What has opened the bridge without software since the drive was disabled last, or led to the
    /// last reset. A board that cannot know keeps this method.
    fn bridge_stop() -> Option<BridgeStop> {
        None
    }
    /// Returns what is known of the absolute sensor at the output shaft. A board without an input
    /// for one keeps this method.
    fn shaft_sensor() -> shaft_sensor::Reading {
        shaft_sensor::Reading::default()
    }
    /// Count of the rotor sensor ([`Readings::rotor`](tautrack::motor::bridge::Readings::rotor)) at
    /// the newest pulse of the encoder's index since the last call. A board without such an input
    /// keeps this method.
    fn index() -> Option<u32> {
        None
    }
    /// Takes over the current limit, A, and the codes of the three half bridges without current, if
    /// something besides software opens the bridge beyond the limit. A board without such a thing
    /// keeps this method.
    fn set_over_current(_limit: f32, _zeros: [i32; 3]) {}
    /// Supply voltage, V; 0 while it is not known.
    fn supply_voltage() -> f32;
    /// Temperatures of bridge and motor. A board without sensors keeps this method.
    fn temperatures() -> Temperatures {
        Temperatures::default()
    }
    /// State of the axle's switches.
    fn switches() -> Switches;
    /// State of the operator's switches that are wired to the board. A board without them keeps
    /// this method.
    fn operator_switches() -> OperatorSwitches {
        OperatorSwitches::default()
    }
    /// Energizes the coil of the motor's holding brake, which releases it, or lets the brake
    /// engage. A board without a brake output ignores it. The brake is engaged before the first
    /// call and after a reset.
    fn set_brake(released: bool);
    /// Starts the tasks that read the sensors on the robot's body into what is published, at these
    /// rates: [`crate::sensors::run`] for chips on an I2C bus. Only the guard calls it. A board
    /// without sensors keeps this method.
    ///
    /// # Errors
    /// A task runs already.
    fn start_sensors(_: Spawner, _: Rates, _: &'static Published) -> Result<(), SpawnError> {
        Ok(())
    }
    /// Serial number of the board: differs between all boards of one bus.
    fn serial_number() -> u32;
    /// Flash for the settings. Erasing a page may take longer than [`crate::watchdog::PERIOD_US`],
    /// so the flash feeds the board's watchdog meanwhile. Reading a word that a power cut tore
    /// returns any bytes, but no error. The firmware writes only while the motor has no current.
    fn storage() -> Self::Storage;
    /// Condition of the CAN controller since the last call. A board that cannot know keeps this
    /// method.
    fn bus_condition() -> Condition {
        Condition::default()
    }
    /// Restarts the board as after power-up, soon. Its bridge is off.
    fn restart();
    /// Feeds the board's watchdog, which resets the node [`crate::watchdog::PERIOD_US`] after the
    /// last feed. Only [`crate::watchdog`] calls this, when all required parts of the firmware have
    /// run since the previous call.
    fn feed_watchdog();
}
