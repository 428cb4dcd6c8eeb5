//! A board with what is connected to it, a motor or the sensor modules: answers the steps of a run
//! with a chip that executes a flash image.

use super::{CORE_HZ, Chip, Part, STM32G431, STM32G474, log};
use crate::programs::flash::{self, ImageError, Segment};
use crate::programs::settings_pages::{self, Pages};
use crate::simulator::bus::wire::worst_case_bits;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol};
use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use tautrack::can::Frame;
use tautrack::link::{MAX_LOG, Start, Step, Stepped};
use tautrack::motor::rotor::RotorSensor;
use tautrack::settings::{Setting, Settings};

/// Address at which the chip starts: the loader, or the application of a board without one.
const START: u32 = 0x0800_0000;
/// Bit rate of the GNSS receiver, bit/s.
const GNSS_BAUD: u64 = 115_200;
/// Core clocks of a microsecond, which is also the time of a bit on the bus.
const CLOCKS_PER_US: u64 = CORE_HZ / 1_000_000;

/// What `cargo flash-node` writes to the flash memory, without the settings.
#[derive(Clone, Debug)]
pub struct FlashImage {
    /// Name of the board, and its chip.
    board: &'static str,
    part: Part,
    segments: Vec<Segment>,
    /// Address of the settings pages.
    settings: u32,
    /// Address of the log's control block.
    log: u32,
}

impl FlashImage {
    /// Reads the application at `path`. That of a motor board has a header, and the loader is
    /// beside it.
    ///
    /// # Errors
    /// A text that names the file that is missing or no program of a board.
    pub fn load(path: &Path) -> Result<Self, String> {
        let read = |path: &Path| {
            fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))
        };
        let fail = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let (board, part, settings, mut segments, application) = match flash::sealed(read(path)?) {
            Ok(application) => {
                let loader = read(&path.with_file_name("loader"))?;
                let loader = flash::segments(&loader).map_err(|error| fail(&error))?;
                let settings = settings_pages::ADDRESS;
                ("esc1", STM32G431, settings, loader, application)
            }
            Err(ImageError::NoHeader) => {
                let settings = settings_pages::GUARD_ADDRESS;
                ("g474", STM32G474, settings, Vec::new(), read(path)?)
            }
            Err(error) => return Err(fail(&error)),
        };
        segments.extend(flash::segments(&application).map_err(|error| fail(&error))?);
        let file = ElfFile32::<Endianness>::parse(&*application).map_err(|error| fail(&error))?;
        let log = file
            .symbols()
            .find(|symbol| symbol.name() == Ok("_SEGGER_RTT"))
            .ok_or_else(|| fail(&"the program has no log"))?
            .address() as u32;
        Ok(Self {
            board,
            part,
            segments,
            settings,
            log,
        })
    }

    /// Name of the board.
    pub fn board(&self) -> &'static str {
        self.board
    }
}

/// A board in a run.
pub struct FlashedBoard {
    chip: Chip,
    log: u32,
    /// Frames that the chip has sent and no answer has carried yet.
    sent: VecDeque<Frame>,
}

impl FlashedBoard {
    /// Flashes the image with the settings of the start message, and switches the board on.
    ///
    /// # Errors
    /// A text that names what is wrong with the start message.
    pub fn new(image: &FlashImage, start: &Start) -> Result<Self, String> {
        let mut chip = Chip::of(image.part, &image.segments, START);
        chip.forget_writes();
        chip.set_serial_number(start.seed);
        let settings: Option<Vec<(Setting, i32)>> = start
            .settings
            .iter()
            .map(|(key, value)| Some((Setting::from_key(*key)?, *value)))
            .collect();
        let settings = settings.ok_or("a setting has an unknown key")?;
        if !settings.is_empty() {
            chip.patch(image.settings, &Pages::of(&settings)?.0);
        }
        let has_halls = rotor_sensor(&settings).is_some_and(RotorSensor::has_halls);
        if let Some(model) = start.motor {
            chip.attach_motor(model, start.seed)
                .ok_or("the motor model cannot be simulated")?;
            if has_halls {
                chip.connect_halls();
            }
        } else {
            chip.connect_modules();
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
        self.chip.send_serial(&step.serial, GNSS_BAUD);
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
            // The chip resets itself.
            restart: false,
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

/// Rotor sensor of a node that starts with these settings.
fn rotor_sensor(changes: &[(Setting, i32)]) -> Option<RotorSensor> {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        // The node refuses what is out of bounds.
        let _ = settings.set(setting.bounds().key, *value);
    }
    RotorSensor::of(&settings)
}
