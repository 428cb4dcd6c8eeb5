//! The command line of `cargo flash-node`.

use super::probe::{self, Part};
use super::settings;
use super::{faults, option_bytes};
use crate::programs::flash::{self, Segment};
use crate::programs::settings_pages::{self, Pages};
use crate::programs::{guard_board, motor_board};
use crate::robots::Kind;
use clap::{Parser, ValueEnum};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tautrack::motor::board_limits::Limit;
use tautrack::settings::Effect;

/// Program of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(super) enum Role {
    /// A node that follows set-points from the bus.
    Axle,
    /// The node of the driving screw.
    Screw,
    /// The guard of the robot in --robot, or of the default one.
    Guard,
}

impl Role {
    pub fn name(self) -> &'static str {
        match self {
            Self::Axle => "axle",
            Self::Screw => "screw",
            Self::Guard => "guard",
        }
    }

    /// Bounds and defaults of the board.
    pub fn limits(self) -> &'static [Limit] {
        match self {
            Self::Axle | Self::Screw => &settings_pages::motor_board::LIMITS,
            Self::Guard => &[],
        }
    }

    /// Name of the board's chip in probe-rs, and the bytes of its RAM.
    fn chip(self) -> (&'static str, usize) {
        match self {
            Self::Axle | Self::Screw => (probe::MOTOR_BOARD, 32 * 1024),
            Self::Guard => (probe::GUARD_BOARD, 96 * 1024),
        }
    }

    /// Product code of the program's object dictionary (`shared/dictionary`).
    pub fn product_code(self) -> u32 {
        match self {
            Self::Axle => 1,
            Self::Screw => 2,
            Self::Guard => 3,
        }
    }
}

/// Prints the last faults of a board. Then builds its program and flashes it, and settings if any
/// are given. A motor board also gets the loader.
#[derive(Parser)]
#[command(name = "cargo flash-node")]
pub(super) struct Arguments {
    /// Program of the node.
    pub role: Role,
    /// Write the settings that this robot's node has, which --node-id names. Without --node-id, a
    /// guard gets the program of this robot and keeps its settings.
    #[arg(long)]
    pub robot: Option<Kind>,
    /// Write this node id.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=127))]
    pub node_id: Option<u8>,
    /// Write the settings in FILE: lines `name = value`, or a dump, of which those of --node-id.
    /// They replace those of the robot.
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Make a motor board's chip start its flash memory whatever its boot pin says.
    #[arg(long)]
    pub set_option_bytes: bool,
    /// Print the last faults of the connected board, and flash nothing.
    #[arg(long, conflicts_with = "dry_run")]
    pub faults: bool,
    /// Print what would be flashed, and the commands, without a probe.
    #[arg(long)]
    pub dry_run: bool,
}

/// Runs the command. The first of `arguments` is the program's name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match command(&Arguments::parse_from(arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo flash-node: {error}");
            ExitCode::FAILURE
        }
    }
}

fn command(arguments: &Arguments) -> Result<(), String> {
    let settings = settings::collect(arguments)?;
    if !arguments.dry_run {
        probe::check()?;
        // Flashing overwrites the RAM.
        let (chip, ram) = arguments.role.chip();
        let log = faults::of_board(chip, ram / 4);
        if arguments.faults {
            print!("{}", log?);
            return Ok(());
        }
        // A chip that is protected or new gives no log, and is flashed nevertheless.
        print!(
            "{}",
            log.unwrap_or_else(|why| format!("fault log: {why}\n"))
        );
        if arguments.role != Role::Guard {
            option_bytes::look(arguments.set_option_bytes)?;
        }
    }
    let mut board = match arguments.role {
        Role::Axle | Role::Screw => motor(arguments.role)?,
        Role::Guard => guard(arguments.robot.unwrap_or_default())?,
    };
    if !settings.is_empty() {
        let mut pages = Pages::erased();
        pages.save_on(arguments.role.limits(), &settings)?;
        let path = board.program.with_extension("settings.bin");
        write(&path, &pages.0)?;
        println!("settings: {}", path.display());
        let (address, length) = (board.settings, settings_pages::LENGTH);
        println!("  {address:#010x} {length:>6} bytes");
        for (setting, value) in &settings {
            let row = setting.description();
            println!("  {} = {value} {}{}", row.name, row.unit, live(row.effect));
        }
        board.parts.push(Part::Bytes(path, address));
    }
    probe::flash(board.chip, &board.parts, arguments.dry_run)
}

/// Marks a setting that a client may change without a restart.
fn live(effect: Effect) -> &'static str {
    match effect {
        Effect::Restart => "",
        Effect::Gain | Effect::Limit => "  (a running drive takes a new value at once)",
        Effect::Disarmed => "  (a drive that is not armed takes a new value at once)",
    }
}

/// What is written to a board.
struct Board {
    /// Name of the chip in probe-rs.
    chip: &'static str,
    /// The programs.
    parts: Vec<Part>,
    /// Path of the program of the node.
    program: PathBuf,
    /// Address of the settings pages.
    settings: u32,
}

/// Builds loader and application of a motor board.
fn motor(role: Role) -> Result<Board, String> {
    let programs = motor_board().map_err(|error| error.to_string())?;
    let application = match role {
        Role::Screw => programs.screw,
        Role::Axle | Role::Guard => programs.axle,
    };
    let loader = read(&programs.loader.path)?;
    let sealed = read(&application.path)
        .and_then(|elf| flash::sealed(elf).map_err(|error| error.to_string()))?;
    let sealed_path = application.path.with_extension("sealed.elf");
    write(&sealed_path, &sealed)?;

    print("loader", &programs.loader.path, &segments(&loader)?);
    print("application", &sealed_path, &segments(&sealed)?);
    Ok(Board {
        chip: probe::MOTOR_BOARD,
        parts: vec![Part::Elf(programs.loader.path), Part::Elf(sealed_path)],
        program: application.path,
        settings: settings_pages::ADDRESS,
    })
}

/// Builds the guard of a robot. The chip starts it without a loader.
fn guard(robot: Kind) -> Result<Board, String> {
    let programs = guard_board(&[robot.facts().guard_program]);
    let program = programs
        .map_err(|error| error.to_string())?
        .pop()
        .ok_or("no program was built")?;
    print("program", &program.path, &segments(&read(&program.path)?)?);
    Ok(Board {
        chip: probe::GUARD_BOARD,
        parts: vec![Part::Elf(program.path.clone())],
        program: program.path,
        settings: settings_pages::GUARD_ADDRESS,
    })
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

fn segments(elf: &[u8]) -> Result<Vec<Segment>, String> {
    flash::segments(elf).map_err(|error| error.to_string())
}

fn print(what: &str, path: &Path, segments: &[Segment]) {
    println!("{what}: {}", path.display());
    for segment in segments {
        println!(
            "  {:#010x} {:>6} bytes",
            segment.address,
            segment.bytes.len()
        );
    }
}
