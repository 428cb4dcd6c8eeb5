//! File with the settings of all nodes of a bus.

use super::client::Identity;
use super::error::ToolError;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use tautrack::settings::Setting;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Backup {
    pub node: Vec<Node>,
}

/// The settings of one node, by name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Node {
    pub id: u8,
    pub identity: Identity,
    pub settings: BTreeMap<String, i32>,
}

impl Backup {
    pub fn read(path: &Path) -> Result<Self, ToolError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| ToolError::File(path.to_owned(), error))?;
        toml::from_str(&text).map_err(|error| ToolError::NoBackup(path.to_owned(), error))
    }

    /// The text of the file, with the unit behind each value.
    pub fn text(&self) -> String {
        let mut text =
            "# Settings of the nodes of one bus, by `cargo tool settings dump`.\n".to_owned();
        for node in &self.node {
            let Node { id, identity, .. } = node;
            let _ = write!(text, "\n[[node]]\nid = {id}\n");
            let _ = write!(
                text,
                "# vendor, product code, revision, serial number\nidentity = {identity:?}\n[node.settings]\n"
            );
            for (name, value) in &node.settings {
                let unit =
                    Setting::from_name(name).map_or("", |setting| setting.description().unit);
                let _ = writeln!(text, "{name} = {value} # {unit}");
            }
        }
        text
    }
}
