//! Host process as a board: the lockstep link on standard input and output. It is used for
//! parameter sweeps, fuzzing, sanitizers and debuggers.

use crate::boards::Board;
use crate::boards::lockstep::{self, End, Files, Machine, Pipe, text_log};
use crate::roles::Role;
use crate::sensors::Rates;
use embassy_executor::{SpawnError, Spawner};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use tautrack::motor::bridge::Ratings;
use tautrack::sensors::Switches;

/// A process of the host.
pub struct Native;

impl Board for Native {
    const NAME: &'static str = "native";
    const POWER_STAGE: Ratings = lockstep::POWER_STAGE;
    type Storage = lockstep::Flash;

    fn run(role: &'static Role, others: &'static [&'static Role]) -> ! {
        text_log::install();
        let machine = Machine::new(Self::NAME, role, others, Some(FILES));
        match lockstep::run(machine, &mut StandardStreams) {
            End::Finished => std::process::exit(0),
            End::Starved(starved) => {
                std::eprintln!("{starved}");
                std::process::exit(1)
            }
        }
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
    read: |path, bytes| match File::open(path) {
        Ok(mut file) => Some(fill(&mut file, bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(_) => Some(false),
    },
    write: |path, bytes| overwrite(path, bytes).is_ok(),
    unnamed: false,
};

/// Fills `bytes`; returns whether the file has their length.
fn fill(file: &mut File, bytes: &mut [u8]) -> bool {
    file.read_exact(bytes).is_ok() && matches!(file.read(&mut [0]), Ok(0))
}

/// Writes the file with a single write in place: so it stays whole if the process is killed.
fn overwrite(path: &str, bytes: &[u8]) -> std::io::Result<()> {
    let mut options = OpenOptions::new();
    let mut file = options
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)?;
    file.write_all(bytes)
}

struct StandardStreams;

impl Pipe for StandardStreams {
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        loop {
            match std::io::stdin().lock().read(buffer) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                read => return read.unwrap_or(0),
            }
        }
    }

    fn write(&mut self, bytes: &[u8]) -> bool {
        let mut output = std::io::stdout().lock();
        output.write_all(bytes).is_ok() && output.flush().is_ok()
    }

    /// A process has one node.
    fn turn_to(&mut self, node: u8, _: &'static Role) -> bool {
        node == 0
    }
}
