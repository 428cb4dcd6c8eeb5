//! The motor board with its motor: answers the steps of a run with a chip that executes a flash
//! image.

use super::{CORE_HZ, Chip, log};
use crate::programs::flash::{self, Segment};
use crate::programs::settings_pages::{self, Pages};
use crate::simulator::bus::wire::worst_case_bits;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol};
use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use tautrack::can::Frame;
use tautrack::link::{MAX_LOG, Start, Step, Stepped};
use tautrack::settings::Setting;

/// Address at which the chip starts: the loader.
const LOADER: u32 = 0x0800_0000;
/// Core clocks of a microsecond, which is also the time of a bit on the bus.
const CLOCKS_PER_US: u64 = CORE_HZ / 1_000_000;

/// What `cargo flash-node` writes to the flash memory, without the settings.
#[derive(Clone, Debug)]
pub struct FlashImage {
    segments: Vec<Segment>,
    /// Address of the log's control block.
    log: u32,
}

impl FlashImage {
    /// Reads the application at `path` and the loader beside it.
    ///
    /// # Errors
    /// A text that names the file that is missing or no program of the motor board.
    pub fn load(path: &Path) -> Result<Self, String> {
        let read = |path: &Path| {
            fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))
        };
        let fail = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let loader = read(&path.with_file_name("loader"))?;
        let application = flash::sealed(read(path)?).map_err(|error| fail(&error))?;
        let mut segments = flash::segments(&loader).map_err(|error| fail(&error))?;
        segments.extend(flash::segments(&application).map_err(|error| fail(&error))?);
        let file = ElfFile32::<Endianness>::parse(&*application).map_err(|error| fail(&error))?;
        let log = file
            .symbols()
            .find(|symbol| symbol.name() == Ok("_SEGGER_RTT"))
            .ok_or_else(|| fail(&"the program has no log"))?
            .address() as u32;
        Ok(Self { segments, log })
    }
}

/// A motor board in a run.
pub struct MotorBoard {
    chip: Chip,
    log: u32,
    /// Frames that the chip has sent and no answer has carried yet.
    sent: VecDeque<Frame>,
}

impl MotorBoard {
    /// Flashes the image with the settings of the start message, and switches the board on.
    ///
    /// # Errors
    /// A text that names what is wrong with the start message.
    pub fn new(image: &FlashImage, start: &Start) -> Result<Self, String> {
        let mut chip = Chip::new(&image.segments, LOADER);
        chip.forget_writes();
        chip.set_serial_number(start.seed);
        let settings: Option<Vec<(Setting, i32)>> = start
            .settings
            .iter()
            .map(|(key, value)| Some((Setting::from_key(*key)?, *value)))
            .collect();
        let settings = settings.ok_or("a setting has an unknown key")?;
        if !settings.is_empty() {
            chip.patch(settings_pages::ADDRESS, &Pages::of(&settings)?.0);
        }
        if let Some(model) = start.motor {
            chip.attach_motor(model, start.seed)
                .ok_or("the motor model cannot be simulated")?;
        }
        Ok(Self {
            chip,
            log: image.log,
            sent: VecDeque::new(),
        })
    }

    /// Runs the chip up to the time of the step. The frames arrive one after the other, each after
    /// its time on the bus.
    pub fn step(&mut self, step: &Step) -> Stepped {
        let end = step.time_us * CLOCKS_PER_US;
        let mut arrival = self.chip.clock();
        self.chip.set_sensors(&step.sensors);
        for frame in &step.frames {
            arrival += u64::from(worst_case_bits(frame)) * CLOCKS_PER_US;
            self.chip.run_until(arrival.min(end));
            self.chip.send(*frame);
        }
        self.chip.run_until(end);
        let sent = self.chip.take_sent();
        self.sent.extend(sent.into_iter().map(|(_, frame)| frame));
        let mut stepped = Stepped {
            shaft: self.chip.shaft(),
            frames: heapless::Vec::new(),
            log: heapless::Vec::new(),
        };
        let frames = self.sent.len().min(stepped.frames.capacity());
        stepped.frames.extend(self.sent.drain(..frames));
        stepped
            .log
            .extend(log::take(&mut self.chip, self.log, MAX_LOG));
        stepped
    }

    /// Instructions that the core has executed.
    pub fn instructions(&self) -> u64 {
        self.chip.instructions
    }
}
