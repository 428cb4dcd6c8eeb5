//! Tests that no module uses one of a higher layer. It reads the `use` lines and paths in `src`.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
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
    "estimate",
    "sensing",
    "stability",
    "robots",
    "node",
    "link",
    "store",
    "roles",
];

/// The modules of the simulator, lowest first.
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

/// The modules of the crate that code names, found token by token.
#[derive(Default)]
struct Named(BTreeSet<String>);

impl Named {
    /// Reads the code of a module that is `depth` levels below the root of the crate.
    fn read(&mut self, code: TokenStream, depth: usize) {
        let tokens: Vec<TokenTree> = code.into_iter().collect();
        let mut rest = tokens.as_slice();
        while let [first, after @ ..] = rest {
            rest = after;
            match (first, after) {
                // Code for tests may use any module.
                (_, [TokenTree::Group(attribute), item @ ..])
                    if is(first, "#") && attribute.to_string() == "[cfg (test)]" =>
                {
                    let end = item.iter().position(ends_item).expect("an item");
                    rest = &item[end + 1..];
                }
                (_, [TokenTree::Ident(_), TokenTree::Group(module), after @ ..])
                    if is(first, "mod") =>
                {
                    self.read(module.stream(), depth + 1);
                    rest = after;
                }
                _ if is(first, "crate") => self.take_named(after),
                _ if is(first, "super") => {
                    let mut climbed = 1;
                    while let [a, b, next, after @ ..] = rest
                        && is(a, ":")
                        && is(b, ":")
                        && is(next, "super")
                    {
                        climbed += 1;
                        rest = after;
                    }
                    if climbed >= depth {
                        self.take_named(rest);
                    }
                }
                (TokenTree::Group(group), _) => self.read(group.stream(), depth),
                _ => {}
            }
        }
    }

    /// Adds the name that follows the root of the crate. Other names than those of modules are
    /// added too, because they may mean the whole crate, as in `crate as other` and `crate::*`.
    fn take_named(&mut self, after: &[TokenTree]) {
        match after {
            // A visibility such as `pub(crate)`.
            [] => {}
            [a, b, TokenTree::Group(group), ..] if is(a, ":") && is(b, ":") => {
                let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
                let names = tokens.split(|token| is(token, ","));
                let names = names.filter_map(<[TokenTree]>::first);
                self.0.extend(names.map(ToString::to_string));
            }
            [a, b, name, ..] if is(a, ":") && is(b, ":") => {
                self.0.insert(name.to_string());
            }
            [other, ..] => {
                self.0.insert(format!("the crate {other}"));
            }
        }
    }
}

fn is(token: &TokenTree, text: &str) -> bool {
    !matches!(token, TokenTree::Group(_)) && token.to_string() == text
}

fn ends_item(token: &TokenTree) -> bool {
    match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        other => is(other, ";"),
    }
}

/// Lists each use of a higher module, as "user uses module (file)".
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
        let mut named = Named::default();
        let ends_in_mod = inner.file_name().is_some_and(|name| name == "mod.rs");
        let depth = inner.components().count() - usize::from(ends_in_mod);
        named.read(code.parse().expect("Rust"), depth);
        for name in named.0 {
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
        (
            "use crate::{units::{Angle, Length}, robots::{Body, Ahead}};",
            1,
        ),
        ("use super::vector;", 1),
        ("use super::{units, node};", 1),
        (
            "mod inner { use super::vector; use super::super::node::guard; }",
            1,
        ),
        ("pub(crate) fn f() { g!(crate::robots::Body) }", 1),
        ("use crate as all;", 1),
        ("extern crate self as all;", 1),
        ("use crate::*;", 1),
        (
            "#[cfg(test)] mod tests { use crate::node; } use crate::robots::Body;",
            1,
        ),
        ("#[cfg(test)] use crate::node; // and crate::robots", 0),
    ] {
        std::fs::write(folder.join("math/mod.rs"), code).expect("written");
        assert_eq!(upward(&folder, SHARED).len(), expected, "{code}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
