//! Writes the generated parts of docs/bus.md as Markdown: the cyclic frames of the default robot
//! with rate and load, the loads of the other robots, the payloads, and all objects.

use super::dictionary::model::{Dictionary, Entry, ObjectCode, Pdo};
use super::tables::{in_italics, sentence};
use super::{ReferenceError, eds};
use crate::programs::setup::checkout::root;
use crate::robots::{Kind, NodeName, NodeSpec};
use crate::scenario::Scenario;
use crate::simulator::bus::wire::{BIT_RATE, worst_case_bits};
use crate::simulator::run::operator::PERIOD_US;
use clap::ValueEnum;
use std::fmt::Write;
use tautrack::bus::network::{self, OFFSET_SYNCS, function};
use tautrack::can::Frame;
use tautrack::settings::Setting;

/// A cyclic frame: it is sent once in every period.
struct Cyclic {
    id: u16,
    sender: String,
    what: String,
    bytes: usize,
    period_us: u64,
}

impl Cyclic {
    fn bits(&self) -> u32 {
        // The number of bits depends only on the length, which is 0 to 8 bytes.
        Frame::new(self.id, &[0; 8][..self.bytes]).map_or(0, |frame| worst_case_bits(&frame))
    }

    fn bits_per_second(&self) -> f64 {
        f64::from(self.bits()) * 1e6 / self.period_us as f64
    }
}

/// Returns the nodes of a robot in its default scenario.
fn nodes(kind: Kind) -> Result<Vec<NodeSpec>, ReferenceError> {
    let path = root()?
        .join("host-tests/scenarios")
        .join(kind.facts().scenario_file);
    Ok(Scenario::load(&path)?.nodes())
}

/// Returns the table of bus loads of the robots other than the default one, by kind of frame.
///
/// # Errors
/// If the default scenario of a robot is missing or invalid.
pub fn others(roles: &[Dictionary]) -> Result<String, ReferenceError> {
    let mut text = "| Robot | Drives | SYNC | Set-points | Motion | Status, heartbeats, guard, operator | All |\n|---|---|---|---|---|---|---|\n".to_owned();
    let others = Kind::value_variants().iter().copied();
    for kind in others.filter(|kind| *kind != Kind::default()) {
        let name = kind.facts().name;
        let nodes = nodes(kind)?;
        let frames = cyclic(roles, kind, &nodes);
        let share = |counts: &dyn Fn(&str) -> bool| {
            let counted = frames.iter().filter(|frame| counts(&frame.what));
            percent(counted.map(Cyclic::bits_per_second).sum())
        };
        let set_point = |what: &str| what.contains("SetPoint");
        let motion = |what: &str| what.contains("DriveMotion");
        let _ = writeln!(
            text,
            "| {name} | {} | {} Hz | {:.1} % | {:.1} % | {:.1} % | **{:.1} %** |",
            nodes.len() - 1,
            1e6 / sync_period_us(&nodes) as f64,
            share(&set_point),
            share(&motion),
            share(&|what| !set_point(what) && !motion(what)),
            share(&|_| true)
        );
    }
    Ok(text)
}

/// Returns the table of the cyclic frames of the default robot with the bus load of each, and the
/// sum.
///
/// # Errors
/// If its default scenario is missing or invalid.
pub fn frames(roles: &[Dictionary]) -> Result<String, ReferenceError> {
    let mut text = "| Identifier | Sender | Frame | Bytes | Bits | Rate | Load |\n|---|---|---|---|---|---|---|\n".to_owned();
    let kind = Kind::default();
    let frames = cyclic(roles, kind, &nodes(kind)?);
    for frame in &frames {
        let _ = writeln!(
            text,
            "| `{:#05x}` | {} | {} | {} | {} | {} Hz | {:.2} % |",
            frame.id,
            frame.sender,
            frame.what,
            frame.bytes,
            frame.bits(),
            1e6 / frame.period_us as f64,
            percent(frame.bits_per_second())
        );
    }
    let sum: f64 = frames.iter().map(Cyclic::bits_per_second).sum();
    let _ = writeln!(
        text,
        "| | | **all** | | | | **{:.1} %** of 1 Mbit/s |",
        percent(sum)
    );
    Ok(text)
}

/// Bus load of so many bits per second, %.
fn percent(bits_per_second: f64) -> f64 {
    bits_per_second / BIT_RATE as f64 * 100.0
}

fn sync_period_us(nodes: &[NodeSpec]) -> u64 {
    let guard = nodes.iter().find(|node| node.name == NodeName::GUARD);
    let own = guard.and_then(|guard| {
        let mut settings = guard.settings.iter();
        settings.find(|(setting, _)| *setting == Setting::SyncPeriod)
    });
    own.map_or(Setting::SyncPeriod.description().default, |(_, value)| {
        *value
    }) as u64
}

/// Returns true if the drive's set-points are velocities, false if they are positions.
fn follows_rates(kind: Kind, name: NodeName) -> bool {
    let mut ends = kind.facts().follow_rates.iter();
    ends.any(|end| name.as_str().ends_with(end))
}

