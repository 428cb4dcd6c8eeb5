//! The command line of `cargo tool settings`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Subcommand)]
pub(in crate::tools) enum Command {
    /// Lists every setting with unit, bounds, default and meaning; needs no bus
    List,
    /// Prints the value of a setting
    Get {
        #[command(flatten)]
        node: Node,
        /// Name of the setting
        name: String,
    },
    /// Changes a setting; prints whether the node uses it at once or after a save and a restart
    Set {
        #[command(flatten)]
        node: Node,
        /// Name of the setting
        name: String,
        /// Value in the unit of the setting
        #[arg(allow_negative_numbers = true)]
        value: i32,
        /// Saves all settings of the node in its flash
        #[arg(long)]
        save: bool,
    },
    /// Writes the settings of all nodes into one file
    Dump {
        #[command(flatten)]
        bus: Bus,
        /// File to write (TOML)
        file: PathBuf,
    },
    /// Writes the settings of a file into the nodes and saves them. A blank node with the serial
    /// number in the file gets its node id first
    Restore {
        #[command(flatten)]
        bus: Bus,
        /// File to read (TOML)
        file: PathBuf,
    },
}

#[derive(Args)]
pub(in crate::tools) struct Bus {
    /// SLCAN adapter: its device, or a TCP address, for instance that of `cargo demo --slcan`
    #[arg(long, value_name = "ADAPTER")]
    pub slcan: String,
}

#[derive(Args)]
pub(in crate::tools) struct Node {
    #[command(flatten)]
    pub bus: Bus,
    /// Node id
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u8).range(1..=127))]
    pub node: u8,
}
