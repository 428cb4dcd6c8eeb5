//! Follows docs/adding-a-robot.md exactly: adds a cart to a copy of the workspace and runs it.
//!
//! `cart/new` has the cart's files at their places in the workspace, `cart/lines.toml` its lines in
//! existing files. Both are data of this test and are compiled only in the copy.

use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tautrack_host_tests::programs::setup::checkout;

/// Contents of files by their paths from the root of a workspace.
type Files = BTreeMap<String, Vec<u8>>;

/// The content of `cart/lines.toml`.
#[derive(Deserialize)]
struct Lines {
    line: Vec<Line>,
}

/// Text that is added to an existing file.
#[derive(Deserialize)]
struct Line {
    file: String,
    /// The line after which the text is added; without it the text is added at the end.
    after: Option<String>,
    text: String,
}

fn root() -> &'static Path {
    checkout::root().unwrap_or_else(|error| panic!("{error}"))
}

/// Reads all files below a folder, without hidden ones and cargo's output.
fn files(folder: &Path, path: &str, found: &mut Files) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("a name in UTF-8");
        let (place, path) = (entry.path(), format!("{path}{name}"));
        if name.starts_with('.') && name != ".cargo" || name == "target" {
            continue;
        }
        if !place.is_dir() {
            found.insert(path, fs::read(place).expect("a file"));
        } else if !place.join("CACHEDIR.TAG").exists() {
            files(&place, &format!("{path}/"), found);
        }
    }
}

fn files_of(folder: &Path) -> Files {
    let mut found = Files::new();
    files(folder, "", &mut found);
    found
}

fn text<'a>(files: &'a mut Files, path: &str) -> &'a mut Vec<u8> {
    let file = files.get_mut(path);
    file.unwrap_or_else(|| panic!("the workspace has no {path}"))
}

fn replace(files: &mut Files, path: &str, from: &str, to: &str) {
    let file = text(files, path);
    let old = String::from_utf8_lossy(file);
    assert_eq!(old.matches(from).count(), 1, "{path}: {from}");
    *file = old.replacen(from, to, 1).into_bytes();
}

/// Adds the cart to a workspace; returns the paths of the files that it adds or changes.
fn add_cart(workspace: &mut Files) -> BTreeSet<String> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools/cart");
    let new = files_of(&data.join("new"));
    let mut touched: BTreeSet<String> = new.keys().cloned().collect();
    for (path, content) in new {
        let old = workspace.insert(path.clone(), content);
        assert!(old.is_none(), "{path} is not new");
    }
    let lines = fs::read_to_string(data.join("lines.toml")).expect("lines.toml");
    let lines: Lines = toml::from_str(&lines).expect("lines.toml");
    for Line { file, after, text } in lines.line {
        if let Some(after) = after {
            let (from, to) = (format!("\n{after}\n"), format!("\n{after}\n{text}\n"));
            // The first line of a file has no line break before it.
            let content = self::text(workspace, &file);
            content.insert(0, b'\n');
            replace(workspace, &file, &from, &to);
            self::text(workspace, &file).remove(0);
        } else {
            self::text(workspace, &file).extend(format!("{text}\n").bytes());
        }
        touched.insert(file);
    }
    touched
}

/// The lines that the cart adds to existing files, with the files.
fn added_lines() -> Vec<(String, String)> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools/cart/lines.toml");
    let lines = fs::read_to_string(data).expect("lines.toml");
    let lines: Lines = toml::from_str(&lines).expect("lines.toml");
    let lines = lines.line.into_iter();
    lines
        .flat_map(|Line { file, text, .. }| {
            let added = text
                .lines()
                .map(|line| (file.clone(), line.trim().to_owned()));
            added.collect::<Vec<_>>()
        })
        .collect()
}

/// The first column of the page's tables, with `cart` in place of `<robot>`.
fn places() -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/adding-a-robot.md")).expect("the page");
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let places = rows.filter_map(|row| row.split('`').next());
    places
        .map(|place| place.replace("<robot>", "cart"))
        .collect()
}

/// Whether a place on the page covers a file; a folder covers everything below it.
fn covers(place: &str, file: &str) -> bool {
    place == file || place.ends_with('/') && file.starts_with(place)
}

#[test]
fn a_cart_is_a_module_in_each_crate_and_one_line_of_the_registry() {
    let mut crates = BTreeSet::new();
    let mut registry = Vec::new();
    for (file, line) in added_lines() {
        if line.trim_start_matches("pub ") == "mod cart;" {
            let (name, _) = file.split_once('/').expect("a path");
            assert!(crates.insert(name.to_owned()), "a second module: {file}");
        } else {
            registry.push((file, line));
        }
    }
    let crates: Vec<_> = crates.iter().map(String::as_str).collect();
    assert_eq!(crates, ["firmware", "host-tests", "shared"]);
    assert_eq!(registry.len(), 1, "{registry:#?}");
    assert_eq!(registry[0].0, "shared/src/robots/mod.rs");
    let new = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools/cart/new");
    for file in files_of(&new).keys() {
        assert!(
            file.contains("cart"),
            "{file} is none of the cart's own files"
        );
    }
}

