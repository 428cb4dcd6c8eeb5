//! No module knows one that stands above it: the `use` lines and paths of `src` are read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The modules of `shared`, lowest first. A module uses only those before it.
const SHARED: &[&str] = &[
    "constants",
    "units",
    "sensors",
    "can",
    "settings",
    "faults",
    "math",
    "bus",
    "motor",
    "screw",
    "stability",
    "estimate",
    "robots",
    "node",
    "link",
];

/// Those of the simulator.
const SIMULATOR: &[&str] = &[
    "bounds",
    "programs",
    "world",
    "robots",
    "scenario",
    "simulator",
    "results",
    "tools",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The modules of the crate that `code` names: what follows `crate::`, also in braces.
fn named(code: &str) -> BTreeSet<String> {
    let word = |text: &str| -> String {
        let is_word = |letter: &char| letter.is_alphanumeric() || *letter == '_';
        text.chars().take_while(is_word).collect()
    };
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let names: Vec<&str> = match rest.strip_prefix('{') {
            Some(group) => group.split('}').next().unwrap_or("").split(',').collect(),
            None => vec![rest],
        };
        found.extend(names.into_iter().map(|name| word(name.trim_start())));
    }
    found
}

/// Each use of a module that stands above the user, as "user uses module (file)".
fn upward(src: &Path, order: &[&str]) -> Vec<String> {
    let mut files = Vec::new();
    sources(src, &mut files);
    files.sort();
    let mut wrong = Vec::new();
    for file in files {
        let inner = file.strip_prefix(src).expect("inside of src");
        let first = inner.components().next().expect("a name");
        let module = first.as_os_str().to_string_lossy();
        let module = module.strip_suffix(".rs").unwrap_or(&module);
        if ["lib", "bin"].contains(&module) {
            continue;
        }
        let place = order.iter().position(|name| *name == module);
        let code = std::fs::read_to_string(&file).expect("a source");
        // What only tests use does not shape the crate.
        let code = code.split("#[cfg(test)]").next().expect("a part");
        for name in named(code) {
            let other = order.iter().position(|known| *known == name);
            if other.is_none() || place.is_none() || other > place {
                wrong.push(format!("{module} uses {name} ({})", inner.display()));
            }
        }
    }
    wrong
}

#[test]
fn no_module_uses_one_that_stands_above_it() {
    let simulator = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = simulator.with_file_name("shared");
    for (package, order) in [(shared.as_path(), SHARED), (simulator, SIMULATOR)] {
        let wrong = upward(&package.join("src"), order);
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}

#[test]
fn an_upward_use_is_found_in_every_form() {
    let folder = std::env::temp_dir().join(format!("tautrack-layers-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("math")).expect("a folder");
    for (code, expected) in [
        ("use crate::units::Angle;", 0),
        ("use crate::node::guard::Guard;", 1),
        ("use crate::{units::Angle, robots};", 1),
        ("fn f(x: crate::stability::support::Stance) {}", 1),
        ("use crate::nowhere::Thing;", 1),
        ("use super::vector;", 0),
    ] {
        std::fs::write(folder.join("math/mod.rs"), code).expect("written");
        assert_eq!(upward(&folder, SHARED).len(), expected, "{code}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
