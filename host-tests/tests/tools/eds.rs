//! Tests of the data sheets in docs/eds and of examples/ros2/bus.yml with other projects' tools:
//! lely's dcf-tools, on which `ros2_canopen` is built, eds-utils and python-canopen. Without Python
//! and `PyPI` they are skipped.

use crate::docs::root;
use crate::python;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tautrack::bus::drive_parameters::{is_restricted, supports};
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::tools::generate::dictionary::model::DefaultValue;
use tautrack_host_tests::tools::generate::dictionary::{ROLES, load};

/// dcfgen uses `pkg_resources` of setuptools, which newer versions do not have.
const PACKAGES: [&str; 5] = [
    "canopen==2.4.1",
    "dcf-tools==2.4.2",
    "eds-utils==0.3.1",
    "empy==4.2.1",
    "setuptools==75.8.0",
];

/// Returns a program of these packages; `None` without Python.
fn tool(name: &str) -> Option<PathBuf> {
    let interpreter = python::python("python-eds", &PACKAGES)?;
    Some(interpreter.with_file_name(name))
}

/// Runs a program in docs/eds; returns what it prints. Fails if it fails or warns.
fn clean(program: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(program);
    let output = command
        .args(arguments)
        .current_dir(root().join("docs/eds"))
        .output()
        .expect("the program starts");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && error.is_empty(),
        "{} {arguments:?}: {error}",
        program.display()
    );
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn lely_and_eds_utils_find_nothing_wrong_in_a_data_sheet() {
    let (Some(dcfchk), Some(validate)) = (tool("dcfchk"), tool("eds-validate")) else {
        return;
    };
    for role in ROLES {
        let file = format!("{role}.eds");
        assert_eq!(clean(&dcfchk, &["--node_id", "5", &file]), "");
        assert_eq!(clean(&validate, &[&file]), "");
    }
}

/// Prints each mapped value of each PDO: whether it is received, its size in the mapping, and what
/// the data sheet says about it.
const MAPPED: &str = "
import canopen, json, sys
dictionary = canopen.import_od(sys.argv[1], node_id=5)
rows = []
for received, first in (True, 0x1600), (False, 0x1A00):
    for index in (index for index in dictionary if first <= index < first + 0x200):
        for sub in range(1, dictionary[index][0].default + 1):
            value = dictionary[index][sub].default
            entry = dictionary.get_variable(value >> 16, value >> 8 & 0xFF)
            row = entry.qualname, received, value & 0xFF
            rows.append([*row, len(entry), entry.pdo_mappable, entry.access_type])
print(json.dumps(rows))
";

#[test]
fn python_canopen_finds_every_mapped_value_with_its_size_and_direction() {
    let Some(python) = tool("python") else { return };
    for role in ROLES {
        let printed = clean(&python, &["-c", MAPPED, &format!("{role}.eds")]);
        let rows: Vec<Value> = serde_json::from_str(&printed).expect("JSON");
        assert!(rows.len() > 10, "{role}: {printed}");
        for row in rows {
            let access = if row[1] == true { "rww" } else { "ro" };
            assert_eq!(row[3], row[2], "size: {row}");
            assert_eq!(json!([row[4], row[5]]), json!([true, access]), "{row}");
        }
    }
}

/// A line that is longer than CiA 306 allows, or that has a second `=`, breaks some readers.
#[test]
fn the_lines_of_a_data_sheet_are_short_and_have_one_equals_sign() {
    for role in ROLES {
        let path = root().join(format!("docs/eds/{role}.eds"));
        for line in fs::read_to_string(path).expect("the data sheet").lines() {
            let right = line.len() <= 255 && line.matches('=').count() <= 1;
            assert!(right && line.is_ascii(), "{role}: {line}");
        }
    }
}

/// The limits are the extremes of what the drive supports. The default of some objects means that
/// nothing was chosen.
#[test]
fn the_limits_of_an_object_are_those_of_the_drive() {
    let mut limited = 0;
    for role in ["axle", "screw"] {
        let dictionary = load(&root().join("shared/dictionary"), role).expect("the dictionary");
        for object in &dictionary.objects {
            let entry = &object.entries[0];
            let index = object.index;
            assert_eq!(entry.limits.is_some(), is_restricted(index), "{index:#x}");
            let Some([low, high]) = entry.limits else {
                continue;
            };
            let accepts = |value: i64| {
                entry.default == DefaultValue::Number(value) || supports(index, value as i32)
            };
            assert!(accepts(low) && accepts(high), "{index:#x}");
            let bounds = entry.data_type.bounds().expect("an integer");
            for value in (-40_000..40_000).filter(|value| bounds.contains(value)) {
                let inside = (low..=high).contains(&value);
                assert!(inside || !accepts(value), "{index:#x}: {value}");
            }
            limited += 1;
        }
    }
    assert_eq!(limited, 2 * 10);
}

/// Prints the nodes of bus.yml, and from the configuration of the master: start-up, assignments of
/// the nodes (without the number of retries), consumed heartbeats, and the identifiers of its RPDOs
/// and TPDOs that are in use.
const MASTER: &str = "
import dcf, json, sys, yaml
with open(sys.argv[1]) as file:
    bus = yaml.safe_load(file)
nodes = {name: [node['node_id'], node['dcf']] for name, node in bus.items() if 'dcf' in node}
master = dcf.Device.from_dcf(sys.argv[2], {'NODEID': 127})
def elements(index):
    entries = master.get(index, {}).items()
    values = {sub: entry.parse_value() for sub, entry in entries if sub}
    return {sub: value for sub, value in values.items() if value}
assigned = {node: value & 0xFF for node, value in elements(0x1F81).items()}
def identifiers(pdos):
    return sorted(pdo.cob_id & 0x7FF for pdo in pdos.values() if not pdo.cob_id >> 31)
start = master[0x1F80][0].parse_value()
pdos = identifiers(master.rpdo), identifiers(master.tpdo)
print(json.dumps([nodes, start, assigned, elements(0x1016), *pdos]))
";

#[test]
fn dcfgen_makes_a_master_that_commands_the_guard_alone() {
    let (Some(dcfgen), Some(python)) = (tool("dcfgen"), tool("python")) else {
        return;
    };
    let bus = root().join("examples/ros2/bus.yml").display().to_string();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("dcfgen");
    fs::create_dir_all(&folder).expect("a folder");
    let out = folder.display().to_string();
    clean(&dcfgen, &["--remote-pdo", "--directory", &out, &bus]);
    let master = folder.join("master.dcf").display().to_string();
    let printed = clean(&python, &["-c", MASTER, &bus, &master]);
    let printed: Value = serde_json::from_str(&printed).expect("JSON");

    let mut nodes = json!({});
    let (mut assigned, mut received) = (json!({}), vec![0x381, 0x385, 0x481, 0x681, 0x6b1]);
    for (name, id) in Kind::B2p2.facts().nodes {
        let role = match name.as_str() {
            name @ ("guard" | "screw") => name,
            _ => "axle",
        };
        nodes[name.as_str()] = json!([id, format!("{role}.eds")]);
        // A node of the network (bit 0) that is not booted (bit 2) and not reset (bit 4).
        assigned[id.to_string()] = json!(0x11);
        received.extend([0x180, 0x280].map(|function| function + u32::from(*id)));
    }
    received.sort_unstable();
    // A master (bit 0) that starts no node (bit 3) and resets none that is silent. It sends the
    // operator's command, and no set-point of a drive.
    assert_eq!(
        printed,
        json!([nodes, 0x09, assigned, {}, received, [0x201]])
    );
}
