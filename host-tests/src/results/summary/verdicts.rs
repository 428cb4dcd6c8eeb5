//! Counts the guard's interventions in the verdicts that it published.

use serde::Serialize;

/// How often the guard changed the operator's commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GuardFigures {
    /// Number of times that the guard changed from passing commands unchanged to anything else, or
    /// from one kind of intervention to another.
    pub interventions: usize,
    /// Number of these in which it refused the command.
    pub refused: usize,
    /// Number of these in which it scaled the command down.
    pub scaled: usize,
}

/// The kind of a verdict, without its reason: `scaled` for `scaled: backward margin`.
fn verdict_kind(verdict: &str) -> &str {
    verdict.split(':').next().unwrap_or_default().trim()
}

/// Whether a verdict changes a command. The verdict is empty until the guard publishes one.
pub(crate) fn intervenes(verdict: &str) -> bool {
    !matches!(verdict_kind(verdict), "" | "passed")
}

/// Interventions so far.
#[derive(Default)]
pub(super) struct Interventions {
    pub figures: GuardFigures,
    /// Kind of the last verdict.
    kind: String,
}

impl Interventions {
    pub fn add(&mut self, verdict: &str) {
        let kind = verdict_kind(verdict);
        if kind == self.kind {
            return;
        }
        if intervenes(kind) {
            self.figures.interventions += 1;
            self.figures.refused += usize::from(kind == "refused");
            self.figures.scaled += usize::from(kind == "scaled");
        }
        kind.clone_into(&mut self.kind);
    }
}