#[test]
fn a_cart_needs_the_places_on_the_page_and_no_other() {
    let touched = add_cart(&mut files_of(root()));
    let places = places();
    assert!(places.len() > 10, "{places:?}");
    let listed = |file: &&String| places.iter().any(|place| covers(place, file));
    let missing: Vec<_> = touched.iter().filter(|file| !listed(file)).collect();
    assert!(missing.is_empty(), "not on the page: {missing:#?}");
    let used = |place: &&String| touched.iter().any(|file| covers(place, file));
    let superfluous: Vec<_> = places.iter().filter(|place| !used(place)).collect();
    assert!(
        superfluous.is_empty(),
        "needed by no cart: {superfluous:#?}"
    );
}

/// A copy of the workspace with the cart in it.
struct Copy {
    root: PathBuf,
    /// Folder of cargo's output for this workspace.
    target: PathBuf,
}

/// Names of the packages of the workspace.
const PACKAGES: [&str; 4] = [
    "tautrack",
    "tautrack-firmware",
    "tautrack-host-tests",
    "tautrack-setup",
];

impl Copy {
    fn new() -> Self {
        let program = Path::new(env!("CARGO_BIN_EXE_demo"));
        let target = program.ancestors().nth(2).expect("the target folder");
        let (folder, root) = (target.join("cart"), target.join("cart/workspace"));
        let mut workspace = files_of(self::root());
        add_cart(&mut workspace);
        // Another version lets cargo distinguish the packages of the copy from those of the
        // workspace.
        let version = |version: &str| format!("version = \"{version}\"\n");
        let (old, new) = (version("0.1.0"), version("0.1.0-cart"));
        replace(&mut workspace, "Cargo.toml", &old, &new);
        for name in PACKAGES {
            let entry = |version| format!("name = \"{name}\"\n{version}");
            replace(&mut workspace, "Cargo.lock", &entry(&old), &entry(&new));
        }
        // Unchanged files keep their time stamps, so that cargo does not build them again.
        fs::create_dir_all(&root).expect("a folder");
        let before = files_of(&root);
        for path in before.keys().filter(|path| !workspace.contains_key(*path)) {
            fs::remove_file(root.join(path)).expect("removed");
        }
        for (path, content) in workspace {
            if before.get(&path) != Some(&content) {
                let place = root.join(path);
                fs::create_dir_all(place.parent().expect("a folder")).expect("made");
                fs::write(place, content).expect("written");
            }
        }
        // The nodes' dependencies are used from the workspace, where they are already built.
        let nodes = self::root().join("target/nodes");
        let config = format!("build.build-dir = {:?}\n", nodes.display().to_string());
        fs::create_dir_all(folder.join(".cargo")).expect("a folder");
        fs::write(folder.join(".cargo/config.toml"), config).expect("written");
        Self {
            root,
            target: target.to_owned(),
        }
    }

    /// Runs a program of the copy as its user would.
    fn run(&self, program: &str, arguments: &[&str]) {
        let output = Command::new(env!("CARGO"))
            .args(["run", "--locked", "-p", "tautrack-host-tests", "--bin"])
            .args([program, "--"])
            .args(arguments)
            .current_dir(&self.root)
            .env_remove("CARGO_TARGET_DIR")
            .env("CARGO_BUILD_BUILD_DIR", &self.target)
            .output()
            .expect("cargo starts");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{program} {arguments:?}:\n{text}");
    }

    /// Runs a scenario of the cart with nodes in this process and returns the summary.
    fn demo(&self, scenario: &str, guard: &str) -> Value {
        let file = format!("host-tests/scenarios/cart/{scenario}.toml");
        let out = self.root.join("target/demo");
        if out.exists() {
            fs::remove_dir_all(&out).expect("removed");
        }
        let folder = out.display().to_string();
        let arguments = ["--scenario", &file, "--nodes", "host", "--guard", guard];
        self.run("demo", &[&arguments[..], &["--out", &folder]].concat());
        let text = fs::read_to_string(out.join("summary.json")).expect("summary.json");
        serde_json::from_str(&text).expect("JSON")
    }
}

#[test]
#[ignore = "builds the workspace a second time; docs/testing.md has the complete campaigns"]
fn a_cart_from_the_page_drives_and_its_guard_keeps_it_upright() {
    let copy = Copy::new();
    let before = files_of(&copy.root);
    copy.run("generate", &[]);
    let after = files_of(&copy.root);
    let written: Vec<_> = after
        .keys()
        .filter(|path| before.get(*path) != after.get(*path))
        .collect();
    assert_eq!(written, ["docs/bus.md",]);

    // The speed ramps up and down equally long, so the distance is 0.3 m/s for 10 s.
    let flat = copy.demo("flat", "on");
    let driven = flat["driven_m"].as_f64().expect("a number");
    assert!((driven - 0.3 * 10.0).abs() < 0.01 * 3.0, "{driven}");
    assert_eq!(flat["expectation_met"], true, "{}", flat["unmet"]);
    assert_eq!(flat["toppled"], false);

    let held = copy.demo("hazards/hard-stop-downhill", "on");
    assert_eq!(held["toppled"], false, "{held:#}");
    assert_ne!(held["guard"]["interventions"], 0, "{held:#}");
    let driven = held["driven_m"].as_f64().expect("a number");
    assert!(driven > 0.05, "it holds the cart at rest: {driven}");
    let without = copy.demo("hazards/hard-stop-downhill", "off");
    assert_eq!(without["toppled"], true, "{without:#}");
}
