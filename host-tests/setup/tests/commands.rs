//! Tests the commands of `.cargo/config.toml`: each names what it lacks before anything else is
//! compiled, and otherwise is replaced by its program.

use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tautrack_setup::Part::{self, PageTarget, ProbeRs, Qemu, Sources, Target};
use tautrack_setup::commands::{COMMANDS, Command as Row};
use tautrack_setup::plan::RUSTUP;

/// Tools whose place a stub takes that always fails.
const ABSENT: [&str; 3] = ["rustup", "qemu-system-arm", "probe-rs"];

/// A compiler with the libraries of other targets in `$LIBRARIES` and without sources. It writes
/// the names of the crates that it compiles to `$COMPILED`, and compiles only this package.
const COMPILER: &str = r#"#!/bin/sh
case "$1 $2" in
"--print target-libdir") echo "$LIBRARIES"; exit 0 ;;
"--print sysroot") echo /nowhere; exit 0 ;;
esac
previous=
for word in "$@"; do
    if [ "$previous" = --crate-name ] && [ "$word" != ___ ]; then
        echo "$word" >>"$COMPILED"
        [ "$word" = tautrack_setup ] || exit 1
    fi
    previous=$word
done
exec rustc "$@"
"#;

fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).expect("a checkout").to_owned()
}

/// Empty folder of one test.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder");
    path
}

fn script(path: &Path, text: &str) {
    fs::write(path, text).expect("a script");
    fs::set_permissions(path, PermissionsExt::from_mode(0o755)).expect("executable");
}

/// The aliases of cargo and their texts.
fn aliases() -> toml::Table {
    let text = fs::read_to_string(root().join(".cargo/config.toml")).expect("a file");
    let config: toml::Table = text.parse().expect("TOML");
    config["alias"].as_table().expect("aliases").clone()
}

fn row(name: &str) -> &'static Row {
    Row::find(name.as_ref()).unwrap_or_else(|| panic!("{name} is not in the table"))
}

#[test]
fn every_alias_starts_its_row_of_the_table() {
    let aliases = aliases();
    for (name, text) in &aliases {
        let through_the_table = format!("run --quiet -p tautrack-setup -- {name}");
        assert_eq!(text.as_str(), Some(through_the_table.as_str()), "{name}");
        let program = row(name).program;
        let source = format!("host-tests/src/bin/{program}.rs");
        assert!(root().join(&source).exists(), "{name}: no {source}");
    }
    assert_eq!(aliases.len(), COMMANDS.len());
}

#[test]
fn the_arguments_decide_what_a_command_needs() {
    let needs = |line: &str| {
        let mut words = line.split(' ').map(OsString::from);
        let row = row(words.next().unwrap().to_str().unwrap());
        row.needs(&words.collect::<Vec<_>>())
    };
    let table: [(&str, &[Part]); 19] = [
        ("demo", &[Target, Qemu]),
        ("demo --nodes qemu --robot hylos", &[Target, Qemu]),
        ("demo --nodes host", &[]),
        ("demo --nodes=host", &[]),
        ("demo --suite hazards", &[]),
        ("demo --page", &[PageTarget]),
        ("demo --compare", &[]),
        ("demo --help", &[]),
        ("demo-image --image guard", &[Target, Sources, Qemu]),
        ("demo-image --nodes host --image=all", &[Target, Sources]),
        ("generate", &[]),
        ("evaluate -", &[]),
        ("cost", &[Target, Qemu]),
        ("footprint", &[Target, Sources]),
        ("tool settings list", &[]),
        ("flash-node axle", &[ProbeRs, Target, Sources]),
        ("flash-node axle --dry-run", &[Target, Sources]),
        ("flash-node guard", &[ProbeRs, Target]),
        ("flash-node -h", &[]),
    ];
    for (line, expected) in table {
        let mut found = needs(line);
        found.sort_by_key(|part| *part as u8);
        let mut expected = expected.to_vec();
        expected.sort_by_key(|part| *part as u8);
        assert_eq!(found, expected, "{line}");
    }
}

