//! Tests that the bytes of a program do not depend on where it is built.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use tautrack_host_tests::programs::setup::checkout::root;
use tautrack_host_tests::programs::{Board, build, motor_board};

/// Begins each line of [`hashes`].
const MARK: &str = "program ";

/// Builds programs with both profiles of the nodes and prints their hashes.
#[test]
#[ignore = "a part of the other test, which runs it in a copy of the checkout"]
fn hashes() {
    let motor_board = motor_board().unwrap_or_else(|error| panic!("{error}"));
    let emulated = build(Board::Qemu, "guard").unwrap_or_else(|error| panic!("{error}"));
    for (name, program) in [
        ("emulated nodes", &emulated.nodes),
        ("loader of the motor board", &motor_board.loader),
        ("axle of the motor board", &motor_board.axle),
    ] {
        println!("{MARK}{name}: {}", program.sha256);
    }
}

/// Runs [`hashes`] in the checkout that contains `package`, with the folders of the environment
/// `homes`. Returns its lines.
fn lines(package: &Path, homes: &[(&str, &Path)]) -> Vec<String> {
    let output = Command::new(env::current_exe().expect("a test program"))
        .args(["--ignored", "--exact", "hashes", "--nocapture"])
        .current_dir(package)
        .env("CARGO_MANIFEST_DIR", package)
        .envs(homes.iter().copied())
        .output()
        .expect("a test program starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{errors}");
    let marked = text.lines().filter(|line| line.starts_with(MARK));
    marked.map(str::to_owned).collect()
}

/// Folder that is removed with its value.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // It is only disk space.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Copies every file of the checkout that git does not ignore to `copy`.
fn copy_checkout(copy: &Path) -> Result<(), Box<dyn Error>> {
    let root = root()?;
    let listed = Command::new("git")
        .args([
            "ls-files",
            "-z",
            "--cached",
            "--others",
            "--exclude-standard",
        ])
        .current_dir(root)
        .output()?;
    let listed = String::from_utf8(listed.stdout)?;
    for name in listed.split_terminator('\0') {
        let (from, to) = (root.join(name), copy.join(name));
        if from.exists() {
            fs::create_dir_all(to.parent().ok_or("a file has a folder")?)?;
            fs::copy(from, to)?;
        }
    }
    Ok(())
}

/// Makes `home` a home of cargo that shares the downloaded packages with the present one.
fn share_packages(home: &Path) -> Result<(), Box<dyn Error>> {
    let user = env::home_dir().ok_or("no home")?;
    let present = env::var_os("CARGO_HOME").map_or(user.join(".cargo"), PathBuf::from);
    fs::create_dir_all(home)?;
    for name in ["registry", "config.toml"] {
        let shared = present.join(name);
        if shared.exists() {
            std::os::unix::fs::symlink(shared.canonicalize()?, home.join(name))?;
        }
    }
    Ok(())
}

#[test]
#[ignore = "builds programs a second time: minutes of one processor; .ci/run runs it"]
fn programs_do_not_depend_on_the_folder_or_the_home() -> Result<(), Box<dyn Error>> {
    let name = format!(
        "tautrack-copy-in-a-folder-with-a-long-name-{}",
        std::process::id()
    );
    let folder = Temporary(env::temp_dir().join(name));
    let (copy, home) = (folder.0.join("a/b/c/checkout"), folder.0.join("home"));
    copy_checkout(&copy)?;
    share_packages(&home.join("of-cargo"))?;
    let user = env::home_dir().ok_or("no home")?;
    let rustup = env::var_os("RUSTUP_HOME").map_or(user.join(".rustup"), PathBuf::from);

    let here = lines(&root()?.join("host-tests"), &[]);
    let there = lines(
        &copy.join("host-tests"),
        &[
            ("HOME", &home),
            ("CARGO_HOME", &home.join("of-cargo")),
            ("RUSTUP_HOME", &rustup),
        ],
    );
    println!("{here:#?}");
    assert_eq!(here.len(), 3);
    assert_eq!(here, there);
    Ok(())
}
