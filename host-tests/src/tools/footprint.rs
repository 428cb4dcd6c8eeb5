//! `cargo footprint`: flash memory, static variables and stack of the boards' programs, beside
//! their limits, which the files `cost.toml` have.
//!
//! The stack is measured while the program runs on the model of the chip: it starts, saves a
//! setting, is configured and enabled over the bus, and drives; a guard receives frames of drives
//! and of an operator. Its deepest place was seen on painted RAM. The nested stack adds the deepest
//! stacks of the thread and of each interrupt priority, as if all interrupts came at the worst
//! moments. Code that this run does not reach is in neither. The frames of all functions are not
//! summed: a stable compiler does not emit their sizes.

use crate::programs::settings_pages::{self, Pages};
use crate::programs::setup::checkout;
use crate::programs::{MotorBoard, Program, flash, guard_board, motor_board};
use crate::robots::{Kind, Role};
use crate::scenario::Scenario;
use crate::simulator::chip::{Chip, Executed, Part, STM32G431, STM32G474};
use crate::tools::cost::ceilings::Ceilings;
use clap::{Parser, ValueEnum};
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use tautrack::can::Frame;
use tautrack::link::ChipFault;
use tautrack::settings::{FIRST_OBJECT, Setting};

const FLASH: u32 = 0x0800_0000;
/// RAM of the largest chip. No chip has anything else there.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2002_0000;
/// Bytes of the guard at the end of the stack, as the firmware's `boards::stm32g4::stack_guard` has
/// them.
const STACK_GUARD: u32 = 512;
/// Scenario that has the settings of the nodes.
const SCENARIO: &str = "host-tests/scenarios/staircase.toml";
/// Node id of the chip.
const NODE: u16 = 5;

/// Prints flash memory, static variables and stack of the boards' programs, beside their limits.
/// Fails above a limit.
#[derive(Parser)]
#[command(name = "cargo footprint")]
struct Arguments {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Memory that a program needs, bytes.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Footprint {
    /// Name of the board.
    pub board: &'static str,
    /// Name of the program.
    pub program: &'static str,
    /// Vectors, code, constants and initial values.
    pub flash: u32,
    /// Limit of the flash memory.
    pub flash_limit: u32,
    /// Static variables.
    pub static_ram: u32,
    /// Deepest stack that was seen.
    pub stack: u32,
    /// Sum of the deepest stacks of the thread and of each interrupt priority.
    pub nested_stack: u32,
    /// Limit of static variables and [`stack`](Self::stack).
    pub ram_limit: u32,
    /// RAM of the chip without the guard at the end of the stack: the limit of static variables and
    /// [`nested_stack`](Self::nested_stack).
    pub ram: u32,
}

impl Footprint {
    /// One line for each limit that is exceeded.
    pub fn excesses(&self) -> Vec<String> {
        let ram = self.static_ram + self.stack;
        [
            ("flash memory", self.flash, self.flash_limit),
            ("RAM", ram, self.ram_limit),
            ("RAM, nested", self.static_ram + self.nested_stack, self.ram),
        ]
        .into_iter()
        .filter(|(_, used, limit)| used > limit)
        .map(|(what, used, limit)| format!("{}: {what}: {used} of {limit} bytes", self.program))
        .collect()
    }
}

/// Runs the command. The first of `arguments` is the program's name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match command(&Arguments::parse_from(arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo footprint: {error}");
            ExitCode::FAILURE
        }
    }
}

fn command(arguments: &Arguments) -> Result<(), String> {
    let programs = motor_board().map_err(|error| error.to_string())?;
    let mut footprints: Vec<_> = measure(&programs)?.into();
    footprints.extend(measure_guards()?);
    if arguments.json {
        let text = serde_json::to_string_pretty(&footprints).map_err(|error| error.to_string())?;
        println!("{text}");
    } else {
        print!("{}", table(&footprints));
    }
    let excesses: Vec<_> = footprints.iter().flat_map(Footprint::excesses).collect();
    if excesses.is_empty() {
        Ok(())
    } else {
        Err(excesses.join("\n"))
    }
}

