//! Writes the tables of docs/guarantees.md from host-tests/guarantees.toml: each promise with its
//! test, a link to the test's file, and the command that runs the test.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

/// Folders of the packages that have tests, with the arguments of `cargo test` that select them.
const PACKAGES: [(&str, &str); 3] = [
    ("shared", "-p tautrack --features=lockstep"),
    ("firmware", "-p tautrack-firmware"),
    ("host-tests", "-p tautrack-host-tests"),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Guarantees {
    section: Vec<Section>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Section {
    title: String,
    /// Each promise with the name of its test.
    promises: Vec<(String, String)>,
}

/// Where a test is, and how it is run.
struct Place {
    /// Path of the file from the root of the checkout.
    file: String,
    command: String,
}

/// Returns the tables for the promises in `source`, the text of guarantees.toml. `root` is the
/// checkout that has the tests.
///
/// # Errors
/// The reason, if the text is invalid, a file cannot be read, or the name of a test belongs to no
/// test or to several.
pub fn tables(root: &Path, source: &str) -> Result<String, String> {
    let guarantees: Guarantees = toml::from_str(source).map_err(|error| error.to_string())?;
    let tests = tests(root).map_err(|error| format!("the tests cannot be read: {error}"))?;
    let mut text = String::new();
    for Section { title, promises } in guarantees.section {
        let _ = write!(
            text,
            "## {title}\n\n| Promise | Test | Command |\n|---|---|---|\n"
        );
        for (promise, name) in promises {
            let places = tests.get(&name).map_or(&[][..], Vec::as_slice);
            let [Place { file, command }] = places else {
                let files: Vec<_> = places.iter().map(|place| &*place.file).collect();
                let count = files.len();
                return Err(format!("`{name}` names {count} tests: {files:?}"));
            };
            let _ = writeln!(
                text,
                "| {promise} | [{name}](../{file}) | `cargo test {command}` |"
            );
        }
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    Ok(text)
}

/// Finds every test of the packages by its name.
fn tests(root: &Path) -> io::Result<BTreeMap<String, Vec<Place>>> {
    let mut tests: BTreeMap<String, Vec<Place>> = BTreeMap::new();
    for (folder, package) in PACKAGES {
        for part in ["src", "tests"] {
            let below = format!("{folder}/{part}");
            for file in sources(root, &below)? {
                let target = match file[below.len() + 1..].split(['/', '.']).next() {
                    Some(program) if part == "tests" => format!("--test {program}"),
                    _ => "--lib".to_owned(),
                };
                for (name, ignored) in names(&fs::read_to_string(root.join(&file))?) {
                    let run = if ignored { " -- --ignored" } else { "" };
                    let command = format!("{package} {target} {name}{run}");
                    let file = file.clone();
                    tests.entry(name).or_default().push(Place { file, command });
                }
            }
        }
    }
    Ok(tests)
}

/// Returns the Rust files below a folder, as paths from the root.
fn sources(root: &Path, folder: &str) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            found.extend(sources(root, &path)?);
        } else if Path::new(&path).extension() == Some("rs".as_ref()) {
            found.push(path);
        }
    }
    Ok(found)
}

/// Returns the names of the tests in a Rust file, each with whether it is ignored.
fn names(source: &str) -> Vec<(String, bool)> {
    let mut names = Vec::new();
    for part in source.split("#[test]").skip(1) {
        let Some((attributes, rest)) = part.split_once("fn ") else {
            continue;
        };
        let end = rest.find('(').unwrap_or(rest.len());
        names.push((rest[..end].to_owned(), attributes.contains("#[ignore")));
    }
    names
}
