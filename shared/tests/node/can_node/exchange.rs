//! Runs the steps of an exchange with a node.

use super::Subject;
use crate::conformance::Row;
use crate::conformance::notation::{Pattern, Request, Step};
use tautrack::can::Frame;

fn matches(pattern: &Pattern, frame: &Frame) -> bool {
    let data = frame.data();
    let mut pairs = pattern.bytes.iter().zip(data);
    pattern.id == frame.id()
        && pattern.bytes.len() == data.len()
        && pairs.all(|(byte, got)| byte.is_none_or(|byte| byte == *got))
}

fn exactly(frame: &Frame) -> Pattern {
    Pattern {
        id: frame.id(),
        bytes: frame.data().iter().copied().map(Some).collect(),
    }
}

/// Returns what the node sends because of a request.
fn answers(node: &mut impl Subject, request: &Request) -> Vec<Frame> {
    match request {
        Request::Wait { time, .. } => (0..*time).flat_map(|_| node.run(true)).collect(),
        Request::Turn => {
            node.turn();
            Vec::new()
        }
        Request::Send(frames) => {
            let answers = |frame: &Frame| node.receive(frame.id(), frame.data());
            frames.iter().flat_map(answers).collect()
        }
    }
}

fn run(node: &mut impl Subject, steps: &[Step]) -> Result<(), String> {
    for Step {
        text,
        request,
        answers: expected,
    } in steps
    {
        let sent = answers(node, request);
        let right = expected.len() == sent.len()
            && expected.iter().zip(&sent).all(|(it, got)| matches(it, got));
        if !right {
            let expected: Vec<_> = expected.iter().map(Pattern::to_string).collect();
            let sent: Vec<_> = sent.iter().map(|it| exactly(it).to_string()).collect();
            return Err(format!("{text}\nexpected {expected:#?}\nsent {sent:#?}"));
        }
    }
    Ok(())
}

/// Runs each row with a node of its own. Panics with the rows in which the node sends something
/// else.
pub fn run_all<S: Subject>(rows: &[Row], node: impl Fn() -> S) {
    let wrong = rows.iter().filter_map(|row| {
        let difference = run(&mut node(), &row.steps).err()?;
        Some(format!("{}: {difference}", row.name))
    });
    let wrong: Vec<_> = wrong.collect();
    let (wrong, rows) = (wrong.join("\n\n"), rows.len());
    assert!(wrong.is_empty(), "of {rows} rows are wrong:\n{wrong}");
}