fn table(footprints: &[Footprint]) -> String {
    let line = |cells: [&str; 7]| {
        let [board, program, flash, variables, stack, nested, sum] = cells;
        format!(
            "{board:<6} {program:<14} {flash:>14} {variables:>7} {stack:>6} {nested:>7} {sum:>13}\n"
        )
    };
    let heading = line([
        "board",
        "program",
        "flash",
        "static",
        "stack",
        "nested",
        "static+stack",
    ]);
    let rows = footprints.iter().map(|row| {
        line([
            row.board,
            row.program,
            &format!("{}/{}", row.flash, row.flash_limit),
            &row.static_ram.to_string(),
            &row.stack.to_string(),
            &row.nested_stack.to_string(),
            &format!("{}/{}", row.static_ram + row.stack, row.ram_limit),
        ])
    });
    let rows: String = rows.collect();
    heading + &rows + "bytes; the stacks were measured on a model of the chip\n"
}

/// Measures the programs.
///
/// # Errors
/// A program is not readable, or a section or symbol is missing; the text names it.
pub fn measure(programs: &MotorBoard) -> Result<[Footprint; 3], String> {
    Ok([
        application("axle", &programs.axle, Role::Axle)?,
        application("screw", &programs.screw, Role::Screw)?,
        loader(programs)?,
    ])
}

/// Builds the guards of all robots for the guard's board, and measures them.
///
/// # Errors
/// The same, and failures of the build.
pub fn measure_guards() -> Result<Vec<Footprint>, String> {
    let guards: Vec<_> = Kind::value_variants()
        .iter()
        .map(|robot| robot.facts().guard_program)
        .collect();
    let programs = guard_board(&guards).map_err(|error| error.to_string())?;
    Kind::value_variants()
        .iter()
        .zip(&programs)
        .map(|(robot, program)| guard(*robot, program))
        .collect()
}

/// Limits of flash memory and RAM of a program.
fn limits(program: &str) -> Result<[u32; 2], String> {
    let Ceilings { flash, ram, .. } = Ceilings::read()?;
    let limits = flash.get(program).zip(ram.get(program));
    limits
        .map(|(flash, ram)| [*flash, *ram])
        .ok_or_else(|| format!("no cost.toml has ceilings of flash and ram for {program}"))
}

fn guard(robot: Kind, program: &Program) -> Result<Footprint, String> {
    let image = Image::read(program)?;
    let mut chip = image.chip(STM32G474);
    let scenario = format!("host-tests/scenarios/{}", robot.facts().scenario_file);
    let settings = settings(&scenario, Role::Guard)?;
    chip.patch(settings_pages::GUARD_ADDRESS, &Pages::of(&settings)?.0);
    chip.connect_modules();
    let nested_stack = exercise(&mut chip, image.stack_start, listen);
    let name = robot.facts().guard_program;
    let [flash_limit, ram_limit] = limits(name)?;
    Ok(Footprint {
        board: "g474",
        program: name,
        flash: image.flash,
        flash_limit,
        static_ram: image.static_ram,
        stack: chip.deepest_stack(RAM.start as u32 + image.static_ram),
        nested_stack,
        ram_limit,
        ram: image.guarded_ram(),
    })
}

fn application(name: &'static str, program: &Program, role: Role) -> Result<Footprint, String> {
    let image = Image::read(program)?;
    let mut chip = image.chip(STM32G431);
    let mut settings = settings(SCENARIO, role)?;
    settings.push((Setting::NodeId, NODE.into()));
    chip.patch(settings_pages::ADDRESS, &Pages::of(&settings)?.0);
    let nested_stack = exercise(&mut chip, image.stack_start, drive);
    let [flash_limit, ram_limit] = limits(name)?;
    Ok(Footprint {
        board: "esc1",
        program: name,
        flash: image.flash,
        flash_limit,
        static_ram: image.static_ram,
        stack: chip.deepest_stack(RAM.start as u32 + image.static_ram),
        nested_stack,
        ram_limit,
        ram: image.guarded_ram(),
    })
}

