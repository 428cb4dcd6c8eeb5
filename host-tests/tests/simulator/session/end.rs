//! Tests of runs that cannot start, or that end early.

use crate::session::demo::{Demo, command, scenario, send, summary};
use crate::unchanged::{self, sha256, unless_unchanged};
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tautrack::link::{Start, VERSION};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::{Kind, NodeName};
use tautrack_host_tests::simulator::run::node::Node;

/// Asserts that `arguments` are refused with status 2 before anything is built; returns the error.
fn refusal(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_demo"))
        .args(arguments)
        .output()
        .expect("the demo starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    let built = String::from_utf8_lossy(&output.stdout).contains("building");
    assert!(!built, "{arguments:?}: something is built");
    error
}

#[test]
fn a_folder_that_takes_no_results_is_refused_before_the_run() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-folder");
    fs::write(&file, "a file").expect("written");
    let below = file.join("results").display().to_string();
    for out in [file.display().to_string(), below] {
        let error = refusal(&["--scenario", &scenario("flat"), "--out", &out]);
        assert!(error.contains("--out") && error.contains(&out), "{error}");
    }
}

#[test]
fn a_bad_address_for_clients_is_refused_before_the_run() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let taken = taken
        .local_addr()
        .map(|address| (taken, address.to_string()));
    let (_taken, address) = taken.expect("bound");
    let (command, out) = command("bad-slcan", &[]);
    drop(command);
    let out = out.display().to_string();
    for bad in [
        "nonsense",
        "127.0.0.1",
        "127.0.0.1:99999",
        "192.0.2.1:3333",
        &address,
    ] {
        let error = refusal(&["--slcan", bad, "--out", &out]);
        assert!(error.contains("--slcan") && error.contains(bad), "{error}");
    }
    refusal(&["--slcan-wait", "5", "--out", &out]);
    refusal(&[
        "--slcan",
        "127.0.0.1:0",
        "--slcan-wait",
        "-1",
        "--out",
        &out,
    ]);
}

#[test]
fn a_client_as_operator_without_a_port_is_refused_before_the_run() {
    let error = refusal(&["--scenario", &scenario("client")]);
    assert!(error.contains("--slcan"), "{error}");
}

