//! Tests that a program works on the checkout that it is started in.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Makes a folder that looks like a checkout, whose default scenario is bad and contains `name`.
fn checkout_in(parent: &Path, name: &str) -> PathBuf {
    let root = parent.join(name);
    fs::create_dir_all(root.join("shared/dictionary")).unwrap();
    fs::create_dir_all(root.join("host-tests/scenarios")).unwrap();
    fs::write(root.join("Cargo.toml"), "").unwrap();
    let scenario = root.join("host-tests/scenarios/staircase.toml");
    fs::write(scenario, format!("name = \"{name}\"\n")).unwrap();
    root.canonicalize().unwrap()
}

/// Runs the demo in `folder`, with cargo's variable for the package if given, and returns its
/// error.
fn error_in(program: &Path, folder: &Path, package: Option<&Path>) -> String {
    let mut command = Command::new(program);
    command.current_dir(folder).env_remove("CARGO_MANIFEST_DIR");
    if let Some(package) = package {
        command.env("CARGO_MANIFEST_DIR", package);
    }
    let output = command.output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    error
}

#[test]
fn a_copied_checkout_reads_its_own_scenarios() {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR")).join("copies");
    let [mine, other] = ["mine", "other"].map(|name| checkout_in(&parent, name));
    let demo = Path::new(env!("CARGO_BIN_EXE_demo"));
    let names = |error: &str, root: &Path| error.contains(&root.display().to_string());
    let error = error_in(demo, &mine, None);
    assert!(names(&error, &mine), "{error}");
    // If cargo starts the program, the checkout is the one of the package, in any working
    // directory.
    let error = error_in(demo, &mine, Some(&other.join("host-tests")));
    assert!(names(&error, &other), "{error}");
}

#[test]
fn without_a_checkout_the_error_says_where_it_was_looked_for() {
    let folder = std::env::temp_dir().join(format!("tautrack-nowhere-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let demo = folder.join("demo");
    fs::copy(env!("CARGO_BIN_EXE_demo"), &demo).unwrap();
    let error = error_in(&demo, &folder, None);
    fs::remove_dir_all(&folder).unwrap();
    assert!(error.contains("no tautrack checkout"), "{error}");
    assert!(error.contains("tautrack-nowhere"), "{error}");
}
