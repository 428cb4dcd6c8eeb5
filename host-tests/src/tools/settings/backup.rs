//! File with the settings of all nodes of a bus.

use super::client::Identity;
use super::error::ToolError;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use tautrack::settings::Setting;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::tools) struct Backup {
    pub node: Vec<Node>,
}

/// The settings of one node, by name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::tools) struct Node {
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

    /// Checks every entry, so that a file with a mistake changes no node.
    ///
    /// # Errors
    /// [`ToolError::BadEntry`] or [`ToolError::UnknownSetting`].
    pub fn check(&self, path: &Path) -> Result<(), ToolError> {
        let bad = |why: String| Err(ToolError::BadEntry(path.to_owned(), why));
        let (mut now, mut later) = (BTreeSet::new(), BTreeSet::new());
        for node in &self.node {
            let id = node.id;
            if !(1..=127).contains(&id) {
                return bad(format!("no node has id {id}"));
            }
            // The id of now, and that after a restart.
            let next = node.settings.get("node_id").map_or(id.into(), |id| *id);
            if !now.insert(id) || !later.insert(next) {
                return bad(format!("two nodes have id {id} or node_id {next}"));
            }
            for (name, value) in &node.settings {
                let setting = Setting::from_name(name)
                    .ok_or_else(|| ToolError::UnknownSetting(name.clone()))?;
                let row = setting.description();
                if !(row.minimum..=row.maximum).contains(value) {
                    let (minimum, maximum) = (row.minimum, row.maximum);
                    return bad(format!(
                        "node {id}, {name} = {value}: allowed {minimum} to {maximum}"
                    ));
                }
            }
        }
        Ok(())
    }

    /// Writes the file. An old one stays as it is until the new one is complete.
    pub fn write(&self, path: &Path) -> Result<(), ToolError> {
        let new = path.with_extension("new");
        let written = std::fs::File::create(&new)
            .and_then(|mut file| {
                file.write_all(self.text().as_bytes())?;
                file.sync_all()
            })
            .and_then(|()| std::fs::rename(&new, path));
        written.map_err(|error| {
            let _ = std::fs::remove_file(&new);
            ToolError::File(path.to_owned(), error)
        })
    }

    /// The text of the file, with the unit behind each value.
    fn text(&self) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Why a backup with these nodes is refused: id and settings of each.
    fn refusal(nodes: &[(u8, &str)]) -> String {
        let mut text = String::new();
        for (id, settings) in nodes {
            let _ = write!(
                text,
                "[[node]]\r\nid = {id}\r\nidentity = [0, 1, 1, {id}]\r\n[node.settings]\r\n{settings}\r\n"
            );
        }
        let backup: Backup = toml::from_str(&text).expect("TOML");
        let result = backup.check(Path::new("backup.toml"));
        result.map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_backup_with_a_mistake_is_refused_as_a_whole() {
        assert_eq!(
            refusal(&[(2, "node_id = 2"), (3, "velocity_gain = 5 # mA s/rad")]),
            ""
        );
        for (nodes, why) in [
            (&[(2, ""), (2, "")][..], "two nodes have id 2"),
            (&[(2, "node_id = 3"), (3, "")], "node_id 3"),
            (&[(0, "")], "no node has id 0"),
            (&[(128, "")], "no node has id 128"),
            (&[(2, ""), (3, "velocity_gian = 5")], "velocity_gian"),
            (
                &[(2, ""), (3, "velocity_gain = -1")],
                "allowed 0 to 1000000",
            ),
        ] {
            let refusal = refusal(nodes);
            assert!(refusal.contains(why), "{refusal}");
        }
    }

    #[test]
    fn a_file_that_cannot_be_written_stays_as_it_is() {
        let folder = std::env::temp_dir().join("tautrack-backup");
        let (file, new) = (folder.join("robot.toml"), folder.join("robot.new"));
        // A folder where the new file is to be.
        std::fs::create_dir_all(&new).expect("a folder");
        std::fs::write(&file, "old").expect("a file");
        let backup = Backup { node: Vec::new() };
        let error = backup.write(&file).expect_err("no file");
        assert!(error.to_string().contains("robot.toml"), "{error}");
        assert_eq!(std::fs::read_to_string(&file).expect("the old file"), "old");
        std::fs::remove_dir(&new).expect("removed");
        backup.write(&file).expect("written");
        let text = std::fs::read_to_string(&file).expect("the new file");
        assert_eq!(text, backup.text());
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
