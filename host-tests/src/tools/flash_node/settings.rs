//! Collects the settings that a node gets: those of the robot's node, then those of a file, then
//! the node id.

use super::command::{Arguments, Role};
use crate::programs::settings_pages;
use crate::programs::setup::checkout;
use crate::robots::{self, Kind};
use crate::scenario::Scenario;
use crate::tools::settings::Backup;
use std::path::Path;
use std::{fs, io};
use tautrack::motor::board_limits;
use tautrack::settings::{Setting, Settings};

/// Settings to write, each once. Empty if the arguments name none: the pages then stay as they are.
///
/// # Errors
/// A text for the user, which names the bad setting or file.
pub(super) fn collect(arguments: &Arguments) -> Result<Vec<(Setting, i32)>, String> {
    let mut settings = Vec::new();
    match (arguments.robot, arguments.node_id) {
        (Some(robot), Some(id)) => settings = of_robot(robot, id, arguments.role)?,
        (Some(_), None) if arguments.role != Role::Guard => {
            return Err("--robot needs --node-id".to_owned());
        }
        _ => {}
    }
    if let Some(path) = &arguments.settings {
        for (setting, value) in of_file(path, arguments.node_id, arguments.role)? {
            set(&mut settings, setting, value);
        }
    }
    if let Some(id) = arguments.node_id {
        set(&mut settings, Setting::NodeId, id.into());
    }
    let mut checked = Settings::default();
    let limits = arguments.role.limits();
    board_limits::set_defaults(limits, &mut checked);
    for (setting, value) in &settings {
        checked
            .set(setting.description().key, *value)
            .map_err(|error| error.to_string())?;
    }
    board_limits::check(limits, &checked).map_err(|error| error.to_string())?;
    if arguments.role != Role::Guard {
        let largest = settings_pages::motor_board::HIGHEST_SUPPLY;
        board_limits::check_velocity(&checked, largest).map_err(|error| error.to_string())?;
    }
    Ok(settings)
}

fn set(settings: &mut Vec<(Setting, i32)>, setting: Setting, value: i32) {
    settings.retain(|(known, _)| *known != setting);
    settings.push((setting, value));
}

/// Settings of node `id` of the robot in its default scenario.
fn of_robot(robot: Kind, id: u8, role: Role) -> Result<Vec<(Setting, i32)>, String> {
    let facts = robot.facts();
    let path = checkout::root()
        .map_err(|error| error.to_string())?
        .join("host-tests/scenarios")
        .join(facts.scenario_file);
    let scenario = Scenario::load(&path).map_err(|error| error.to_string())?;
    let wanted = match role {
        Role::Axle => robots::Role::Axle,
        Role::Screw => robots::Role::Screw,
        Role::Guard => robots::Role::Guard,
    };
    let mut nodes = scenario.nodes();
    nodes.retain(|node| node.role == wanted);
    let known: Vec<_> = nodes
        .iter()
        .map(|node| format!("{} ({})", node.id, node.name))
        .collect();
    nodes
        .into_iter()
        .find(|node| node.id == id)
        .map(|node| node.settings)
        .ok_or_else(|| {
            let known = match known.as_slice() {
                [] => "none".to_owned(),
                known => known.join(", "),
            };
            let role = role.name();
            format!(
                "node {id} of {} has not the role {role}; these have: {known}",
                facts.name
            )
        })
}

/// Settings in a file: lines `name = value`, or a dump of a bus, of which those of node `id`.
fn of_file(path: &Path, id: Option<u8>, role: Role) -> Result<Vec<(Setting, i32)>, String> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = fs::read_to_string(path).map_err(|error: io::Error| at(&error))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| at(&error))?;
    if table.contains_key("node") {
        return of_dump(path, id, role);
    }
    of_table(table).map_err(|error| at(&error))
}

/// Settings of node `id` in a dump of a bus.
fn of_dump(path: &Path, id: Option<u8>, role: Role) -> Result<Vec<(Setting, i32)>, String> {
    let dump = Backup::read(path).map_err(|error| error.to_string())?;
    dump.check(path).map_err(|error| error.to_string())?;
    let path = path.display();
    let known: Vec<_> = dump.node.iter().map(|node| node.id.to_string()).collect();
    let known = known.join(", ");
    let Some(id) = id else {
        return Err(format!(
            "{path}: name one of its nodes with --node-id: {known}"
        ));
    };
    let node = dump.node.into_iter().find(|node| node.id == id);
    let node = node.ok_or_else(|| format!("{path}: it has no node {id}; it has {known}"))?;
    let (found, wanted) = (node.identity[1], role.product_code());
    if found != wanted {
        let role = role.name();
        return Err(format!(
            "{path}: node {id} has the product code {found}; the role {role} has {wanted}"
        ));
    }
    let settings = node.settings.into_iter();
    Ok(settings
        .filter_map(|(name, value)| Some((Setting::from_name(&name)?, value)))
        .collect())
}

fn of_table(table: toml::Table) -> Result<Vec<(Setting, i32)>, String> {
    table
        .into_iter()
        .map(|(name, value)| {
            let setting = Setting::from_name(&name)
                .ok_or_else(|| format!("no setting has the name {name}"))?;
            let value = value
                .as_integer()
                .and_then(|value| i32::try_from(value).ok())
                .ok_or_else(|| format!("{name} must be an integer of 32 bits"))?;
            Ok((setting, value))
        })
        .collect()
}