fn loader(programs: &MotorBoard) -> Result<Footprint, String> {
    let image = Image::read(&programs.loader)?;
    let mut chip = image.chip(STM32G431);
    // Without an application, it stays in the loader.
    let nested_stack = exercise(&mut chip, image.stack_start, |chip| chip.run(100_000));
    let [flash_limit, ram_limit] = limits("loader")?;
    Ok(Footprint {
        board: "esc1",
        program: "loader",
        flash: image.flash,
        flash_limit,
        static_ram: image.static_ram,
        stack: chip.deepest_stack(RAM.start as u32 + image.static_ram),
        nested_stack,
        ram_limit,
        ram: image.stack_start - RAM.start as u32,
    })
}

/// Settings of the first node of a scenario with this role.
fn settings(scenario: &str, role: Role) -> Result<Vec<(Setting, i32)>, String> {
    let root = checkout::root().map_err(|error| error.to_string())?;
    let scenario = Scenario::load(&root.join(scenario)).map_err(|error| error.to_string())?;
    let node = scenario.nodes().into_iter().find(|node| node.role == role);
    let node = node.ok_or("the scenario has no such node")?;
    let mut settings = node.settings;
    settings.push((Setting::NodeId, node.id.into()));
    Ok(settings)
}

/// Program as the linker made it.
struct Image {
    segments: Vec<flash::Segment>,
    start: u32,
    /// Stack pointer at the start: the end of RAM.
    stack_start: u32,
    flash: u32,
    static_ram: u32,
}

impl Image {
    fn read(program: &Program) -> Result<Self, String> {
        let path = program.path.display();
        let elf = fs::read(&program.path).map_err(|error| format!("{path}: {error}"))?;
        let segments = flash::segments(&elf).map_err(|error| format!("{path}: {error}"))?;
        let file = parse(&elf)?;
        let static_end = file
            .sections()
            .filter(|section| RAM.contains(&section.address()))
            .map(|section| section.address() + section.size())
            .max();
        let stack_start = segments
            .first()
            .and_then(|first| first.bytes.first_chunk())
            .map(|word| u32::from_le_bytes(*word))
            .ok_or_else(|| format!("{path}: no vector table"))?;
        Ok(Self {
            stack_start,
            start: segments.first().map_or(FLASH, |first| first.address),
            flash: segments.iter().map(|part| part.bytes.len() as u32).sum(),
            static_ram: static_end.map_or(0, |end| (end - RAM.start) as u32),
            segments,
        })
    }

    /// RAM without the guard at the end of the stack, which is aligned to its size.
    fn guarded_ram(&self) -> u32 {
        let ram = self.stack_start - RAM.start as u32;
        ram - STACK_GUARD - (self.static_ram.next_multiple_of(STACK_GUARD) - self.static_ram)
    }

    /// A chip that has this image, and starts it.
    fn chip(&self, part: Part) -> Chip {
        Chip::of(part, &self.segments, self.start)
    }
}

fn parse(elf: &[u8]) -> Result<ElfFile32<'_, Endianness>, String> {
    ElfFile32::parse(elf).map_err(|error| error.to_string())
}

/// Changes a setting of this node, and saves the settings.
fn save(chip: &mut Chip, node: u16, setting: Setting, value: i32) {
    let [low, high] = (FIRST_OBJECT + setting.bounds().key).to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    for data in [[0x23, low, high, 0, a, b, c, d], *b"\x23\x10\x10\x01save"] {
        chip.send(Frame::new(0x600 + node, &data).unwrap_or_default());
        chip.run(50_000);
    }
}

/// Starts a node, has it save a setting, configures and enables it over the bus, lets it drive, and
/// lets it fail.
fn drive(chip: &mut Chip) {
    chip.run(50_000);
    save(chip, NODE, Setting::PositionWindowTime, 21);
    let mut send = |id: u16, data: &[u8]| {
        chip.send(Frame::new(id, data).unwrap_or_default());
        chip.run(5_000);
    };
    send(0x000, &[1, 0]);
    send(0x600 + NODE, &[0x40, 0x41, 0x60, 0, 0, 0, 0, 0]);
    send(0x600 + NODE, &[0x2f, 0x01, 0x20, 0, 1, 0, 0, 0]);
    send(0x600 + NODE, &[0x2f, 0x60, 0x60, 0, 9, 0, 0, 0]);
    for control in [0x06, 0x07, 0x0f] {
        send(0x600 + NODE, &[0x2b, 0x40, 0x60, 0, control, 0, 0, 0]);
    }
    for _ in 0..20 {
        send(0x080, &[]);
        send(0x600 + NODE, &[0x23, 0xff, 0x60, 0, 100, 0, 0, 0]);
    }
    // Without set-points, the drive stops with a fault.
    chip.run(100_000);
}

