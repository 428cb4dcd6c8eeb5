//! What came out of the hazard suite.

use super::evaluation::Row;

/// What came out of the suite.
pub struct Findings {
    /// The scenarios that have files, in the order of their names, hazards first.
    pub named: Vec<Row>,
    /// Seed of the drawn ones.
    pub seed: u64,
    /// The drawn ones, by number, hazards first.
    pub drawn: [Drawn; 2],
}

/// Drawn runs of one kind.
#[derive(Default)]
pub struct Drawn {
    /// One for each number from 0.
    pub rows: Vec<Row>,
    /// Draws that were no runs of the kind and were drawn again.
    pub redrawn: u64,
}

impl Findings {
    /// Every row.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        let drawn = self.drawn.iter().flat_map(|drawn| &drawn.rows);
        self.named.iter().chain(drawn)
    }

    /// Whether every row holds.
    pub fn all_hold(&self) -> bool {
        self.rows().all(|row| row.unmet.is_empty())
    }
}
