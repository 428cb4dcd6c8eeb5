//! Lists, gets, sets, dumps and restores settings.

use super::arguments::Command;
use super::backup::{Backup, Node};
use super::client::Client;
use super::error::ToolError;
use crate::tools::generate::tables::effect;
use std::io::{self, Write};
use tautrack::settings::{Effect, FIRST_OBJECT, MEANINGS, Setting, TABLE};

const SAVE: u16 = 0x1010;

/// Runs the command.
///
/// # Errors
/// [`ToolError`].
pub(in crate::tools) fn run(command: Command) -> Result<(), ToolError> {
    match command {
        Command::List => list(),
        Command::Get { node, name } => {
            let setting = find(&name)?;
            let value = read(&mut Client::open(&node.bus.slcan)?, node.node, setting)?;
            say(&with_unit(setting, value));
        }
        Command::Set {
            node,
            name,
            value,
            save,
        } => {
            let setting = find(&name)?;
            let mut client = Client::open(&node.bus.slcan)?;
            write(&mut client, node.node, setting, value)?;
            say(&with_unit(setting, read(&mut client, node.node, setting)?));
            say(match setting.effect() {
                Effect::Restart => "the node uses it after a save and a restart",
                Effect::Gain | Effect::Limit | Effect::Disarmed => "a drive uses it now",
            });
            if save {
                self::save(&mut client, node.node)?;
                say("saved");
            }
        }
        Command::Dump { bus, file } => {
            let backup = dump(&mut Client::open(&bus.slcan)?)?;
            backup.write(&file)?;
            say(&format!("read {} nodes", backup.node.len()));
        }
        Command::Restore { bus, file } => {
            let backup = Backup::read(&file)?;
            backup.check(&file)?;
            restore(&mut Client::open(&bus.slcan)?, &backup)?;
            say(&format!(
                "restored {} nodes; they use the settings after a restart",
                backup.node.len()
            ));
        }
    }
    Ok(())
}

/// Prints a line. The standard output may be a pipe that its reader has closed.
fn say(line: &str) {
    let _ = writeln!(io::stdout(), "{line}");
}

fn list() {
    for (row, meaning) in TABLE.iter().zip(MEANINGS) {
        say(&format!(
            "{} [{}] {} to {}, default {}, takes effect {}\n    {meaning}",
            row.name,
            row.unit,
            row.minimum,
            row.maximum,
            row.default,
            effect(row.effect)
        ));
    }
}

fn dump(client: &mut Client) -> Result<Backup, ToolError> {
    let mut backup = Backup { node: Vec::new() };
    for id in client.nodes()? {
        let identity = client.identity(id)?;
        let mut settings = std::collections::BTreeMap::new();
        for row in TABLE {
            let setting = find(row.name)?;
            settings.insert(row.name.to_owned(), read(client, id, setting)?);
        }
        backup.node.push(Node {
            id,
            identity,
            settings,
        });
    }
    if backup.node.is_empty() {
        return Err(ToolError::NoNodes);
    }
    Ok(backup)
}

fn restore(client: &mut Client, backup: &Backup) -> Result<(), ToolError> {
    client.end_configuration()?;
    let present = client.nodes()?;
    let (nodes, missing): (Vec<_>, Vec<_>) = backup
        .node
        .iter()
        .partition(|node| present.contains(&node.id));
    // Before anything is written.
    for node in nodes {
        let found = client.identity(node.id)?;
        if found[..2] != node.identity[..2] {
            return Err(ToolError::OtherProduct {
                node: node.id,
                found: found[1],
                expected: node.identity[1],
            });
        }
        if found[3] != node.identity[3] {
            say(&format!(
                "node {} has serial number {}, not {}: another board",
                node.id, found[3], node.identity[3]
            ));
        }
    }
    for node in missing {
        client.configure(node.id, node.identity)?;
    }
    for node in &backup.node {
        for (name, value) in &node.settings {
            write(client, node.id, find(name)?, *value)?;
        }
        save(client, node.id)?;
    }
    Ok(())
}

fn save(client: &mut Client, node: u8) -> Result<(), ToolError> {
    client.write(node, SAVE, 1, u32::from_le_bytes(*b"save"))
}

fn read(client: &mut Client, node: u8, setting: Setting) -> Result<i32, ToolError> {
    let value = client.read(node, object(setting), 0)?;
    Ok(value as i32)
}

fn write(client: &mut Client, node: u8, setting: Setting, value: i32) -> Result<(), ToolError> {
    client.write(node, object(setting), 0, value as u32)
}

fn object(setting: Setting) -> u16 {
    FIRST_OBJECT + setting.description().key
}

fn find(name: &str) -> Result<Setting, ToolError> {
    Setting::from_name(name).ok_or_else(|| ToolError::UnknownSetting(name.to_owned()))
}

fn with_unit(setting: Setting, value: i32) -> String {
    let row = setting.description();
    format!("{} = {value} {}", row.name, row.unit)
}