/// Builds the nodes, so that the time is not part of the test.
fn build(board: Board) {
    Kind::B2p2
        .programs(board)
        .unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn an_interrupted_run_keeps_what_it_recorded() {
    build(Board::Host);
    let flat = scenario("flat");
    let arguments = ["--nodes", "host", "--speed", "1", "--scenario", &flat];
    let (command, out) = command("interrupted", &arguments);
    let mut demo = Demo::start(command);
    demo.line_with("flat:");
    sleep(Duration::from_secs(4));
    demo.signal("INT");
    let (status, output, error) = demo.end();
    assert_eq!(status.code(), Some(130), "{status}: {error}");
    assert!(
        error.contains("interrupted") && error.contains("the results end at"),
        "{error}"
    );
    assert!(output.contains("state hash"), "no table: {output}");
    let summary = summary(&out);
    assert!(
        summary["ended_early"]
            .as_str()
            .is_some_and(|why| why.contains("interrupted"))
    );
    assert_eq!(summary["expectation_met"], false);
    let simulated_s = summary["simulated_s"].as_f64().expect("a number");
    assert!(simulated_s > 0.0 && simulated_s < 11.0, "{simulated_s} s");
    let log = fs::read(out.join("run.mcap")).expect("run.mcap");
    let magic = b"\x89MCAP0\r\n";
    assert!(log.starts_with(magic) && log.ends_with(magic));
    let index = mcap::Summary::read(&log).expect("readable");
    let statistics = index.and_then(|index| index.stats).expect("statistics");
    let topics = statistics.channel_message_counts.values();
    // Truth, bus and drives have one message each per sample, and there is one of /tf in four.
    let samples = (simulated_s * 100.0 + 1e-6).floor() as u64;
    assert_eq!(topics.filter(|count| **count == samples).count(), 3);
    let report = fs::read_to_string(out.join("report.html")).expect("report.html");
    assert!(report.contains("</html>"));
}

#[test]
fn an_interrupt_ends_the_wait_for_a_client() {
    build(Board::Host);
    let client = scenario("client");
    let arguments = [
        "--nodes",
        "host",
        "--slcan",
        "127.0.0.1:0",
        "--scenario",
        &client,
    ];
    let (command, _) = command("interrupted-wait", &arguments);
    let mut demo = Demo::start(command);
    demo.address();
    sleep(Duration::from_secs(1));
    demo.signal("INT");
    let (status, _, error) = demo.end();
    assert_eq!(status.code(), Some(130), "{error}");
}

#[test]
fn a_recording_that_cannot_be_written_ends_the_run_and_the_summary_says_so() {
    build(Board::Host);
    let flat = scenario("flat");
    let (command, out) = command("too-large", &["--nodes", "host", "--scenario", &flat]);
    // No file may exceed 128 KiB (256 KiB if the shell counts in KiB).
    let mut limited = Command::new("sh");
    limited
        .args(["-c", "trap '' XFSZ; ulimit -f 256; exec \"$0\" \"$@\""])
        .arg(command.get_program())
        .args(command.get_args());
    let (status, output, error) = Demo::start(limited).end();
    assert_eq!(status.code(), Some(1), "{output}{error}");
    assert!(error.contains("run.mcap is not complete"), "{error}");
    assert!(output.contains("state hash"), "no table: {output}");
    let summary = summary(&out);
    let why = summary["ended_early"].as_str().unwrap_or_default();
    assert!(
        why.contains("run.mcap is not complete: File too large"),
        "{why}"
    );
    let simulated_s = summary["simulated_s"].as_f64().expect("a number");
    assert!(simulated_s > 0.0 && simulated_s < 12.0, "{simulated_s} s");
}

#[test]
fn a_standard_output_that_closes_does_not_lose_the_results() {
    build(Board::Host);
    let flat = scenario("flat");
    let (mut command, out) = command("closed", &["--nodes", "host", "--scenario", &flat]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut demo = command.spawn().expect("the demo starts");
    let output = BufReader::new(demo.stdout.take().expect("piped"));
    let begun = |line: &Result<String, _>| line.as_ref().is_ok_and(|it| it.starts_with("flat:"));
    assert!(output.lines().any(|line| begun(&line)), "no line");
    // The reader of the output is gone now.
    let ended = demo.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{error}");
    assert!(
        error.contains("cannot write to the standard output: Broken pipe"),
        "{error}"
    );
    assert_eq!(summary(&out)["simulated_s"], 12.0);
    assert!(out.join("report.html").exists());
}

/// The flat scenario with another duration.
#[cfg(target_os = "linux")]
fn lasting(duration_s: u32) -> String {
    let text = fs::read_to_string(scenario("flat")).expect("shipped");
    let text = text.replace("duration_s = 12.0", &format!("duration_s = {duration_s}.0"));
    let name = format!("flat-{duration_s}.toml");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&file, text).expect("written");
    file.display().to_string()
}

/// Maximum of the memory of the demo in a run of this duration, kB.
#[cfg(target_os = "linux")]
fn peak_memory_kb(duration_s: u32) -> u64 {
    let scenario = lasting(duration_s);
    let arguments = ["--nodes", "host", "--scenario", &scenario];
    let (mut command, out) = command("memory", &arguments);
    let mut demo = command.stdout(Stdio::null()).spawn().expect("it starts");
    let status = format!("/proc/{}/status", demo.id());
    let mut peak = 0;
    while demo.try_wait().expect("it runs").is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let figure = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let figure = figure.and_then(|it| it.trim().trim_end_matches(" kB").parse().ok());
        peak = figure.unwrap_or(peak);
        sleep(Duration::from_millis(5));
    }
    assert_eq!(summary(&out)["simulated_s"], f64::from(duration_s));
    fs::remove_dir_all(&out).expect("removed");
    peak
}

#[test]
#[ignore = "runs for minutes; docs/testing.md has the complete campaigns"]
#[cfg(target_os = "linux")]
fn a_longer_demo_needs_no_more_memory() {
    let programs = Kind::B2p2.programs(Board::Host);
    let nodes = unchanged::nodes(&programs.unwrap_or_else(|error| panic!("{error}")));
    let demo = fs::read(env!("CARGO_BIN_EXE_demo")).expect("the demo");
    let inputs = nodes.into_iter().chain([sha256(&demo)]);
    unless_unchanged("memory-of-a-demo", inputs, || {
        // The page has the size of a minute from then on.
        let [shorter, longer] = [62, 92].map(peak_memory_kb);
        // Half a minute of samples and frames in memory would be 3.5 MB.
        assert!(longer < shorter + 2_000, "{shorter} and {longer} kB");
        assert!(longer < 60 * 1024, "{longer} kB");
    });
}

