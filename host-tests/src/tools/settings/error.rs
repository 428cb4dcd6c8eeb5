//! Errors of `cargo tool settings`.

use std::path::PathBuf;
use std::{fmt, io};

/// Why the command failed.
#[derive(Debug)]
pub(in crate::tools) enum ToolError {
    /// The adapter cannot be reached, or the connection ended.
    Adapter(String, io::Error),
    /// The node did not answer in time.
    Silent { node: u8, index: u16, sub: u8 },
    /// No LSS answer: no blank node has this serial number.
    NoBlankNode { node: u8, serial: u32 },
    /// The node answered with an SDO abort.
    Aborted {
        node: u8,
        index: u16,
        sub: u8,
        code: u32,
    },
    /// The node refused a node id or did not save it.
    NotConfigured { node: u8, error: u8 },
    /// No setting has this name.
    UnknownSetting(String),
    /// The file cannot be read or written.
    File(PathBuf, io::Error),
    /// The file is no backup of settings.
    NoBackup(PathBuf, toml::de::Error),
    /// The file has an entry that no restore can write.
    BadEntry(PathBuf, String),
    /// The node in the file has another role than that on the bus.
    OtherProduct { node: u8, found: u32, expected: u32 },
    /// No node sends a heartbeat.
    NoNodes,
}

impl fmt::Display for ToolError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Adapter(address, error) => write!(f, "{address}: {error}"),
            Self::Silent { node, index, sub } => {
                write!(
                    f,
                    "node {node} does not answer for object {index:04X}:{sub}"
                )
            }
            Self::NoBlankNode { node, serial } => write!(
                f,
                "neither node {node} nor a blank node with serial number {serial} answers"
            ),
            Self::Aborted {
                node,
                index,
                sub,
                code,
            } => write!(
                f,
                "node {node} refuses object {index:04X}:{sub}: {} ({code:08X})",
                abort_words(*code)
            ),
            Self::NotConfigured { node, error } => {
                write!(f, "a blank node refuses node id {node} (LSS error {error})")
            }
            Self::UnknownSetting(name) => write!(
                f,
                "no setting has the name {name}; `cargo tool settings list` has all"
            ),
            Self::File(path, error) => write!(f, "{}: {error}", path.display()),
            Self::NoBackup(path, error) => write!(f, "{}: {error}", path.display()),
            Self::BadEntry(path, why) => {
                write!(f, "{}: {why}; nothing was written", path.display())
            }
            Self::OtherProduct {
                node,
                found,
                expected,
            } => write!(
                f,
                "node {node} has product code {found}, and in the file {expected}; \
                 nothing was written"
            ),
            Self::NoNodes => write!(f, "no node sends a heartbeat"),
        }
    }
}

/// What an abort code means for settings.
fn abort_words(code: u32) -> &'static str {
    match code {
        0x0602_0000 => "it has no such object; its program has another table of settings",
        0x0609_0031 => "the value is above the maximum",
        0x0609_0032 => "the value is below the minimum",
        0x0800_0022 => "its motor has current, or the robot is armed; disarm first",
        0x0604_0043 => "it would not start with these settings",
        0x0606_0000 => "its flash failed",
        0x0800_0020 => "its program cannot save settings",
        _ => "SDO abort",
    }
}
