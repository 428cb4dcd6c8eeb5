//! Tests of Python programs that join the robot's bus, as docs/bus.md and examples/ show them.

use crate::session::demo::{Demo, command, scenario, send, summary};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::sync::OnceLock;
use std::thread::sleep;
use std::time::Duration;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::robots::Kind;

/// Packages to install; docs/bus.md lists the same.
const PACKAGES: [&str; 2] = ["python-can[serial]==4.6.1", "canopen==2.4.1"];

fn root() -> &'static Path {
    checkout::root().unwrap_or_else(|error| panic!("{error}"))
}

/// Returns Python with [`PACKAGES`], in a virtual environment that is created once and kept in
/// `target`.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = root().join("target/python-clients");
        let python = folder.join("bin/python");
        let mark = folder.join("installed.txt");
        let packages = PACKAGES.join("\n");
        if fs::read_to_string(&mark).is_ok_and(|installed| installed == packages) {
            return python;
        }
        let _ = fs::remove_dir_all(&folder);
        install(&folder, &python);
        fs::write(mark, packages).expect("written");
        python
    })
}

/// Creates the environment with its own pip, or with the system's pip if Python has no ensurepip.
fn install(folder: &Path, python: &Path) {
    let succeeds = |command: &mut Command| {
        let output = command.output();
        output.is_ok_and(|output| output.status.success())
    };
    let venv = |arguments: &[&str]| {
        let mut command = Command::new("python3");
        succeeds(command.args(["-m", "venv"]).args(arguments).arg(folder))
    };
    let mut pip = if venv(&["--clear"]) {
        Command::new(python)
    } else {
        assert!(
            venv(&["--clear", "--without-pip"]),
            "this test needs Python 3 with venv; type (Debian, Ubuntu): sudo apt-get install python3-venv"
        );
        Command::new("python3")
    };
    pip.args(["-m", "pip"]);
    if pip.get_program() == "python3" {
        pip.arg("--python").arg(python);
    }
    let installed = pip.arg("install").args(PACKAGES).output();
    let failure = match installed {
        Ok(output) if output.status.success() => return,
        Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
        Err(error) => error.to_string(),
    };
    panic!(
        "pip installs no {PACKAGES:?}; it needs PyPI, and pip (apt-get install python3-pip): {failure}"
    );
}

/// Runs a Python program in the root of the checkout.
pub fn run(arguments: &[&str]) -> Output {
    Command::new(python())
        .current_dir(root())
        .args(arguments)
        .output()
        .expect("python starts")
}

/// Waits until a demo with QEMU nodes waits for its first client; returns the demo and its address.
fn waiting(mut demo: Demo) -> (Demo, String) {
    let address = demo.address();
    (demo, address)
}

