//! Paths of the node programs.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// All roles, with the native program of each.
pub const ROLES: [(&str, &str); 3] = [
    ("axle", env!("CARGO_BIN_EXE_axle")),
    ("screw", env!("CARGO_BIN_EXE_screw")),
    ("guard", env!("CARGO_BIN_EXE_guard")),
];

/// Returns the program of `role` for the emulated board; builds all programs once per run of a test
/// program.
pub fn elf(role: &str) -> PathBuf {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY
        .get_or_init(|| {
            let root = Path::new(env!("CARGO_MANIFEST_DIR"))
                .parent()
                .expect("the crate is in the workspace");
            let target = Path::new(env!("CARGO_TARGET_TMPDIR"))
                .parent()
                .expect("it is below target")
                .join("nodes");
            let status = Command::new(env!("CARGO"))
                .current_dir(root)
                .args([
                    "build",
                    "--package",
                    "tautrack-firmware",
                    "--target",
                    "thumbv7em-none-eabihf",
                ])
                .args([
                    "--features",
                    "mps2",
                    "--profile",
                    "firmware",
                    "--target-dir",
                ])
                .arg(&target)
                .status()
                .expect("cargo starts");
            assert!(
                status.success(),
                "the nodes do not build for the board: rustup target add thumbv7em-none-eabihf?"
            );
            target.join("thumbv7em-none-eabihf/firmware")
        })
        .join(role)
}
