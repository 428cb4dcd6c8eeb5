//! Errors in a scenario file, with file, line and column; and the parser that reports them.

use super::Description;
use crate::bounds::Problem;
use std::fmt;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// An error in a scenario file; displays as one sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenarioError {
    /// Name of the file.
    pub file: String,
    /// Line and column of the error, both counted from 1.
    pub place: Option<(usize, usize)>,
    /// What is wrong.
    pub problem: Problem,
}

impl ScenarioError {
    pub(super) fn new(file: &str, problem: Problem) -> Self {
        Self {
            file: file.to_owned(),
            place: None,
            problem,
        }
    }
}

impl std::error::Error for ScenarioError {}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some((line, column)) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

/// Parses the text to a description that is not checked yet.
pub(super) fn parse(text: &str, file: &str) -> Result<Description, ScenarioError> {
    let is_void = |line: &str| line.trim().is_empty() || line.trim_start().starts_with('#');
    if text.lines().all(is_void) {
        return Err(ScenarioError::new(file, Problem::Empty));
    }
    toml::from_str(text).map_err(|error| {
        let values = spans(text);
        let enclosing = error.span().and_then(|span| {
            values
                .iter()
                .filter(|(_, value)| *value == span)
                .map(|(key, _)| key.clone())
                .next_back()
        });
        ScenarioError {
            file: file.to_owned(),
            place: error.span().map(|span| line_and_column(text, span.start)),
            problem: Problem::Malformed {
                key: enclosing,
                message: error.message().replace('\n', ", "),
            },
        }
    })
}

/// Adds line and column of the problem's key. If the file does not contain the key, because its
/// value is a default, they are those of the nearest table around it.
pub(super) fn locate(problem: Problem, text: &str, file: &str) -> ScenarioError {
    let values = spans(text);
    let mut key = problem.key().unwrap_or_default();
    let place = loop {
        if let Some((_, span)) = values.iter().find(|(path, _)| path == key) {
            break Some(line_and_column(text, span.start));
        }
        match key.rfind(['.', '[']) {
            Some(cut) => key = &key[..cut],
            None => break None,
        }
    };
    ScenarioError {
        file: file.to_owned(),
        place,
        problem,
    }
}

/// Path and span of every value in the text, outer values first; empty if the text is not TOML.
fn spans(text: &str) -> Vec<(String, Range<usize>)> {
    let mut found = Vec::new();
    if let Ok(table) = DeTable::parse(text) {
        walk_table("", table.get_ref(), &mut found);
    }
    found
}

fn walk_table(path: &str, table: &DeTable<'_>, found: &mut Vec<(String, Range<usize>)>) {
    for (key, value) in table {
        let dot = if path.is_empty() { "" } else { "." };
        walk(&format!("{path}{dot}{}", key.get_ref()), value, found);
    }
}

fn walk(path: &str, value: &toml::Spanned<DeValue<'_>>, found: &mut Vec<(String, Range<usize>)>) {
    found.push((path.to_owned(), value.span()));
    match value.get_ref() {
        DeValue::Table(table) => walk_table(path, table, found),
        DeValue::Array(array) => {
            for (index, item) in array.iter().enumerate() {
                walk(&format!("{path}[{index}]"), item, found);
            }
        }
        _ => {}
    }
}

fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}
