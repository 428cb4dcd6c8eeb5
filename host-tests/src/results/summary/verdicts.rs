//! What the guard did, counted in the verdicts that it published.

use serde::Serialize;

/// What the guard did with the operator's commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GuardFigures {
    /// Times that it began to do anything but pass a command on as asked.
    pub interventions: usize,
    /// Those in which it refused.
    pub refused: usize,
    /// Those in which it passed on less than asked.
    pub scaled: usize,
}

/// What a verdict does, without its reason: `scaled` of `scaled: backward margin`.
fn verdict_kind(verdict: &str) -> &str {
    verdict.split(':').next().unwrap_or_default().trim()
}

/// Whether a verdict changes a command; before the guard speaks there is none.
pub(crate) fn intervenes(verdict: &str) -> bool {
    !matches!(verdict_kind(verdict), "" | "passed")
}

pub(super) fn guard_figures<'a>(verdicts: impl Iterator<Item = &'a str>) -> GuardFigures {
    let mut figures = GuardFigures::default();
    let mut before = "";
    for kind in verdicts.map(verdict_kind) {
        if kind != before && intervenes(kind) {
            figures.interventions += 1;
            figures.refused += usize::from(kind == "refused");
            figures.scaled += usize::from(kind == "scaled");
        }
        before = kind;
    }
    figures
}