/// The disk is a small one in memory and fills up during the run.
#[test]
fn a_disk_that_fills_up_ends_the_run_and_does_not_lose_the_summary() {
    let in_memory = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script]);
        command
    };
    let mount = "mount -t tmpfs -o size=1m none \"$0\"";
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("small-disk");
    fs::create_dir_all(&place).expect("made");
    let possible = in_memory(mount).arg(&place).output();
    if !possible.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: this computer lets no user mount a disk in memory (unshare)");
        return;
    }
    build(Board::Host);
    let flat = scenario("flat");
    let arguments = ["--nodes", "host", "--speed", "2", "--scenario", &flat];
    let (command, copied) = command("full-disk", &arguments);
    fs::create_dir_all(&copied).expect("made");
    // Results go to the small disk, which another process fills; then the summary is copied from
    // it.
    let script = format!(
        "{mount} || exit 99; (sleep 4; cat /dev/zero > \"$0/filler\") 2>/dev/null & \
         \"$@\" --out \"$0/out\"; status=$?; cp \"$0/out/summary.json\" '{}'; exit $status",
        copied.display()
    );
    let mut full = in_memory(&script);
    let arguments = command
        .get_args()
        .take_while(|argument| *argument != "--out");
    full.arg(&place).arg(command.get_program()).args(arguments);
    let (status, output, error) = Demo::start(full).end();
    assert_eq!(status.code(), Some(1), "{output}{error}");
    for file in ["run.mcap", "report.html"] {
        assert!(
            error.contains(&format!("{file} is not complete: ")),
            "{error}"
        );
    }
    assert!(error.contains("No space left on device"), "{error}");
    let why = summary(&copied)["ended_early"].clone();
    assert!(
        why.as_str()
            .is_some_and(|why| why.contains("No space left on device")),
        "{why}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_stopped_emulator_is_named_within_its_timeout_and_the_run_is_kept() {
    build(Board::Qemu);
    let flat = scenario("flat");
    let arguments = ["--node-timeout", "5", "--speed", "1", "--scenario", &flat];
    let (command, out) = command("stopped", &arguments);
    let mut demo = Demo::start(command);
    let machine = demo.last_node("guard").to_string();
    send("STOP", &machine);
    let began = Instant::now();
    let (status, _, error) = demo.end();
    assert_eq!(status.code(), Some(1), "{error}");
    assert!(error.contains("node guard: no answer for 5 s"), "{error}");
    assert!(
        began.elapsed() < Duration::from_secs(30),
        "{:?}",
        began.elapsed()
    );
    let why = summary(&out)["ended_early"].clone();
    assert!(
        why.as_str().is_some_and(|why| why.contains("guard")),
        "{why}"
    );
    assert!(out.join("run.mcap").exists() && out.join("report.html").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn a_node_that_is_killed_is_named_without_last_words() {
    build(Board::Qemu);
    let flat = scenario("flat");
    let arguments = ["--speed", "1", "--scenario", &flat];
    let (command, out) = command("killed", &arguments);
    let mut demo = Demo::start(command);
    // The guard is the last one to start.
    let guard = demo.last_node("guard").to_string();
    send("KILL", &guard);
    let (status, _, error) = demo.end();
    assert_eq!(status.code(), Some(1), "{error}");
    assert!(
        error.contains("node guard: its program ended (signal: 9"),
        "{error}"
    );
    assert!(!error.contains("last words"), "{error}");
    let summary = summary(&out);
    assert!(
        summary["ended_early"]
            .as_str()
            .is_some_and(|why| why.contains("guard"))
    );
}

#[test]
fn a_program_without_the_role_is_refused() {
    for board in [Board::Host, Board::Qemu] {
        let programs = Kind::B2p2.programs(board);
        let programs = programs.unwrap_or_else(|error| panic!("{error}"));
        let start = Start {
            version: VERSION,
            seed: 1,
            flash: heapless::String::new(),
            settings: heapless::Vec::new(),
            motor: None,
            role: "wheel".try_into().expect("a short name"),
        };
        let path = &programs.nodes.path;
        let node = Node::start(NodeName::SCREW, board, path, start);
        let error = node.err().expect("a robot without wheels").to_string();
        assert!(error.contains("the program has no role: wheel"), "{error}");
    }
}
