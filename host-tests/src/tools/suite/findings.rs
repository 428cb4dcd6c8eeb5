//! Results of the hazard suite.

use super::evaluation::Row;

/// Results of the hazard suite.
pub struct Findings {
    /// Rows of the scenarios that have files, in the order of their names, hazards first.
    pub named: Vec<Row>,
    /// Seed of the drawn scenarios.
    pub seed: u64,
    /// Drawn scenarios, hazards first.
    pub drawn: [Drawn; 2],
}

/// Drawn scenarios of one kind.
#[derive(Default)]
pub struct Drawn {
    /// One row for each number from 0.
    pub rows: Vec<Row>,
    /// Number of draws that were not of this kind and were drawn again.
    pub redrawn: u64,
}

impl Findings {
    /// All rows.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        let drawn = self.drawn.iter().flat_map(|drawn| &drawn.rows);
        self.named.iter().chain(drawn)
    }

    /// Whether every row holds, which means that it has no unmet requirement.
    pub fn all_hold(&self) -> bool {
        self.rows().all(|row| row.unmet.is_empty())
    }
}
