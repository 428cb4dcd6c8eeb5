//! Reads `host-tests/cost.toml`: the ceilings of the counts and of the images.

use super::counts::Count;
use crate::programs::setup::checkout::root;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs;

/// The content of `cost.toml`.
#[derive(Clone, PartialEq, Eq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ceilings {
    /// Maximum instructions of each function and tick.
    pub instructions: BTreeMap<String, u32>,
    /// Maximum flash memory of each image, bytes.
    pub flash: BTreeMap<String, u32>,
    /// Maximum of static variables and stack of each image, bytes.
    pub ram: BTreeMap<String, u32>,
}

impl Ceilings {
    /// Reads `cost.toml`.
    ///
    /// # Errors
    /// The file cannot be read or parsed; the text names the line.
    pub fn read() -> Result<Self, String> {
        let root = root().map_err(|error| error.to_string())?;
        let text = fs::read_to_string(root.join("host-tests/cost.toml"));
        let text = text.map_err(|error| format!("host-tests/cost.toml: {error}"))?;
        toml::from_str(&text).map_err(|error| format!("host-tests/cost.toml: {error}"))
    }

    /// One line for each ceiling that is exceeded, and for each without a count.
    pub fn excesses(&self, counts: &[Count]) -> Vec<String> {
        let excess = |(name, ceiling): (&String, &u32)| match counts
            .iter()
            .find(|count| count.name == *name)
        {
            None => Some(format!("{name}: a ceiling, but no count")),
            Some(count) => (count.maximum > *ceiling)
                .then(|| format!("{name}: {} instructions, ceiling {ceiling}", count.maximum)),
        };
        self.instructions.iter().filter_map(excess).collect()
    }
}
