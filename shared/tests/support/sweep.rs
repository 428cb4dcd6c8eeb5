//! Sweeps that take a minute of both cores: skipped while what they prove is unchanged.

use std::path::Path;
use std::{env, fs};

/// Environment variable with which every sweep runs, whatever its value.
const ALWAYS: &str = "TAUTRACK_SWEEPS";

/// Runs a sweep, unless it has passed with exactly these sources. `sources` are paths below
/// `shared/`; name the code that the sweep proves, and the sweep's own file.
///
/// A passed sweep leaves the text of its sources in the target folder. So a fresh clone runs every
/// sweep once.
pub fn unless_unchanged(name: &str, sources: &[&str], sweep: impl FnOnce()) {
    let passed = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.passed"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let texts = sources.iter().map(|source| {
        let path = root.join(source);
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    });
    run_unless(&passed, &texts.collect::<String>(), sweep);
}

fn run_unless(passed: &Path, text: &str, sweep: impl FnOnce()) {
    let unchanged = fs::read_to_string(passed).is_ok_and(|old| old == text);
    if unchanged && env::var_os(ALWAYS).is_none() {
        println!("skipped: passed with the same sources; {ALWAYS}=1 runs it");
        return;
    }
    // A sweep that fails panics and leaves no text.
    let _ = fs::remove_file(passed);
    sweep();
    fs::write(passed, text).unwrap_or_else(|error| panic!("{}: {error}", passed.display()));
}

#[test]
fn a_sweep_runs_again_after_a_change_and_after_a_failure() {
    let passed = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep_of_a_test.passed");
    let _ = fs::remove_file(&passed);
    let runs = |text: &str| {
        let mut runs = false;
        run_unless(&passed, text, || runs = true);
        runs
    };
    assert!(runs("one"), "never passed");
    assert_eq!(runs("one"), env::var_os(ALWAYS).is_some(), "unchanged");
    assert!(runs("two"), "changed");
    let failed = std::panic::catch_unwind(|| run_unless(&passed, "three", || panic!("fails")));
    assert!(failed.is_err());
    assert!(runs("three"), "failed before");
    assert!(runs("two"), "changed back after a failure");
}