fn cyclic(roles: &[Dictionary], kind: Kind, nodes: &[NodeSpec]) -> Vec<Cyclic> {
    let sync_us = sync_period_us(nodes);
    let heartbeat_us = Setting::HeartbeatPeriod.description().default as u64 * 1_000;
    let mut frames = vec![Cyclic {
        id: network::sync().id(),
        sender: NodeName::GUARD.to_string(),
        what: "SYNC".into(),
        bytes: 0,
        period_us: sync_us,
    }];
    for NodeSpec { name, id, .. } in nodes {
        let (name, node) = (*name, u16::from(*id));
        let guard = NodeName::GUARD.to_string();
        let (role, set_point, sender, set_point_us) = match name {
            NodeName::GUARD => ("guard", 0, "operator".into(), PERIOD_US),
            NodeName::SCREW => ("screw", 0, guard, sync_us),
            _ => (
                "axle",
                usize::from(follows_rates(kind, name)),
                guard,
                sync_us,
            ),
        };
        let Some(role) = roles.iter().find(|known| known.role == role) else {
            continue;
        };
        let mut add = |pdo: &Pdo, what, sender, period_us| {
            frames.push(Cyclic {
                id: pdo.cob_id as u16 + node,
                sender,
                what: format!("{what}: {}", pdo.payload),
                bytes: pdo
                    .mappings
                    .iter()
                    .map(|mapped| usize::from(mapped.size) / 8)
                    .sum(),
                period_us,
            });
        };
        if let Some(Some(pdo)) = role.rpdos.get(set_point) {
            let what = format!("RPDO {} of {name}", set_point + 1);
            add(pdo, what, sender, set_point_us);
        }
        if matches!(name, NodeName::CHASSIS_JOINT | NodeName::SCREW)
            && let Some(Some(pdo)) = role.rpdos.get(2)
        {
            let (what, guard) = (format!("RPDO 3 of {name}"), NodeName::GUARD.to_string());
            add(pdo, what, guard, sync_us * u64::from(OFFSET_SYNCS));
        }
        for (number, pdo) in (1..).zip(&role.tpdos) {
            if let Some(pdo) = pdo {
                let what = format!("TPDO {number}");
                let period_us = sync_us * u64::from(pdo.transmission_type);
                add(pdo, what, name.to_string(), period_us);
            }
        }
        frames.push(Cyclic {
            id: function::HEARTBEAT + node,
            sender: name.to_string(),
            what: "heartbeat".into(),
            bytes: 1,
            period_us: heartbeat_us,
        });
    }
    frames.sort_by_key(|frame| frame.id);
    frames
}

/// Returns each payload of the roles once.
fn known_payloads(roles: &[Dictionary]) -> Vec<&Pdo> {
    let mut known = Vec::<&Pdo>::new();
    for pdo in roles.iter().flat_map(Dictionary::payloads) {
        if !known.iter().any(|other| other.payload == pdo.payload) {
            known.push(pdo);
        }
    }
    known
}

/// Returns one table for each payload: its fields with bytes, object and meaning.
pub fn payloads(roles: &[Dictionary]) -> String {
    let mut text = String::new();
    for pdo in known_payloads(roles) {
        let _ = write!(
            text,
            "### {}\n\n| Bytes | Object | Meaning |\n|---|---|---|\n",
            pdo.payload
        );
        let mut first = 0;
        for mapped in &pdo.mappings {
            let bytes = mapped.size / 8;
            let last = first + bytes - 1;
            let place = if bytes == 1 {
                first.to_string()
            } else {
                format!("{first} to {last}")
            };
            let object = object_name(mapped.value());
            let _ = writeln!(
                text,
                "| {place} | `{object}` | {} |",
                in_italics(&sentence(&mapped.meaning))
            );
            first += bytes;
        }
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

fn object_name(mapped: u32) -> String {
    format!("{:04X}:{:X}", mapped >> 16, mapped >> 8 & 0xff)
}

/// Returns one table of objects for each role. Objects that every `CANopen` node has are left out;
/// the EDS files contain them.
pub fn objects(roles: &[Dictionary]) -> String {
    let mut text = String::new();
    for role in roles {
        let _ = write!(
            text,
            "### {}\n\n| Object | Name | Type | Access | Default | Meaning |\n|---|---|---|---|---|---|\n",
            role.role
        );
        for object in role.objects.iter().filter(|object| object.index >= 0x2000) {
            let mut row = |sub: u8, name: &str, entry: &Entry, default: String| {
                let key = u32::from(object.index) << 16 | u32::from(sub) << 8;
                let meaning = entry.meaning.clone();
                let _ = writeln!(
                    text,
                    "| `{}` | {name} | {} | {} | {default} | {} |",
                    object_name(key),
                    entry.data_type,
                    eds::access_words(entry.access),
                    meaning.unwrap_or_else(|| process_data_meaning(roles, key))
                );
            };
            let (name, elements) = (&object.name, object.elements());
            if let (true, [first, ..]) = (object.is_uniform(), elements) {
                // One row for all elements, which differ only in their sub-indices.
                row(0, name, first, elements.len().to_string());
                continue;
            }
            for entry in elements {
                let name = match object.code {
                    ObjectCode::Var => name,
                    _ => &format!("{name}: {}", entry.name),
                };
                row(entry.sub_index, name, entry, eds::default(&entry.default));
            }
        }
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

/// Returns the meaning of an object that is mapped into a payload; empty for other objects.
fn process_data_meaning(roles: &[Dictionary], key: u32) -> String {
    let payloads = roles.iter().flat_map(Dictionary::payloads);
    payloads
        .flat_map(|pdo| &pdo.mappings)
        .find(|mapped| mapped.value() & 0xffff_ff00 == key)
        .map_or_else(String::new, |mapped| in_italics(&sentence(&mapped.meaning)))
}
