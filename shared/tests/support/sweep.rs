//! Long tests: which run completely, and which are skipped while what they prove is unchanged.

use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::thread::panicking;
use std::{env, fs};

/// Environment variable with which every test runs completely, whatever its value.
const ALWAYS: &str = "TAUTRACK_SWEEPS";

/// Whether the user requests complete campaigns. Without that, a campaign is only long enough to
/// show that it works.
#[allow(dead_code)] // not every test program has a campaign
pub fn complete() -> bool {
    env::var_os(ALWAYS).is_some()
}

/// Number of random cases: `all` of them in a complete campaign, else a fifth.
#[allow(dead_code)] // not every test program has a campaign
pub fn cases(all: usize) -> usize {
    if complete() { all } else { all / 5 }
}

/// Runs a sweep, unless it has passed with exactly these sources. `sources` are files and folders
/// below `shared/`; name the code that the sweep proves, and the sweep's own.
#[allow(dead_code)] // the tests of whole runs have programs instead of sources
pub fn unless_unchanged(name: &str, sources: &[&str], sweep: impl FnOnce()) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = sources.iter().flat_map(|source| files(&root.join(source)));
    let texts = files.map(|path| {
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    });
    unless_passed_with(&texts.collect::<String>(), name, sweep);
}

/// Stamp of a test whose inputs are this executable alone: it contains the code that is tested, the
/// test with what it draws and expects, and the work of the compiler. See [`stamp`].
#[allow(dead_code)] // not every test program has such a test
pub fn stamp_of_executable(name: &str) -> Option<Stamp> {
    let mut digest = DefaultHasher::new();
    digest.write(&fs::read(env::current_exe().expect("an executable")).expect("its bytes"));
    let name = format!("{}-{name}", env!("CARGO_CRATE_NAME"));
    stamp(&format!("{:016x}", digest.finish()), &name)
}

/// The file, or all files below the folder, in the order of their paths.
pub fn files(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut places: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    places.sort();
    places.iter().flat_map(|place| files(place)).collect()
}

/// Runs a test, unless it has passed with the same `inputs`, see [`stamp`].
pub fn unless_passed_with(inputs: &str, name: &str, test: impl FnOnce()) {
    if let Some(_stamp) = stamp(inputs, name) {
        test();
    }
}

/// Returns the stamp of a test that must run; `None` if it has passed with the same `inputs`: texts
/// or digests of everything that its result depends on. The settings of the property tests, which
/// are in the environment, are added to them.
///
/// A test that has passed leaves its inputs in the target folder. So a fresh clone runs it once.
pub fn stamp(inputs: &str, name: &str) -> Option<Stamp> {
    let passed = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.passed"));
    let inputs = format!("{inputs}\n{}", settings_of_property_tests());
    let unchanged = fs::read_to_string(&passed).is_ok_and(|old| old == inputs);
    if unchanged && !complete() {
        println!("{name} is skipped: it passed with the same inputs; {ALWAYS}=1 runs it");
        return None;
    }
    let _ = fs::remove_file(&passed);
    let passed = Some(passed);
    Some(Stamp { passed, inputs })
}

/// Notes when it is dropped that a test has passed, unless the test panics. The test must not fail
/// by its result.
#[derive(Default)]
pub struct Stamp {
    /// File of the inputs; `None` for a test that runs each time.
    passed: Option<PathBuf>,
    inputs: String,
}

impl Drop for Stamp {
    fn drop(&mut self) {
        if let Some(passed) = self.passed.as_ref().filter(|_| !panicking()) {
            fs::write(passed, &self.inputs)
                .unwrap_or_else(|error| panic!("{}: {error}", passed.display()));
        }
    }
}

/// The environment variables that choose inputs of property tests, or their number.
fn settings_of_property_tests() -> String {
    let all = env::vars_os().map(|(name, value)| format!("{}={}", name.display(), value.display()));
    let mut all: Vec<_> = all.filter(|text| text.starts_with("PROPTEST_")).collect();
    all.sort();
    all.join("\n")
}

#[test]
fn a_sweep_runs_again_after_a_change_and_after_a_failure() {
    // Each test program has this test.
    let name = concat!(env!("CARGO_CRATE_NAME"), "-sweep-of-a-test");
    let passed = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.passed"));
    let _ = fs::remove_file(&passed);
    let runs = |text: &str| {
        let mut runs = false;
        unless_passed_with(text, name, || runs = true);
        runs
    };
    assert!(runs("one"), "never passed");
    let inputs = fs::read_to_string(&passed).expect("the inputs");
    let seed = env::var("PROPTEST_RNG_SEED").expect("set by .cargo/config.toml");
    assert!(
        inputs.contains(&format!("PROPTEST_RNG_SEED={seed}")),
        "{inputs}"
    );
    assert_eq!(runs("one"), complete(), "unchanged");
    assert!(runs("two"), "changed");
    let failed = std::panic::catch_unwind(|| unless_passed_with("three", name, || panic!("fails")));
    assert!(failed.is_err());
    assert!(runs("three"), "failed before");
    assert!(runs("two"), "changed back after a failure");
}
