//! Reads `host-tests/cost.toml` and the file `cost.toml` of every robot: the ceilings of the counts
//! and of the images.

use super::counts::Count;
use crate::programs::setup::checkout::root;
use crate::robots::Kind;
use clap::ValueEnum;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::path::Path;

/// The content of the files.
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
    /// Reads all files.
    ///
    /// # Errors
    /// A file cannot be read or parsed; the text names the line.
    pub fn read() -> Result<Self, String> {
        let root = root().map_err(|error| error.to_string())?;
        let mut all = Self::of(&root.join("host-tests/cost.toml"))?;
        for kind in Kind::value_variants() {
            let folder = root.join("host-tests/src/robots").join(kind.folder());
            let own = Self::of(&folder.join("cost.toml"))?;
            all.instructions.extend(own.instructions);
            all.flash.extend(own.flash);
            all.ram.extend(own.ram);
        }
        Ok(all)
    }

    fn of(file: &Path) -> Result<Self, String> {
        let place = |error: &dyn Display| format!("{}: {error}", file.display());
        let text = fs::read_to_string(file).map_err(|error| place(&error))?;
        toml::from_str(&text).map_err(|error| place(&error))
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