fn build() {
    python();
    Kind::B2p2
        .programs(Board::Qemu)
        .unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn the_example_drives_the_robot_through_its_guard() {
    build();
    let client = scenario("client");
    let (command, out) = command("driven", &["--scenario", &client, "--slcan", "127.0.0.1:0"]);
    let (mut demo, address) = waiting(Demo::start(command));
    let example = run(&["examples/python/drive.py", &address]);
    let printed = String::from_utf8_lossy(&example.stdout);
    assert!(example.status.success(), "{example:?}");
    assert!(
        printed.contains("margins in mm: back") && printed.contains("done"),
        "{printed}"
    );
    let (status, output, error) = demo.end();
    assert!(status.success(), "{status}: {output}{error}");
    let summary = summary(&out);
    assert_eq!(summary["clients"], 1);
    assert_eq!(summary["toppled"], false);
    assert_eq!(summary["stopped"], true);
    // One metre according to the belts' encoders, a braking distance, and the motion during homing.
    let driven_m = summary["driven_m"].as_f64().expect("a number");
    assert!(driven_m > 0.9 && driven_m < 1.3, "{driven_m} m");
    for node in summary["nodes"].as_array().expect("a list") {
        assert_eq!(node["board"], "mps2", "{node}");
    }
}

/// Last line of numbers that `examples/python/bench.py` prints with these arguments for node 2 of
/// this scenario.
fn on_the_bench(name: &str, scenario: &str, arguments: &[&str]) -> String {
    build();
    let (command, _) = command(name, &["--scenario", scenario, "--slcan", "127.0.0.1:0"]);
    let (_demo, address) = waiting(Demo::start(command));
    let output = run(&[&["examples/python/bench.py", &address], arguments].concat());
    assert!(output.status.success(), "{output:?}");
    let printed = String::from_utf8(output.stdout).expect("a text");
    printed.lines().last().expect("a line").to_owned()
}

/// The number behind `word` in `line`.
fn number(line: &str, word: &str) -> f64 {
    let (_, rest) = line.split_once(word).expect(word);
    let first = rest.split_whitespace().next().expect("a number");
    first
        .parse()
        .unwrap_or_else(|error| panic!("{error}: {line}"))
}

#[test]
fn the_bench_program_turns_one_motor_without_a_guard() {
    let line = on_the_bench("turned", &scenario("bench"), &["--velocity", "0.5"]);
    assert!((number(&line, "velocity") - 0.5).abs() < 0.05, "{line}");
    assert!(number(&line, "position") > 0.05, "{line}");
    assert!((number(&line, "supply") - 24.0).abs() < 0.5, "{line}");
}

/// The scenario of the bench with this motor of node 2, and with these settings of it.
fn bench_with(motor: &str, settings: &str) -> String {
    let text = fs::read_to_string(scenario("bench")).expect("the scenario");
    let (before, after) = text
        .split_once("calibration_current = 7000\n")
        .expect("settings");
    format!("{before}{settings}{after}\n[motor.left_track]\n{motor}")
}

/// The bench program waits while the drive aligns the rotor.
#[test]
fn the_bench_program_turns_a_three_phase_motor_with_an_incremental_encoder() {
    let text = bench_with(
        "kind = \"pmsm\"\nresistance_ohm = 0.3\ninductance_d_h = 0.0003\n\
         inductance_q_h = 0.0003\nflux_wb = 0.00381\npole_pairs = 7\n",
        "rotor_sensor = 1\nalignment_current = 8000\nalignment_travel = 100\nvelocity_limit = 3000\n",
    );
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("three-phases.toml");
    fs::write(&path, text).expect("written");
    let path = path.display().to_string();
    let line = on_the_bench("aligned", &path, &["--velocity", "0.5"]);
    assert!((number(&line, "velocity") - 0.5).abs() < 0.05, "{line}");
}

/// The step of docs/hardware.md in which a resistor and a choke stand for the motor. The model of
/// the winding has no ripple, so this does not show what the choke is for.
#[test]
fn the_bench_program_drives_a_resistor_with_the_asked_current() {
    let text = bench_with(
        "kind = \"dc\"\nresistance_ohm = 4.7\ninductance_d_h = 0.001\nflux_wb = 0.00001\n",
        "resistance = 4700\ninductance = 1000\nbench_current = 1500\ntorque_constant = 40000\n",
    );
    let path = root().join("target/resistor.toml");
    fs::write(&path, text).expect("a file");
    let path = path.to_str().expect("a text");
    let line = on_the_bench("resistor", path, &["--current", "1.0"]);
    assert!((number(&line, "current") - 1.0).abs() < 0.03, "{line}");
    assert!(number(&line, "velocity").abs() < 0.01, "{line}");
}

/// A client that only listens. While it is there, the run goes on when other clients leave.
const LISTENER: &str = "\
import can, sys
bus = can.Bus(interface='slcan', channel='socket://' + sys.argv[1], bitrate=1_000_000)
while True:
    bus.recv()
";

/// A Python program while it runs.
struct Program {
    child: Child,
    output: BufReader<ChildStdout>,
}

impl Program {
    /// Starts the program with these arguments in the root of the checkout.
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(python())
            .current_dir(root())
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("python starts");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        Self { child, output }
    }

    /// The `count`th line from now.
    fn line(&mut self, count: usize) -> String {
        let mut line = String::new();
        for _ in 0..count {
            line.clear();
            self.output.read_line(&mut line).expect("text");
        }
        line
    }

    fn send(&self, signal: &str) {
        send(signal, &self.child.id().to_string());
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A run of this scenario, which goes on when clients leave, and its address.
fn bench_run(name: &str, scenario: &str) -> (Demo, Program, String) {
    build();
    let (command, _) = command(name, &["--scenario", scenario, "--slcan", "127.0.0.1:0"]);
    let (demo, address) = waiting(Demo::start(command));
    let listener = Program::start(&["-c", LISTENER, &address]);
    (demo, listener, address)
}

/// The drive loses its set-points when the program is stopped for a second, and when it is killed.
#[test]
fn however_the_bench_program_ends_the_motor_has_no_current() {
    let (_demo, _listener, address) = bench_run("ended", &scenario("bench"));
    let bench = ["examples/python/bench.py", &address];
    for (signals, status) in [
        (["INT"].as_slice(), Some(130)),
        (&["TERM"], Some(130)),
        (&["STOP", "CONT"], Some(1)),
        (&["KILL"], None),
    ] {
        let turning = ["--current", "0.3", "--seconds", "600"];
        let mut program = Program::start(&[bench.as_slice(), &turning].concat());
        assert!(number(&program.line(2), "current").abs() > 0.1);
        for signal in signals {
            program.send(signal);
            if *signal == "STOP" {
                sleep(Duration::from_secs(1));
            }
        }
        let ended = program.child.wait().expect("its end");
        assert_eq!(ended.code(), status, "{signals:?}");
        let seen = run(&[bench.as_slice(), &["--seconds", "0.1"]].concat());
        let line = String::from_utf8_lossy(&seen.stdout);
        assert!(
            number(&line, "current").abs() < 0.02,
            "{signals:?}: {seen:?}"
        );
    }
}

#[test]
fn the_bench_program_refuses_what_the_drive_cannot_do() {
    let (_demo, _listener, address) = bench_run("refused", &scenario("bench"));
    for (arguments, why) in [
        (["--current", "nan"].as_slice(), "nan is no finite number"),
        (&["--current", "3"], "bench_current allows 2.0 A"),
        (&["--velocity=-7"], "bench_speed allows 1.0 rad/s"),
        (&["--current", "1e-5"], "the smallest current is"),
        (&["--node", "0"], "allowed 1 to 127"),
        (&["--node", "5", "--current", "1"], "which is no axle"),
        (&["--seconds", "0"], "allowed above 0"),
    ] {
        let output = run(&[&["examples/python/bench.py", &address], arguments].concat());
        assert!(!output.status.success(), "{arguments:?}");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(error.contains(why), "{error}");
        assert!(!error.contains("Traceback"), "{error}");
    }
}

#[test]
fn the_calibration_program_measures_and_saves() {
    let (_demo, _listener, address) = bench_run("calibrated", &scenario("bench"));
    let program = ["examples/python/calibrate.py", &address, "--free", "--save"];
    let output = run(&program);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    let resistance = number(&text, "resistance =");
    assert!((resistance - 600.0).abs() < 30.0, "{text}");
    assert!(
        (number(&text, "inductance =") - 300.0).abs() < 30.0,
        "{text}"
    );
    assert!(text.contains("saved"), "{text}");
}

#[test]
fn the_program_on_the_page_about_the_bus_reads_a_position() {
    build();
    let page = fs::read_to_string(root().join("docs/bus.md")).expect("docs/bus.md");
    for package in PACKAGES {
        assert!(
            page.contains(package),
            "the page does not install {package}"
        );
    }
    let (_, program) = page.split_once("```python\n").expect("a program");
    let (program, _) = program.split_once("```").expect("its end");
    let (command, _) = command(
        "page",
        &["--scenario", &scenario("flat"), "--slcan", "127.0.0.1:0"],
    );
    let (_demo, address) = waiting(Demo::start(command));
    // The page's port may be in use.
    let program = program.replace("127.0.0.1:3333", &address);
    assert!(program.contains(&address), "{program}");
    // The first request may be lost while the nodes start, and the nodes may be slow while other
    // tests run.
    let timeout = "from canopen.sdo import SdoClient\nSdoClient.RESPONSE_TIMEOUT = 5\n";
    let output = run(&["-c", &format!("{timeout}{program}")]);
    assert!(output.status.success(), "{output:?}");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.trim().parse::<i32>().is_ok(), "{printed}");
}

/// Prints whether node 4 answers a client that only listens, and then whether it answers one that
/// does not. Both first receive a frame. The second sets the bit rate by the registers.
const LISTEN_ONLY: &str = "\
import can, sys, time
def answered(**options):
    channel = 'socket://' + sys.argv[1]
    with can.Bus(interface='slcan', channel=channel, **options) as bus:
        assert bus.recv(60)
        end = time.monotonic() + 3
        while time.monotonic() < end:
            data = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]
            bus.send(can.Message(arbitration_id=0x604, is_extended_id=False, data=data))
            frame = bus.recv(1)
            while frame and time.monotonic() < end:
                if frame.arbitration_id == 0x584 and frame.data[1:3] == b'\\x00\\x10':
                    return True
                frame = bus.recv(0)
    return False
