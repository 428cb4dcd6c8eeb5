//! `cargo evaluate`: evaluates model functions with inputs from a JSON document, in single or
//! double precision.
//!
//! It runs the library's own code, so anybody with another program, such as MATLAB, can check the
//! code that the nodes run.
//!
//! The format is the one of host-tests/vectors: `group`, `params`,
//! `functions: {name: [{in, out}]}`. The result is the same document with `out` computed in every
//! case. The groups are those of the robots.

mod command;
mod error;
pub(crate) mod input;

pub use command::main;
pub use error::EvaluateError;

use crate::tools::robot::groups;
use clap::ValueEnum;
use input::Input;
use serde_json::Value;

/// Number format of the computation.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Precision {
    /// Single precision, as on the robot.
    F32,
    /// Double precision.
    F64,
}

/// A function of a group: computes `out` from the document's `params` and a case's `in`.
pub(crate) type Function = fn(&Input, &Input) -> Result<Value, EvaluateError>;
/// The functions of a group, by name.
pub(crate) type Functions = Vec<(&'static str, Function)>;
/// Groups with their functions, by name.
pub(crate) type Groups = Vec<(&'static str, Functions)>;

/// Parses the document `text` and computes every `out`.
///
/// # Errors
/// Names the first part of the document that cannot be parsed or computed, with its place.
pub fn evaluate(text: &str, precision: Precision) -> Result<Value, EvaluateError> {
    let document = serde_json::from_str(text).map_err(|error| EvaluateError::Malformed {
        line: error.line(),
        column: error.column(),
        message: error.to_string(),
    })?;
    match precision {
        Precision::F32 => evaluate_with(document, &groups::<f32>()),
        Precision::F64 => evaluate_with(document, &groups::<f64>()),
    }
}

fn evaluate_with(mut document: Value, groups: &Groups) -> Result<Value, EvaluateError> {
    let root = Input::root(&document);
    let group = root.text("group")?;
    let names = || groups.iter().map(|(name, _)| *name).collect();
    let (_, known) = groups
        .iter()
        .find(|(name, _)| *name == group)
        .ok_or_else(|| EvaluateError::UnknownGroup {
            got: group.to_owned(),
            known: names(),
        })?;
    let params = root.member("params")?;
    let mut results = Vec::new();
    for (name, cases) in root.member("functions")?.members()? {
        let (_, function) = known
            .iter()
            .find(|(other, _)| *other == name)
            .ok_or_else(|| EvaluateError::UnknownFunction {
                group: group.to_owned(),
                got: name.to_owned(),
                known: known.iter().map(|(name, _)| *name).collect(),
            })?;
        for (index, case) in cases.elements()?.iter().enumerate() {
            let out = function(&params, &case.member("in")?)?;
            results.push((name.to_owned(), index, out));
        }
    }
    for (name, index, out) in results {
        document["functions"][&name][index]["out"] = out;
    }
    Ok(document)
}
