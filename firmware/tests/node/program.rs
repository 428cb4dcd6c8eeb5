//! Path of the node program.

use std::path::PathBuf;
use std::sync::OnceLock;
use tautrack_setup::build::{emulated, folder_of};

/// The program of all roles for the emulated board. The whole runs of the robot use the same, so
/// that it is built once.
pub fn elf() -> PathBuf {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| {
        let folder = folder_of(&emulated("mps2"), &["guard"]);
        folder
            .unwrap_or_else(|error| panic!("{error}"))
            .join("guard")
    })
    .clone()
}
