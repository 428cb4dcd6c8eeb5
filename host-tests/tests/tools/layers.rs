//! Tests that no module uses one of a higher layer, and that no files use each other in a circle.
//! It reads the `use` lines and paths in `src`.

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
    "fault_log",
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
    "live",
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

/// The module of a path below the root of a crate. In the folder of a robot, `results` and `tools`
/// belong to the modules with these names.
fn layer(path: &[String]) -> &str {
    match path {
        [robots, _, part, ..]
            if robots == "robots" && ["results", "tools"].contains(&part.as_str()) =>
        {
            part
        }
        [first, ..] => first,
        [] => "",
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
        let names = inner.with_extension("");
        let names: Vec<_> = names
            .iter()
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        let module = layer(&names);
        // Code for tests may use any module.
        if ["lib", "bin"].contains(&module) || inner.ends_with("tests.rs") {
            continue;
        }
        let place = order.iter().position(|name| *name == module);
        let code = std::fs::read_to_string(&file).expect("a source");
        let mut named = Named::default();
        let ends_in_mod = inner.file_name().is_some_and(|name| name == "mod.rs");
        let depth = inner.components().count() - usize::from(ends_in_mod);
        named.read(code.parse().expect("Rust"), depth);
        let mut paths = Vec::new();
        collect_paths(code.parse().expect("Rust"), &[], &mut paths);
        for path in paths.iter().filter(|path| path[0] == "crate") {
            named
                .0
                .extend(path.get(1).map(|_| layer(&path[1..]).to_owned()));
        }
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

/// Adds each path that `code` names, such as `super::wheel::Arm`, with its groups spread out.
fn collect_paths(code: TokenStream, prefix: &[String], found: &mut Vec<Vec<String>>) {
    let tokens: Vec<TokenTree> = code.into_iter().collect();
    let mut rest = tokens.as_slice();
    while let [first, after @ ..] = rest {
        rest = after;
        match first {
            TokenTree::Punct(mark) if mark.as_char() == '#' => {
                if let [TokenTree::Group(attribute), item @ ..] = after
                    && attribute.to_string() == "[cfg (test)]"
                {
                    let end = item.iter().position(ends_item).expect("an item");
                    rest = &item[end + 1..];
                }
            }
            TokenTree::Ident(name) => {
                let mut path = prefix.to_vec();
                path.push(name.to_string());
                while let [a, b, TokenTree::Ident(next), more @ ..] = rest
                    && is(a, ":")
                    && is(b, ":")
                {
                    path.push(next.to_string());
                    rest = more;
                }
                if let [a, b, TokenTree::Group(group), more @ ..] = rest
                    && is(a, ":")
                    && is(b, ":")
                    && group.delimiter() == Delimiter::Brace
                {
                    collect_paths(group.stream(), &path, found);
                    rest = more;
                } else {
                    found.push(path);
                }
            }
            TokenTree::Group(group) => collect_paths(group.stream(), &[], found),
            _ => {}
        }
    }
}

/// Lists the files that use each other in a circle, as "user uses module". A file and those below
/// it, such as `filter/mod.rs` and `filter/speed.rs`, count as one.
fn circles(src: &Path) -> Vec<String> {
    let mut files = Vec::new();
    sources(src, &mut files);
    let module = |file: &Path| -> Vec<String> {
        let inner = file
            .strip_prefix(src)
            .expect("inside of src")
            .with_extension("");
        let names = inner.iter().map(|name| name.to_string_lossy().into_owned());
        names
            .filter(|name| name != "mod" && name != "lib")
            .collect()
    };
    let modules: BTreeSet<Vec<String>> = files.iter().map(|file| module(file)).collect();
    let mut uses = BTreeSet::new();
    for file in &files {
        let user = module(file);
        if user.iter().any(|name| name == "tests") {
            continue;
        }
        let code = std::fs::read_to_string(file).expect("a source");
        let mut paths = Vec::new();
        collect_paths(code.parse().expect("Rust"), &[], &mut paths);
        for path in paths {
            let up = path.iter().take_while(|name| *name == "super").count();
            let mut used = match path[0].as_str() {
                "crate" => path[1..].to_vec(),
                "super" => [&user[..user.len().saturating_sub(up)], &path[up..]].concat(),
                _ => continue,
            };
            while !modules.contains(&used) {
                used.pop();
            }
            if !used.starts_with(&user) && !user.starts_with(&used) {
                uses.insert((user.clone(), used));
            }
        }
    }
    // A use that nothing leads to, or that leads nowhere, is in no circle.
    loop {
        let users: BTreeSet<_> = uses.iter().map(|(user, _)| user.clone()).collect();
        let used: BTreeSet<_> = uses.iter().map(|(_, used)| used.clone()).collect();
        let before = uses.len();
        uses.retain(|(user, other)| used.contains(user) && users.contains(other));
        if uses.len() == before {
            let text = |(user, used): &(Vec<String>, Vec<String>)| {
                format!("{} uses {}", user.join("::"), used.join("::"))
            };
            return uses.iter().map(text).collect();
        }
    }
}

#[test]
fn no_files_of_the_control_code_use_each_other_in_a_circle() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("shared");
    let found = circles(&shared.join("src"));
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_circle_is_found_over_several_files() {
    let folder = std::env::temp_dir().join(format!("tautrack-circles-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("a")).expect("a folder");
    let write = |file: &str, code: &str| std::fs::write(folder.join(file), code).expect("written");
    write("a/mod.rs", "mod b; mod c; mod d; pub use c::C;");
    write("a/b.rs", "use super::{c::C, d};");
    write("a/c.rs", "fn f(x: crate::e::E) { super::helper() }");
    write(
        "a/d.rs",
        "#[cfg(test)] mod tests { use super::super::b::B; }",
    );
    write("e.rs", "use crate::a::d::{self, D};");
    assert_eq!(circles(&folder), Vec::<String>::new());
    write("e.rs", "use crate::a::{d::D, b::B};");
    let found = ["a::b uses a::c", "a::c uses e", "e uses a::b"];
    assert_eq!(circles(&folder), found);
    std::fs::remove_dir_all(&folder).expect("removed");
}