/// Starts a guard with its sensor chips. Its drives are present, an operator requests to arm and
/// to drive, and the GNSS receiver sends. At the end, a chip holds the I2C bus.
fn listen(chip: &mut Chip) {
    const GUARD: u16 = 1;
    chip.run(50_000);
    save(chip, GUARD, Setting::OperatorTimeout, 300);
    let sentence =
        b"$GPGGA,120000.00,4530.0000,N,00730.0000,E,4,12,0.6,500.0,M,48.0,M,1.0,0000*4C\r\n";
    for step in 0..100_u8 {
        for drive in 2..16 {
            chip.send(Frame::new(0x700 + drive, &[5]).unwrap_or_default());
            // Ready to be switched on, no fault.
            let status = [0x21, 0, 0, 0, 0, 0, 0, 0];
            chip.send(Frame::new(0x180 + drive, &status).unwrap_or_default());
            chip.send(Frame::new(0x280 + drive, &[0; 8]).unwrap_or_default());
            if step < 20 {
                // The drives' position scales, with which the guard starts the network.
                let scale = [0x4b, 0x10, 0x20, 0, 16, 0, 0, 0];
                chip.send(Frame::new(0x580 + drive, &scale).unwrap_or_default());
            }
        }
        // The operator holds the dead-man switch, and requests "stop", then "arm".
        let request = 0x80 | if step > 20 { 1 } else { 2 };
        let command = [50, 0, 10, 0, 0, 0, request, step];
        chip.send(Frame::new(0x200 + GUARD, &command).unwrap_or_default());
        let read = [0x40, 0, 0x10, 0, 0, 0, 0, 0];
        chip.send(Frame::new(0x600 + GUARD, &read).unwrap_or_default());
        chip.send_serial(sentence, 115_200);
        if step == 80 {
            chip.acts(|acts| acts.faults[0] = Some(ChipFault::BusStuck));
        }
        chip.run(10_000);
    }
}

/// Runs the program, whose stack starts at `stack_start`. Returns its nested stack.
fn exercise(chip: &mut Chip, stack_start: u32, run: impl FnOnce(&mut Chip)) -> u32 {
    let nesting = Arc::new(Mutex::new(Nesting {
        running: vec![(0, stack_start)],
        stack_pointer: stack_start,
        deepest: BTreeMap::new(),
    }));
    let watcher = Arc::clone(&nesting);
    chip.watch(move |executed| {
        if let Ok(mut nesting) = watcher.lock() {
            nesting.note(executed);
        }
    });
    run(chip);
    let mut by_priority = BTreeMap::new();
    if let Ok(nesting) = nesting.lock() {
        for (exception, depth) in &nesting.deepest {
            let priority = exception.checked_sub(16).map(|line| chip.priority(line));
            let deepest: &mut u32 = by_priority.entry(priority).or_default();
            *deepest = Ord::max(*deepest, *depth);
        }
    }
    by_priority.values().sum()
}

/// Depth of the stack of the thread and of each exception, with its entry frame.
struct Nesting {
    /// Exceptions that are running, each with the stack pointer before it.
    running: Vec<(u16, u32)>,
    stack_pointer: u32,
    deepest: BTreeMap<u16, u32>,
}

impl Nesting {
    fn note(&mut self, now: Executed) {
        let known = self.running.iter().position(|(it, _)| *it == now.exception);
        if let Some(level) = known {
            self.running.truncate(level + 1);
        } else if now.stack_pointer < self.stack_pointer {
            self.running.push((now.exception, self.stack_pointer));
        } else if let Some(last) = self.running.last_mut() {
            // It follows another one directly, whose entry frame it uses.
            last.0 = now.exception;
        }
        self.stack_pointer = now.stack_pointer;
        if let Some((_, before)) = self.running.last()
            && RAM.contains(&u64::from(now.stack_pointer))
        {
            let deepest = self.deepest.entry(now.exception).or_default();
            *deepest = Ord::max(*deepest, before.saturating_sub(now.stack_pointer));
        }
    }
}
