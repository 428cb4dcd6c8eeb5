//! Tests that comments and pages keep to the project's terms, to 100 columns and to a length.

use super::docs::{files, root};
use std::fs;

/// Terms that were replaced, in lower case.
const OLD_TERMS: [&str; 17] = [
    "at the most",
    "bus voltage",
    "coming to life",
    "in advance of",
    "look for the reference",
    "no number",
    "patience",
    "reference run",
    "referencing",
    "rehears",
    "same bits",
    "satellite receiver",
    "torque in advance",
    "to the bit",
    "told in advance",
    "told_in_advance",
    "unsure",
];

/// Files of the project with this ending, with their text. The changelog names old terms, and so
/// does this file.
fn texts(ending: &str) -> Vec<(String, String)> {
    let kept = |path: &String| path != "CHANGELOG.md" && !path.ends_with("tools/words.rs");
    let found = files("", ending).into_iter().filter(kept);
    let read = |path: String| {
        let text = fs::read_to_string(root().join(&path)).expect("a file");
        (path, text)
    };
    found.map(read).collect()
}

#[test]
fn no_old_term_is_left() {
    let mut wrong = Vec::new();
    for ending in [".md", ".rs", ".toml", ".html", ".js", ".py", ".txt", ".eds"] {
        for (path, text) in texts(ending) {
            let text = text.to_lowercase();
            let found = OLD_TERMS.iter().filter(|term| text.contains(**term));
            wrong.extend(found.map(|term| format!("{path}: {term}")));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Tables, code blocks and lines with a link may be longer.
#[test]
fn comments_and_pages_end_at_100_columns() {
    let mut wrong = Vec::new();
    let mut check = |path: &str, number: usize, line: &str| {
        if line.chars().count() > 100 {
            wrong.push(format!("{path}:{}", number + 1));
        }
    };
    for (ending, mark) in [(".rs", "//"), (".toml", "#")] {
        for (path, text) in texts(ending) {
            let lines = text.lines().enumerate();
            let comments = lines.filter(|(_, line)| line.trim_start().starts_with(mark));
            comments.for_each(|(number, line)| check(&path, number, line));
        }
    }
    for (path, text) in texts(".md") {
        let mut in_code = false;
        for (number, line) in text.lines().enumerate() {
            let fence = line.trim_start().starts_with("```");
            in_code ^= fence;
            if !(in_code || fence || line.trim_start().starts_with('|') || line.contains("](")) {
                check(&path, number, line);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A page that gains words takes them from another place.
#[test]
fn all_pages_together_have_at_most_30_000_words_outside_of_tables() {
    let mut counts: Vec<(usize, String)> = files("", ".md")
        .into_iter()
        .map(|path| {
            let text = fs::read_to_string(root().join(&path)).expect("a page");
            let lines = text.lines().filter(|line| !line.trim().starts_with('|'));
            (lines.flat_map(str::split_whitespace).count(), path)
        })
        .collect();
    counts.sort();
    let sum: usize = counts.iter().map(|(words, _)| words).sum();
    assert!(sum <= 30_000, "{sum} words: {counts:#?}");
}
