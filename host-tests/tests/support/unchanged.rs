//! Skips a long run that has passed with the same programs: a run is deterministic.

#[path = "../../../shared/tests/support/sweep.rs"]
mod sweep;

use sha2::{Digest, Sha256};
use std::path::Path;
use std::process::Command;
use std::{env, fs};
use sweep::unless_passed_with;
#[allow(unused_imports)] // not every test program has a campaign
pub use sweep::{cases, complete};
use tautrack_host_tests::programs::setup::QEMU;
use tautrack_host_tests::programs::{Program, Programs, hexadecimal};

/// Runs a test, unless it has passed with the same `programs` (their digests), the same scenarios,
/// the same emulator, and the same executable of the test, which contains the simulator.
pub fn unless_unchanged(
    name: &str,
    programs: impl IntoIterator<Item = String>,
    test: impl FnOnce(),
) {
    let inputs: Vec<_> = programs.into_iter().chain(simulator()).collect();
    unless_passed_with(&inputs.join("\n"), name, test);
}

/// Digest of the program of all nodes.
pub fn nodes(programs: &Programs) -> [String; 1] {
    digests([&programs.nodes])
}

/// Digests of programs.
pub fn digests<const N: usize>(programs: [&Program; N]) -> [String; N] {
    programs.map(|program| program.sha256.clone())
}

/// Digest of these bytes.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Version of the emulator, and digests of this executable and of the scenarios.
fn simulator() -> [String; 3] {
    let executable = fs::read(env::current_exe().expect("an executable")).expect("its bytes");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut scenarios = Sha256::new();
    for file in sweep::files(&folder) {
        scenarios.update(fs::read(file).expect("a scenario"));
    }
    [
        emulator(),
        sha256(&executable),
        hexadecimal(&scenarios.finalize()),
    ]
}

/// What QEMU says of its version.
fn emulator() -> String {
    let output = Command::new(QEMU).arg("--version").output();
    String::from_utf8(output.expect("QEMU starts").stdout).expect("UTF-8")
}
