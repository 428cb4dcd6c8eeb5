//! Tests of settings that clients save in the nodes' flash: with `cargo tool settings` and with
//! python-canopen.

use crate::session::demo::{Demo, command, scenario, summary};
use crate::session::python;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder for the flash of all nodes.
fn flash(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-flash"));
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Starts a run on this flash that waits for a client; returns it and its address.
fn session(name: &str, scenario_name: &str, flash: &Path, blank: bool) -> (Demo, String) {
    let file = scenario(scenario_name);
    let mut arguments = vec!["--scenario", &file, "--nodes", "host"];
    arguments.extend(["--slcan", "127.0.0.1:0", "--flash", text(flash)]);
    arguments.extend(blank.then_some("--blank"));
    let (command, _) = command(name, &arguments);
    let mut demo = Demo::start(command);
    let address = demo.address();
    (demo, address)
}

/// Runs `cargo tool settings`.
fn tool(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tool"))
        .arg("settings")
        .args(arguments)
        .output()
        .expect("the tool starts")
}

fn succeeds(arguments: &[&str]) -> String {
    let output = tool(arguments);
    assert!(output.status.success(), "{arguments:?}: {output:?}");
    String::from_utf8(output.stdout).expect("text")
}

/// Ends a run.
fn end(mut demo: Demo) {
    demo.signal("INT");
    demo.end();
}

/// Runs the first seconds of level ground without clients; returns the hash of the run.
fn state_hash(name: &str, flash: &Path, blank: bool) -> String {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.toml"));
    let level = fs::read_to_string(scenario("flat")).expect("the scenario");
    let short = |line: &str| {
        if line.starts_with("duration_s") {
            "duration_s = 4.0".to_owned()
        } else {
            line.to_owned()
        }
    };
    let lines: Vec<_> = level.lines().map(short).collect();
    fs::write(&file, lines.join("\n")).expect("written");
    let mut arguments = vec!["--scenario", text(&file), "--nodes", "host"];
    arguments.extend(["--flash", text(flash)]);
    arguments.extend(blank.then_some("--blank"));
    let (command, out) = command(name, &arguments);
    Demo::start(command).end();
    let hash = summary(&out)["state_hash"].clone();
    hash.as_str().expect("a hash").to_owned()
}

#[test]
fn settings_restored_onto_blank_nodes_make_the_next_run_bit_identical() {
    let (original, restored) = (flash("original"), flash("restored"));
    let backup = Path::new(env!("CARGO_TARGET_TMPDIR")).join("backup.toml");
    let (demo, address) = session("dump", "client", &original, false);
    let bus = ["--slcan", &address];
    let node = ["--slcan", &address, "--node", "2"];
    // A gain that the scenario does not have.
    let set = [&["set"], &node[..], &["velocity_gain", "2500", "--save"]].concat();
    assert!(succeeds(&set).contains("velocity_gain = 2500 mA s/rad"));
    let refused = tool(&[&["set"], &node[..], &["velocity_gain", "-1"]].concat());
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(error.contains("below the minimum"), "{error}");
    succeeds(&[&["dump"], &bus[..], &[text(&backup)]].concat());
    end(demo);
    let dumped = fs::read_to_string(&backup).expect("the backup");
    assert_eq!(dumped.matches("[[node]]").count(), 5, "{dumped}");
    assert!(
        dumped.contains("velocity_gain = 2500 # mA s/rad"),
        "{dumped}"
    );

    let (demo, address) = session("restore", "client", &restored, true);
    succeeds(&["restore", "--slcan", &address, text(&backup)]);
    end(demo);
    let expected = state_hash("original", &original, false);
    assert_eq!(state_hash("restored", &restored, true), expected);
    // Without the changed gain the run is another one.
    assert_ne!(state_hash("other", &flash("other"), false), expected);
}

/// Connects to the run as python-canopen and adds the left track.
const CONNECT: &str = "
import canopen, sys, time
from canopen.sdo import SdoClient
SdoClient.RESPONSE_TIMEOUT = 5
network = canopen.Network()
network.connect(interface='slcan', channel='socket://' + sys.argv[1], bitrate=1_000_000)
track = network.add_node(2, 'docs/eds/axle.eds')
track.nmt.wait_for_heartbeat()
time.sleep(0.5)
";

const SAVE_A_GAIN: &str = "
gain = track.sdo['velocity_gain']
assert gain.od.max == 1_000_000, gain.od.max
gain.raw = 2222
track.store()
# A gain is in force at once.
assert track.sdo['Settings in flash']['Restart needed'].raw == 0
";

const READ_THE_GAIN: &str = "
assert track.sdo['Settings in flash']['State at start'].raw == 1
print(track.sdo['velocity_gain'].raw)
";

const SAVE_WHILE_ENABLED: &str = "
end = time.time() + 60
while track.sdo['Statusword'].raw & 0x6f != 0x27:
    assert time.time() < end, 'the drive is not enabled'
    time.sleep(0.05)
try:
    track.store()
    print('saved')
except canopen.SdoAbortedError as error:
    print(hex(error.code), error)
";

#[test]
fn python_saves_a_gain_and_finds_it_after_a_power_cycle() {
    let folder = flash("python");
    let client = |name, scenario: &str, program: &str| {
        let (demo, address) = session(name, scenario, &folder, false);
        let output = python::run(&["-c", &format!("{CONNECT}{program}"), &address]);
        end(demo);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("text")
    };
    client("python-saves", "client", SAVE_A_GAIN);
    let read = client("python-reads", "client", READ_THE_GAIN);
    assert_eq!(read.trim(), "2222");
    // The operator of this scenario arms the robot.
    let refused = client("python-refused", "flat", SAVE_WHILE_ENABLED);
    assert!(
        refused.contains("0x8000022") && refused.contains("present device state"),
        "{refused}"
    );
}