timing = can.BitTiming.from_registers(8_000_000, btr0=0x00, btr1=0x14)
print(answered(bitrate=1_000_000, listen_only=True), answered(timing=timing))
";

#[test]
fn python_can_in_listen_only_mode_receives_frames_and_sends_none() {
    python();
    let flat = scenario("flat");
    let arguments = ["--scenario", &flat, "--nodes", "host"];
    let arguments = [
        &arguments[..],
        &["--slcan", "127.0.0.1:0", "--speed", "0.5"],
    ]
    .concat();
    let (command, _) = command("listening", &arguments);
    let (_demo, address) = waiting(Demo::start(command));
    let output = run(&["-c", LISTEN_ONLY, &address]);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert_eq!(printed.trim(), "False True", "{output:?}");
}

/// A client of CiA 402 that homes the chassis joint, falls silent, and resets the fault.
const DRIVE_PROFILE: &str = "
import sys, time
import canopen
from canopen.profiles.p402 import BaseNode402
network = canopen.Network()
network.connect(interface='slcan', channel='socket://' + sys.argv[1], bitrate=1_000_000)
node = BaseNode402(4, 'docs/eds/axle.eds')
network.add_node(node)
network.sync.start(0.004)
node.nmt.state = 'OPERATIONAL'
node.setup_402_state_machine()
commands = node.rpdo_pointers[0x6040].pdo_parent
commands.start(0.01)
node.sdo['Bench mode'].raw = 1
print(node.homing(timeout=60), node.state)
commands.stop()
time.sleep(1.5)
node.check_statusword()
print(node.state, hex(node.sdo['Error code'].raw))
commands.start(0.01)
node.sdo['Bench mode'].raw = 1
node.reset_from_fault()
print(node.state, hex(node.sdo['Error code'].raw))
network.sync.stop()
commands.stop()
network.disconnect()
";

/// python-canopen, unmodified, homes a drive and resets its fault.
#[test]
fn a_client_of_the_drive_profile_homes_a_drive_and_resets_its_fault() {
    let text = fs::read_to_string(scenario("bench")).expect("the scenario");
    let patient = "[settings.chassis_joint]\ncommand_timeout = 1000\n\n[expect]";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("patient-bench.toml");
    fs::write(&path, text.replace("[expect]", patient)).expect("written");
    let (_demo, _listener, address) = bench_run("profile", path.to_str().expect("UTF-8"));
    let client = run(&["-c", DRIVE_PROFILE, &address]);
    let printed = String::from_utf8_lossy(&client.stdout);
    let expected = "True OPERATION ENABLED\nFAULT 0x8250\nOPERATION ENABLED 0x0\n";
    assert_eq!(printed, expected, "{client:?}");
}
