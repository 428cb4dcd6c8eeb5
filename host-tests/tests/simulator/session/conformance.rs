//! Runs the table of exchanges of CiA 301 and CiA 402 against emulated nodes, with python-canopen.

use crate::conformance::notation::{Request, Step};
use crate::conformance::{Row, drive};
use crate::session::demo::{Demo, command};
use crate::session::python;
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::Kind;

/// Returns a step as the program reads it. `None` if no client of a bus can do it: a client turns
/// no rotor, and a request takes it a millisecond.
fn step(step: &Step) -> Option<Value> {
    let (send, wait_ms) = match &step.request {
        Request::Send(frames) => (frames.as_slice(), 0),
        Request::Wait { time, exact: false } => (&[][..], *time),
        Request::Wait { exact: true, .. } | Request::Turn => return None,
    };
    let frame = |id: u16, data: Value| json!({ "id": id, "data": data });
    let send = send.iter().map(|it| frame(it.id(), it.data().into()));
    let answers = step.answers.iter();
    let answers = answers.map(|it| frame(it.id, json!(it.bytes)));
    Some(json!({
        "text": step.text,
        "send": send.collect::<Vec<_>>(),
        "wait_ms": wait_ms,
        "answers": answers.collect::<Vec<_>>(),
    }))
}

/// Returns a row as the program reads it. `None` for one that no client of a bus can run.
fn row(row: &Row) -> Option<Value> {
    let steps: Option<Vec<_>> = row.steps.iter().map(step).collect();
    Some(json!({ "name": row.name, "steps": steps? }))
}

/// Scenario in which only one node of a robot lives.
fn alone(kind: Kind, node: &str, section: &str) -> String {
    let mut text = format!(
        "name = \"alone\"\nabout = \"One node.\"\nseed = 1\nduration_s = 600.0\nfriction = 1.0\n\
         terrain = \"flat\"\noperator = \"client\"\n{section}\n"
    );
    for (name, _) in kind
        .facts()
        .nodes
        .iter()
        .filter(|(name, _)| name.as_str() != node)
    {
        let what = format!("what = {{ node_dead = \"{name}\" }}");
        let _ = writeln!(text, "[[fault]]\n{what}\nat_s = 0.0\n");
    }
    text
}

/// Serial number of the emulated board of node 5: the seed of the run, and the node's place.
const SERIAL: u32 = 0x0001_0004;

/// Runs the table of this role against the node of this scenario.
fn run(name: &str, kind: Kind, scenario: &str, role: drive::Role) {
    kind.programs(Board::Qemu)
        .unwrap_or_else(|error| panic!("{error}"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = |ending: &str, text: &str| {
        let path = folder.join(format!("{name}.{ending}"));
        fs::write(&path, text).expect("written");
        path.display().to_string()
    };
    let all = drive::rows(role, SERIAL);
    let table: Vec<_> = all.iter().filter_map(row).collect();
    println!(
        "{name}: {} of {} rows run on the bus",
        table.len(),
        all.len()
    );
    let table = file("json", &Value::from(table).to_string());
    let scenario = file("toml", scenario);
    let arguments = [
        "--scenario",
        &scenario,
        "--slcan",
        "127.0.0.1:0",
        "--speed",
        "20",
    ];
    let mut demo = Demo::start(command(name, &arguments).0);
    let program = "host-tests/tests/simulator/session/conformance.py";
    let output = python::run(&[program, &demo.address(), &table]);
    let differences = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && differences.is_empty(),
        "{differences}{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn an_emulated_axle_answers_as_the_standards_say() {
    let settings = "[robot.rt_mover]\n[settings.rear_right_wheel]\nsync_period = 4000\n";
    let scenario = alone(Kind::RtMover, "rear_right_wheel", settings);
    run(
        "conformance-axle",
        Kind::RtMover,
        &scenario,
        drive::Role::Axle,
    );
}

#[test]
fn an_emulated_screw_answers_as_the_standards_say() {
    let scenario = alone(Kind::B2p2, "screw", "");
    run(
        "conformance-screw",
        Kind::B2p2,
        &scenario,
        drive::Role::Screw,
    );
}
