//! Tests that everything that README and docs name exists: links and their headings, files,
//! commands with their options, and tests.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::tools::evaluate::{EvaluateError, Precision, evaluate};

/// Files that exist only after a run or a build, or that a reader makes.
const MADE: [&str; 5] = [
    "FILE",
    "target/",
    "computed.json",
    "run.mcap",
    "summary.json",
];
/// Folders of the checkout with which a path can begin.
const FOLDERS: [&str; 7] = [
    ".cargo/",
    ".ci/",
    "docs/",
    "examples/",
    "firmware/",
    "host-tests/",
    "shared/",
];

pub fn root() -> &'static Path {
    checkout::root().unwrap_or_else(|error| panic!("{error}"))
}

/// Files below `folder` whose names have this ending, as paths from the root, without cargo's
/// output and hidden folders.
pub fn files(folder: &str, ending: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root().join(folder)).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("a name in UTF-8");
        let path = format!("{folder}{name}");
        if entry.path().is_dir() {
            if name != "target" && !name.starts_with('.') {
                found.extend(files(&format!("{path}/"), ending));
            }
        } else if name.ends_with(ending) {
            found.push(path);
        }
    }
    found
}

/// All pages. Pages below the tests are data of a test and are left out.
fn pages() -> Vec<PathBuf> {
    let pages = files("", ".md").into_iter().map(PathBuf::from);
    let pages: Vec<_> = pages
        .filter(|page| !page.starts_with("host-tests/tests"))
        .collect();
    assert!(pages.contains(&PathBuf::from("README.md")), "{pages:?}");
    pages
}

/// Links, headings and code of one page.
#[derive(Default)]
struct Page {
    links: Vec<String>,
    anchors: BTreeSet<String>,
    /// Code within sentences, and lines of code blocks without a language.
    code: Vec<String>,
}

/// The anchor of a heading: lower case, hyphens for spaces, no punctuation.
fn anchor(heading: &str) -> String {
    let kept = |letter: &char| letter.is_alphanumeric() || "-_ ".contains(*letter);
    let text: String = heading.to_lowercase().chars().filter(kept).collect();
    text.replace(' ', "-")
}

impl Page {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(root().join(path)).expect("a page");
        let mut page = Self::default();
        let mut heading: Option<String> = None;
        let mut shell = false;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.anchors
                        .extend(heading.take().map(|text| anchor(&text)));
                }
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(language))) => {
                    shell = language.is_empty();
                }
                Event::End(TagEnd::CodeBlock) => shell = false,
                Event::Code(code) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&code);
                    }
                    page.code.push(code.into_string());
                }
                Event::Text(text) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    } else if shell {
                        page.code.extend(text.lines().map(str::to_owned));
                    }
                }
                _ => {}
            }
        }
        page
    }

    /// The words of each line of code, without the comment at its end.
    fn lines(&self) -> impl Iterator<Item = Vec<&str>> {
        self.code.iter().map(|line| {
            let command = line.split(" # ").next().unwrap_or_default();
            command
                .split_whitespace()
                .map(|word| word.trim_matches(['[', ']']))
                .collect()
        })
    }
}

