//! Parts of a suite that run on different computers, and their results as files.

use super::Row;
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Part `index` of `count`; the first one has the index 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// The whole suite.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Whether the run with this number belongs to the shard.
    pub fn has(self, number: u64) -> bool {
        number % self.count == self.index - 1
    }

    /// File of the shard's results in `folder`.
    pub fn file(self, folder: &Path, seed: u64) -> PathBuf {
        folder.join(format!(
            "seed-{seed}-shard-{}-of-{}.jsonl",
            self.index, self.count
        ))
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(index, count)| {
            let parts = (index.parse().ok()?, count.parse().ok()?);
            (1..=parts.1).contains(&parts.0).then_some(parts)
        });
        parts
            .map(|(index, count)| Self { index, count })
            .ok_or_else(|| "it must be I/N with I from 1 to N".into())
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Returns a row as a line of JSON.
pub fn line(row: &Row) -> String {
    // A row consists of numbers and texts, which can all be written.
    serde_json::to_string(row).unwrap_or_default() + "\n"
}

/// Reads the results of all shards in `folder`, by seed and number. A run that is there twice
/// counts once.
///
/// # Errors
/// The folder or a file cannot be read, or a line is no result.
pub fn merged(folder: &Path) -> io::Result<Vec<Row>> {
    let mut rows = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_none_or(|name| name != "jsonl") {
            continue;
        }
        for (number, text) in fs::read_to_string(&path)?.lines().enumerate() {
            let row: Row = serde_json::from_str(text).map_err(|error| {
                let place = format!("{}:{}: {error}", path.display(), number + 1);
                io::Error::new(io::ErrorKind::InvalidData, place)
            })?;
            rows.insert((row.seed, row.number), row);
        }
    }
    Ok(rows.into_values().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_belongs_to_exactly_one_shard() {
        for count in 1..7_u64 {
            let shards: Vec<Shard> = (1..=count)
                .map(|index| format!("{index}/{count}").parse().unwrap())
                .collect();
            for number in 0..50 {
                let holders = shards.iter().filter(|shard| shard.has(number)).count();
                assert_eq!(holders, 1, "{number} of {count}");
            }
        }
        for bad in ["0/2", "3/2", "1/0", "1", "a/2", "-1/2"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }

    #[test]
    fn shards_are_merged_by_seed_and_number_and_a_run_counts_once() {
        let folder = std::env::temp_dir().join(format!("tautrack-shards-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let row = |seed: u64, number: u64| {
            let obstacle = r#"{"kind":"ramp","riser_m":0,"run_m":0,"steps":1,"angle_deg":20,
                "friction":1,"k_m":1.2,"payload_kg":0,"heading_deg":0,"end_m":1}"#;
            let text = format!(
                r#"{{"seed":{seed},"number":{number},"about":"","obstacle":{obstacle},
                "margin_mm":30,"ending":"cleared","time_s":9,"interventions":0,
                "attitude_deg":[0,0,0],"least_margin_mm":100,"phases":[],"verdicts":[],
                "simulated_s":9}}"#
            );
            serde_json::from_str::<Row>(&text).unwrap()
        };
        let of = |numbers: &[u64]| -> String {
            let rows = numbers.iter().map(|number| line(&row(1, *number)));
            rows.collect()
        };
        fs::write(folder.join("a.jsonl"), of(&[3, 1])).unwrap();
        fs::write(folder.join("b.jsonl"), of(&[0, 2, 3])).unwrap();
        fs::write(folder.join("c.jsonl"), line(&row(0, 7))).unwrap();
        fs::write(folder.join("table.md"), "no results").unwrap();
        let rows = merged(&folder);
        fs::remove_dir_all(&folder).unwrap();
        let keys: Vec<_> = rows
            .unwrap()
            .iter()
            .map(|row| (row.seed, row.number))
            .collect();
        assert_eq!(keys, [(0, 7), (1, 0), (1, 1), (1, 2), (1, 3)]);
    }
}