/// Types `cargo` and this line on a computer that lacks everything but a compiler for itself, and
/// for other targets if `libraries` contains their library. Returns the output and the names of the
/// crates that were compiled.
fn on_a_bare_computer(stubs: &Path, libraries: &str, line: &str) -> (Output, String) {
    let compiled = stubs.join("compiled");
    fs::write(&compiled, "").expect("a file");
    let path = std::env::var("PATH").expect("a path");
    let output = Command::new(env!("CARGO"))
        .args(line.split(' '))
        .current_dir(root())
        .env("CARGO_TARGET_DIR", stubs.join("target"))
        .env("RUSTC", stubs.join("compiler"))
        .env("LIBRARIES", stubs.join(libraries))
        .env("COMPILED", &compiled)
        .env("PATH", format!("{}:{path}", stubs.display()))
        .env("TAUTRACK_NO_SETUP", "1")
        .stdin(Stdio::null())
        .output()
        .expect("cargo starts");
    let compiled = fs::read_to_string(compiled).expect("names");
    (output, compiled)
}

#[test]
fn every_command_names_what_is_missing_in_one_line_before_it_compiles() {
    let stubs = folder("bare-computer");
    script(&stubs.join("compiler"), COMPILER);
    for tool in ABSENT {
        script(&stubs.join(tool), "#!/bin/sh\nexit 1\n");
    }
    for libraries in ["none", "installed"] {
        fs::create_dir(stubs.join(libraries)).expect("a folder");
    }
    fs::write(stubs.join("installed/libcore-0.rlib"), "").expect("a library");

    let target = "rustup target add thumbv7em-none-eabihf";
    let sources = "rustup component add rust-src";
    let qemu = "sudo apt-get install qemu-system-arm";
    let probe_rs = "cargo install probe-rs-tools";
    let lines = [
        ("demo", "none", target),
        ("demo", "installed", qemu),
        ("demo-image", "installed", qemu),
        ("demo-image --nodes host --image all", "installed", sources),
        ("cost", "none", target),
        ("cost", "installed", qemu),
        ("footprint", "installed", sources),
        ("flash-node axle --dry-run", "installed", sources),
        ("flash-node guard", "installed", probe_rs),
    ];
    for (line, libraries, to_type) in lines {
        let (output, compiled) = on_a_bare_computer(&stubs, libraries, line);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {error}");
        assert_eq!(error.lines().count(), 1, "{line}: {error}");
        assert!(
            error.contains(&format!("type: {to_type}")),
            "{line}: {error}"
        );
        assert!(output.stdout.is_empty(), "{line}: {:?}", output.stdout);
        let only_this_package = compiled.lines().all(|name| name == "tautrack_setup");
        assert!(only_this_package, "{line} compiles {compiled}");
    }
    let named = |name: &str| {
        lines
            .iter()
            .any(|(line, ..)| line.split(' ').next() == Some(name))
    };
    for row in COMMANDS {
        let needs_nothing = row.needs(&[]).is_empty();
        assert!(
            needs_nothing || named(row.name),
            "{} is not tried",
            row.name
        );
    }
}

#[test]
fn a_command_is_replaced_by_its_program_with_its_arguments_streams_and_status() {
    let stubs = folder("stub-cargo");
    let cargo = stubs.join("cargo");
    let says = "#!/bin/sh\necho $$\nfor word; do echo \"[$word]\"; done\n\
                echo \"${CARGO_PKG_NAME-none} ${CARGO_MANIFEST_DIR-none}\"\ncat\nexit 7\n";
    script(&cargo, says);
    let mut program = Command::new(env!("CARGO_BIN_EXE_tautrack-setup"))
        .args(["evaluate", "two words", "--", ""])
        .env("CARGO", &cargo)
        .env("CARGO_PKG_NAME", "tautrack-setup")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let process = program.id();
    let mut input = program.stdin.take().expect("a pipe");
    input.write_all(b"input\n").expect("written");
    drop(input);
    let output = program.wait_with_output().expect("it ends");
    // The same process: signals and the terminal reach the program itself.
    let expected = format!(
        "{process}\n[run]\n[--quiet]\n[--package]\n[tautrack-host-tests]\n[--bin]\n[evaluate]\n\
         [--]\n[two words]\n[--]\n[]\nnone none\ninput\n"
    );
    assert_eq!(String::from_utf8_lossy(&output.stdout), expected);
    assert!(output.stderr.is_empty(), "{:?}", output.stderr);
    assert_eq!(output.status.code(), Some(7));
}

#[test]
fn the_check_of_everything_names_what_is_missing_before_it_starts() {
    let tools = folder("no-tools");
    let output = Command::new("/bin/bash")
        .arg(root().join(".ci/run"))
        .env("PATH", &tools)
        .output()
        .expect("bash starts");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let error = String::from_utf8_lossy(&output.stderr);
    let command = format!("type: {RUSTUP}");
    assert!(
        error.contains("cargo") && error.contains(&command),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{:?}", output.stdout);
}