/// Calls `check` for every page and fails if any call finds something wrong.
fn each(mut check: impl FnMut(&Path, &Page) -> Vec<String>) {
    let mut wrong = Vec::new();
    for path in pages() {
        let page = Page::read(&path);
        let found = check(&path, &page);
        wrong.extend(
            found
                .iter()
                .map(|what| format!("{}: {what}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_link_leads_to_a_file_and_its_heading() {
    each(|path, page| {
        let leads = |link: &&String| {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = path.parent().expect("a folder").join(file);
            let target = if file.is_empty() { path } else { &target };
            if !root().join(target).exists() {
                return false;
            }
            heading.is_empty() || Page::read(target).anchors.contains(heading)
        };
        let local = |link: &&String| !link.starts_with("https://");
        let dead = page.links.iter().filter(local).filter(|link| !leads(link));
        dead.cloned().collect()
    });
}

/// A path with a placeholder such as `<robot>` names several files and is not checked.
#[test]
fn every_path_exists() {
    each(|path, page| {
        let folder = root().join(path.parent().expect("a folder"));
        let words = page.lines().flatten();
        let paths = words.filter(|word| {
            let place = FOLDERS.iter().any(|folder| word.starts_with(folder));
            place && !word.contains(['<', '*', '{'])
        });
        let missing = paths.filter(|word| {
            let file = word.split(':').next().expect("the first part");
            !root().join(file).exists() && !folder.join(file).exists()
        });
        missing.map(str::to_owned).collect()
    });
}

/// The help text of one of our programs.
fn help(program: &str) -> String {
    let output = Command::new(program).arg("--help").output();
    String::from_utf8(output.expect("it starts").stdout).expect("text")
}

/// The help texts of all commands of `cargo tool`.
fn help_of_tool() -> String {
    let command = |names: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_tool"));
        let output = program.args(names).arg("--help").output();
        String::from_utf8(output.expect("it starts").stdout).expect("text")
    };
    let settings = ["list", "get", "set", "dump", "restore"];
    settings.map(|name| command(&["settings", name])).concat()
}

#[test]
fn every_option_of_our_commands_is_one() {
    let programs = [
        ("demo", help(env!("CARGO_BIN_EXE_demo"))),
        ("cost", help(env!("CARGO_BIN_EXE_cost"))),
        ("evaluate", help(env!("CARGO_BIN_EXE_evaluate"))),
        ("tool", help_of_tool()),
    ];
    each(|_, page| {
        let mut wrong = Vec::new();
        for line in page.lines() {
            let Some(("cargo", rest)) = line.split_first().map(|(first, rest)| (*first, rest))
            else {
                continue;
            };
            let Some((_, help)) = programs.iter().find(|(name, _)| rest.first() == Some(name))
            else {
                continue;
            };
            for (option, value) in rest.iter().zip(rest.iter().skip(1)) {
                let names_value = ["--suite", "--robot", "--nodes", "--guard"].contains(option);
                let known = !names_value
                    || help.contains(&format!("- {value}:"))
                    || help.contains(&format!("{value},"))
                    || help.contains(&format!("{value}]"))
                    || value.chars().all(char::is_uppercase);
                if !known {
                    wrong.push(format!("{option} {value}"));
                }
            }
            let options = rest.iter().filter(|word| word.starts_with("--"));
            let unknown = options.filter(|option| {
                !help.contains(&format!("{option} ")) && !help.contains(&format!("{option}\n"))
            });
            wrong.extend(unknown.map(|option| (*option).to_owned()));
            let files = rest
                .iter()
                .filter(|word| word.contains(".toml") || word.contains(".json"));
            let missing = files.filter(|file| {
                !root().join(file).exists() && !MADE.iter().any(|made| file.starts_with(made))
            });
            wrong.extend(missing.map(|file| (*file).to_owned()));
        }
        wrong
    });
}

/// Folder of the tests of a package of the workspace.
fn tests_of(package: &str) -> Option<PathBuf> {
    let folder = match package {
        "tautrack" => "shared/tests",
        "tautrack-firmware" => "firmware/tests",
        "tautrack-host-tests" => "host-tests/tests",
        _ => return None,
    };
    Some(root().join(folder))
}

/// Source code of a test program: one file, or all files below a folder.
fn source(package: &str, test: &str) -> Option<String> {
    let tests = tests_of(package)?;
    if let Ok(text) = fs::read_to_string(tests.join(format!("{test}.rs"))) {
        return Some(text);
    }
    sources(&tests.join(test))
}

/// Source code below a folder, if there is one.
fn sources(folder: &Path) -> Option<String> {
    if !folder.is_dir() {
        return None;
    }
    let folder = folder.strip_prefix(root()).ok()?;
    let found = files(&format!("{}/", folder.display()), ".rs");
    let texts = found
        .iter()
        .filter_map(|file| fs::read_to_string(root().join(file)).ok());
    Some(texts.collect())
}

/// What is wrong with the words of a `cargo test` line, or of `--test` with what follows it.
fn check_tests(words: &[&str]) -> Vec<String> {
    let after = |option: &str| {
        let place = words.iter().position(|word| *word == option)?;
        words.get(place + 1).copied()
    };
    let package = after("-p").unwrap_or("tautrack-host-tests");
    if tests_of(package).is_none() {
        return vec![format!("package {package}")];
    }
    let mut wrong = Vec::new();
    let mut sources = String::new();
    let mut words = words.iter().copied();
    while let Some(word) = words.next() {
        match word {
            "-p" => {
                words.next();
            }
            "--test" => {
                let test = words.next().unwrap_or_default();
                match source(package, test) {
                    Some(text) => sources.push_str(&text),
                    None => wrong.push(format!("--test {test}")),
                }
            }
            "--lib" => {
                let tests = tests_of(package).expect("a package");
                sources.push_str(&self::sources(&tests.with_file_name("src")).unwrap_or_default());
            }
            "cargo" | "test" => {}
            option if option.starts_with('-') => {}
            filter => {
                let named = [format!("fn {filter}"), format!("mod {filter};")];
                let part = sources
                    .lines()
                    .any(|line| line.contains("fn ") && line.contains(filter));
                if !part && !named.iter().any(|name| sources.contains(name)) {
                    wrong.push(format!("filter {filter}"));
                }
            }
        }
    }
    wrong
}

#[test]
fn every_test_that_a_page_names_is_there() {
    let mut named = 0;
    each(|_, page| {
        let tests = page.lines().filter(|words| {
            words.first() == Some(&"--test") || words.starts_with(&["cargo", "test"])
        });
        tests
            .flat_map(|words| {
                named += 1;
                check_tests(&words)
            })
            .collect()
    });
    assert!(named > 20, "{named}");
}

/// Every command is one of cargo's own, an alias in .cargo/config.toml, or the tool that its page
/// installs.
#[test]
fn every_cargo_command_is_one() {
    let config = fs::read_to_string(root().join(".cargo/config.toml")).expect("the aliases");
    each(|_, page| {
        let commands = page.lines().filter(|words| words.first() == Some(&"cargo"));
        let unknown = commands.filter_map(|words| {
            let name = *words.get(1)?;
            let own = [
                "bench", "build", "clippy", "deny", "fmt", "install", "mutants", "run", "test",
            ];
            (!own.contains(&name) && !config.contains(&format!("\n{name} = ")))
                .then(|| format!("cargo {name}"))
        });
        unknown.collect()
    });
}

/// Names of the robots in code.
const ROBOTS: [&str; 6] = [
    "b2p2", "crawler", "hylos", "rt_mover", "rtmover", "rt-mover",
];

/// Code of a robot stands in its folders. Tests may name robots.
#[test]
fn no_code_outside_of_a_robot_s_folders_names_one_but_the_places_on_the_page() {
    let page = Page::read(Path::new("docs/adding-a-robot.md"));
    let folders = ["firmware/src/", "host-tests/src/", "shared/src/"];
    let files = folders.iter().flat_map(|folder| files(folder, ".rs"));
    let of_a_robot = |file: &str| ROBOTS.iter().any(|name| file.contains(name));
    let mut read = 0;
    let missing = files.filter(|file| {
        read += 1;
        let text = fs::read_to_string(root().join(file)).expect("a source");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let mut code = code.lines().filter(|line| !line.trim().starts_with("//"));
        let named = code.any(|line| of_a_robot(&line.to_lowercase()));
        named && !of_a_robot(file) && !file.ends_with("tests.rs") && !page.code.contains(file)
    });
    let missing: Vec<_> = missing.collect();
    assert!(missing.is_empty(), "{missing:#?}");
    assert!(read > 100, "{read}");
}

#[test]
fn the_pages_of_the_robots_name_every_group_of_functions() {
    let pages = files("docs/robots/", ".md").into_iter();
    let pages = pages.map(|page| fs::read_to_string(root().join(page)).expect("a page"));
    let pages: String = pages.collect();
    let document = r#"{"group": "", "params": {}, "functions": {}}"#;
    let refusal = evaluate(document, Precision::F64).expect_err("there is no such group");
    let EvaluateError::UnknownGroup { known, .. } = refusal else {
        panic!("{refusal}");
    };
    assert!(known.len() > 5, "{known:?}");
    for name in known {
        assert!(pages.contains(&format!("`{name}`")), "{name}");
    }
}
