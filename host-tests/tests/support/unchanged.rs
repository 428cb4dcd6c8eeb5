//! Skips a long run that has passed with the same programs: a run is deterministic.

#[path = "../../../shared/tests/support/sweep.rs"]
mod sweep;

use sha2::{Digest, Sha256};
use std::path::Path;
use std::process::Command;
use std::{env, fs};
pub use sweep::Stamp;
use sweep::stamp;
#[allow(unused_imports)] // not every test program has a campaign
pub use sweep::{cases, complete};
use tautrack_host_tests::programs::setup::QEMU;
use tautrack_host_tests::programs::{Program, Programs, hexadecimal};

/// Runs a test, unless it has passed with the same inputs, see [`stamp_of_runs`].
#[allow(dead_code)] // not every test program has such a test
pub fn unless_unchanged(
    name: &str,
    programs: impl IntoIterator<Item = String>,
    test: impl FnOnce(),
) {
    if let Some(_stamp) = stamp_of_runs(name, programs) {
        test();
    }
}

/// Stamp of a test of runs: its inputs are those of [`stamp_of_programs`] and the emulator.
#[allow(dead_code)] // not every test program has such a test
pub fn stamp_of_runs(name: &str, programs: impl IntoIterator<Item = String>) -> Option<Stamp> {
    stamp_of_programs(name, programs.into_iter().chain([emulator()]))
}

/// Stamp of a test whose inputs are these `programs` (their digests), the scenarios, and the
/// executable of the test, which contains the simulator. See [`sweep::stamp`].
pub fn stamp_of_programs(name: &str, programs: impl IntoIterator<Item = String>) -> Option<Stamp> {
    let executable = fs::read(env::current_exe().expect("an executable")).expect("its bytes");
    let others = [sha256(&executable), scenarios()];
    let inputs: Vec<_> = programs.into_iter().chain(others).collect();
    stamp(&inputs.join("\n"), name)
}

/// Digest of the program of all nodes.
#[allow(dead_code)] // not every test program has such a test
pub fn nodes(programs: &Programs) -> [String; 1] {
    digests([&programs.nodes])
}

/// Digests of programs.
#[allow(dead_code)] // not every test program has such a test
pub fn digests<const N: usize>(programs: [&Program; N]) -> [String; N] {
    programs.map(|program| program.sha256.clone())
}

/// Digest of these bytes.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Digest of the scenarios.
fn scenarios() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut scenarios = Sha256::new();
    for file in sweep::files(&folder) {
        scenarios.update(fs::read(file).expect("a scenario"));
    }
    hexadecimal(&scenarios.finalize())
}

/// What QEMU says of its version.
fn emulator() -> String {
    let output = Command::new(QEMU).arg("--version").output();
    String::from_utf8(output.expect("QEMU starts").stdout).expect("UTF-8")
}
