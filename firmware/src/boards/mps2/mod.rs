//! QEMU's MPS2+ board with the AN386 image: a Cortex-M4F whose only hardware is the lockstep link
//! over semihosting.
//!
//! A message from the simulator starts one step of virtual time, and the answer carries the
//! results. `semihosting` provides the standard streams and the exit, and `link` carries messages
//! over them to the `machine`. `power_up` handles the start message and `step` the step messages.
//! `inputs` holds the sensor readings, `chips` the sensor chips on the robot's body, `brake` the
//! output to the brake, `flash` the settings in flash, `clock` provides timer and executor,
//! `critical_section` is that of a core without interrupts, `log` is the defmt logger, and
//! `starvation` the watchdog. When the simulator closes its pipe, the board ends.

mod brake;
mod chips;
mod clock;
#[cfg(not(feature = "cost"))]
mod critical_section;
mod flash;
mod inputs;
mod link;
mod log;
mod machine;
mod power_up;
pub(crate) mod semihosting;
mod starvation;
mod step;

use crate::boards::{Board, lockstep};
use crate::roles::Role;
use crate::sensors::{Published, Rates};
use core::fmt::Write;
use core::panic::PanicInfo;
use embassy_executor::{SpawnError, Spawner};
use link::Pipe;
use machine::{End, Machine};
use semihosting::{Stream, exit};
use tautrack::motor::bridge::Ratings;
use tautrack::sensors::Switches;

/// The emulated board.
pub struct Mps2;

impl Board for Mps2 {
    const NAME: &'static str = "mps2";
    const POWER_STAGE: Ratings = lockstep::POWER_STAGE;
    type Storage = flash::Flash;

    fn run(role: &'static Role, others: &'static [&'static Role]) -> ! {
        let (Some(input), Some(output)) = (Stream::standard_input(), Stream::standard_output())
        else {
            exit(false)
        };
        let machine = Machine::new(Self::NAME, role, others);
        if let End::Starved(starved) = link::run(machine, &mut Console { input, output }) {
            fail(format_args!("{starved}"))
        }
        exit(true)
    }

    fn encoder() -> i32 {
        inputs::encoder()
    }

    fn encoder_broken() -> bool {
        inputs::encoder_broken()
    }

    fn index() -> Option<u32> {
        inputs::index()
    }

    fn supply_voltage() -> f32 {
        inputs::supply_voltage()
    }

    fn switches() -> Switches {
        inputs::switches()
    }

    fn set_brake(released: bool) {
        brake::set_brake(released);
    }

    fn start_sensors(
        spawner: Spawner,
        rates: Rates,
        published: &'static Published,
    ) -> Result<(), SpawnError> {
        chips::start_sensors(spawner, rates, published)
    }

    fn serial_number() -> u32 {
        power_up::serial_number()
    }

    fn storage() -> flash::Flash {
        flash::Flash
    }

    fn restart() {
        step::restart();
    }

    fn feed_watchdog() {
        starvation::feed_watchdog();
    }
}

struct Console {
    input: Stream,
    output: Stream,
}

impl Pipe for Console {
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        self.input.read(buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> bool {
        self.output.write_all(bytes)
    }
}

/// Writes `why` to standard error and ends the emulator.
fn fail(why: core::fmt::Arguments) -> ! {
    if let Some(mut errors) = Stream::standard_error() {
        let _ = writeln!(errors, "{why}"); // there is no other output to report to
    }
    exit(false)
}

/// Opens the bridge first. On this board it is the simulated bridge, which ends with the emulator.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    crate::current_loop::demand(tautrack::node::axle::BridgeDemand::Off, 0.0, 0.0);
    fail(format_args!("{info}"))
}

#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    fail(format_args!("hard fault: {frame:?}"))
}
