//! QEMU's MPS2+ board with the AN386 image: a Cortex-M4F whose only hardware is the lockstep link
//! over semihosting.
//!
//! `semihosting` provides the standard streams and the exit, `log` the defmt logger, and `turns`
//! lets several nodes share the machine. When the simulator closes its pipe, the board ends.

mod log;
pub(crate) mod semihosting;
mod turns;

use crate::boards::Board;
use crate::boards::lockstep::{self, End, Files, Machine, Pipe};
use crate::roles::Role;
use crate::sensors::Rates;
use core::cell::RefCell;
use core::fmt::Write;
use core::panic::PanicInfo;
use critical_section::Mutex;
use embassy_executor::{SpawnError, Spawner};
use semihosting::{Stream, exit};
use tautrack::motor::bridge::Ratings;
use tautrack::sensors::Switches;
use turns::Turns;

/// The emulated board.
pub struct Mps2;

impl Board for Mps2 {
    const NAME: &'static str = "mps2";
    const POWER_STAGE: Ratings = lockstep::POWER_STAGE;
    type Storage = lockstep::Flash;

    fn run(role: &'static Role, others: &'static [&'static Role]) -> ! {
        let (Some(input), Some(output)) = (Stream::standard_input(), Stream::standard_output())
        else {
            exit(false)
        };
        let Some(turns) = Turns::new() else {
            fail(format_args!("the host has no room for temporary files"))
        };
        let mut console = Console {
            input,
            output,
            turns,
        };
        let machine = Machine::new(Self::NAME, role, others, Some(FILES));
        if let End::Starved(starved) = lockstep::run(machine, &mut console) {
            fail(format_args!("{starved}"))
        }
        exit(true)
    }

    fn encoder() -> i32 {
        lockstep::encoder()
    }

    fn encoder_broken() -> bool {
        lockstep::encoder_broken()
    }

    fn index() -> Option<u32> {
        lockstep::index()
    }

    fn supply_voltage() -> f32 {
        lockstep::supply_voltage()
    }

    fn switches() -> Switches {
        lockstep::switches()
    }

    fn set_brake(released: bool) {
        lockstep::set_brake(released);
    }

    fn start_sensors(spawner: Spawner, rates: Rates) -> Result<(), SpawnError> {
        lockstep::start_sensors(spawner, rates)
    }

    fn serial_number() -> u32 {
        lockstep::serial_number()
    }

    fn storage() -> lockstep::Flash {
        lockstep::Flash
    }

    fn feed_watchdog() {
        lockstep::feed_watchdog();
    }
}

const FILES: Files = Files {
    read: |path, bytes| {
        if path.is_empty() {
            return with_unnamed(|file| {
                file.as_ref()
                    .map(|file| file.seek(0) && file.read_exact(bytes))
            });
        }
        Stream::read_file(path).map(|file| {
            let whole = file.read_exact(bytes) && !file.read_exact(&mut [0]);
            file.close();
            whole
        })
    },
    write: |path, bytes| {
        if path.is_empty() {
            return with_unnamed(|file| {
                if file.is_none() {
                    *file = Stream::temporary();
                }
                file.as_ref()
                    .is_some_and(|file| file.seek(0) && file.write_all(bytes))
            });
        }
        Stream::write_file(path).is_some_and(|file| {
            let whole = file.write_all(bytes);
            file.close();
            whole
        })
    },
    unnamed: true,
};

/// Calls `use_it` with the file of the node that has no name, if it was written.
fn with_unnamed<R>(use_it: impl FnOnce(&mut Option<Stream>) -> R) -> R {
    static FILE: Mutex<RefCell<Option<Stream>>> = Mutex::new(RefCell::new(None));
    critical_section::with(|cs| use_it(&mut FILE.borrow(cs).borrow_mut()))
}

struct Console {
    input: Stream,
    output: Stream,
    turns: Turns,
}

impl Pipe for Console {
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        self.input.read(buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> bool {
        self.output.write_all(bytes)
    }

    fn turn_to(&mut self, node: u8, role: &'static Role) -> bool {
        // SAFETY: the link borrows the machine alone, whose place and type are those of every node.
        if !unsafe { self.turns.turn_to(node, role) } {
            fail(format_args!(
                "no variables of node {node}: its number leaves one out, or the folder for temporary files is full"
            ))
        }
        true
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
