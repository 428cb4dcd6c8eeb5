//! The commands of `.cargo/config.toml`: the programs that they start, and what these need.

use super::Part;
use std::convert::Infallible;
use std::ffi::{OsStr, OsString};
use std::os::unix::process::CommandExt;
use std::{env, io, process};

/// One command.
pub struct Command {
    /// Name of the alias.
    pub name: &'static str,
    /// The program of `tautrack-host-tests`.
    pub program: &'static str,
    /// Feature with which the program is built; empty for none.
    feature: &'static str,
    /// Whether cargo shows what it compiles.
    shows_build: bool,
    /// What the program needs with these arguments.
    needs: fn(&[OsString]) -> Vec<Part>,
}

/// A command that needs nothing and shows no build.
const PLAIN: Command = Command {
    name: "",
    program: "",
    feature: "",
    shows_build: false,
    needs: |_| Vec::new(),
};

/// All commands.
pub const COMMANDS: [Command; 8] = [
    Command {
        name: "demo",
        program: "demo",
        shows_build: true,
        needs: demo,
        ..PLAIN
    },
    Command {
        name: "demo-image",
        program: "demo",
        feature: "image",
        shows_build: true,
        needs: demo,
    },
    Command {
        name: "generate",
        program: "generate",
        ..PLAIN
    },
    Command {
        name: "evaluate",
        program: "evaluate",
        ..PLAIN
    },
    Command {
        name: "cost",
        program: "cost",
        shows_build: true,
        needs: |_| vec![Part::Target, Part::Qemu],
        ..PLAIN
    },
    Command {
        name: "footprint",
        program: "footprint",
        feature: "image",
        needs: |_| vec![Part::Target, Part::Sources],
        ..PLAIN
    },
    Command {
        name: "tool",
        program: "tool",
        ..PLAIN
    },
    Command {
        name: "flash-node",
        program: "flash_node",
        needs: flash_node,
        ..PLAIN
    },
];

impl Command {
    /// Returns the command with this name.
    pub fn find(name: &OsStr) -> Option<&'static Self> {
        COMMANDS.iter().find(|command| name == command.name)
    }

    /// Returns what the program needs with these arguments. A help text needs nothing.
    pub fn needs(&self, arguments: &[OsString]) -> Vec<Part> {
        if ["--help", "-h", "--version", "-V"]
            .iter()
            .any(|option| has(arguments, option))
        {
            return Vec::new();
        }
        (self.needs)(arguments)
    }

    /// Replaces this process by cargo, which builds the program and replaces itself by it.
    ///
    /// # Errors
    /// cargo does not start.
    pub fn start(&self, arguments: &[OsString]) -> io::Result<Infallible> {
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = process::Command::new(cargo);
        // What `cargo run` set for this program is not for the next one.
        for (name, _) in env::vars_os() {
            let name = name.to_string_lossy();
            if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") {
                command.env_remove(&*name);
            }
        }
        command.arg("run");
        if !self.shows_build {
            command.arg("--quiet");
        }
        command.args(["--package", "tautrack-host-tests", "--bin", self.program]);
        if !self.feature.is_empty() {
            command.args(["--features", self.feature]);
        }
        Err(command.arg("--").args(arguments).exec())
    }
}

/// What `cargo demo` needs: the kinds of its nodes decide.
fn demo(arguments: &[OsString]) -> Vec<Part> {
    let page = has(arguments, "--page");
    // None of these has emulated nodes.
    let host = value(arguments, "--nodes") == Some("host".as_ref())
        || has(arguments, "--suite")
        || has(arguments, "--compare")
        || page;
    let emulated = !host;
    let images = has(arguments, "--image");
    let parts = [
        (Part::Target, emulated || images),
        (Part::PageTarget, page),
        (Part::Sources, images),
        (Part::Qemu, emulated),
    ];
    let needed = parts.into_iter().filter(|(_, needed)| *needed);
    needed.map(|(part, _)| part).collect()
}

/// What `cargo flash-node` needs. The guard's image uses the library of the target as it is.
fn flash_node(arguments: &[OsString]) -> Vec<Part> {
    let dry = has(arguments, "--dry-run");
    let guard = arguments.iter().any(|argument| argument == "guard");
    let parts = [
        (Part::ProbeRs, !dry),
        (Part::Target, true),
        (Part::Sources, !guard),
    ];
    let needed = parts.into_iter().filter(|(_, needed)| *needed);
    needed.map(|(part, _)| part).collect()
}

/// Whether `option` is among the arguments, with or without `=` and a value.
fn has(arguments: &[OsString], option: &str) -> bool {
    let mut names = arguments.iter().map(|argument| name_and_value(argument).0);
    names.any(|name| name == option)
}

/// The value of `option`, which follows it or its `=`.
fn value<'a>(arguments: &'a [OsString], option: &str) -> Option<&'a OsStr> {
    let place = arguments
        .iter()
        .position(|argument| name_and_value(argument).0 == option)?;
    let (_, value) = name_and_value(&arguments[place]);
    value.or_else(|| arguments.get(place + 1).map(OsString::as_os_str))
}

/// Splits `--name=value`.
fn name_and_value(argument: &OsStr) -> (&str, Option<&OsStr>) {
    match argument.to_str() {
        Some(text) => match text.split_once('=') {
            Some((name, value)) => (name, Some(value.as_ref())),
            None => (text, None),
        },
        // Options and their fixed values are ASCII.
        None => ("", None),
    }
}
