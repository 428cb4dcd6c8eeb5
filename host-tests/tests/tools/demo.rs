//! Tests the command `cargo demo` as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tautrack_host_tests::programs::setup::checkout;

fn demo(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_demo"))
        .args(arguments)
        .output()
        .expect("the demo starts")
}

fn scenario(name: &str) -> String {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    format!("{}/host-tests/scenarios/{name}.toml", root.display())
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn writes_summary_log_and_report_and_ends_well() {
    let out = folder("flat");
    let flat = scenario("flat");
    let output = demo(&[
        "--nodes",
        "host",
        "--scenario",
        &flat,
        "--out",
        out.to_str().expect("text"),
    ]);
    assert!(output.status.success(), "{output:?}");
    let text = std::fs::read_to_string(out.join("summary.json")).expect("summary.json");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for key in [
        "landed",
        "toppled",
        "landing_time_s",
        "simulated_s",
        "wall_s",
        "realtime_factor",
        "steps",
        "nodes",
        "tension_error_m",
        "pitch_deg",
        "min_backward_margin_m",
        "guard",
        "bus",
        "faults",
        "state_hash",
    ] {
        assert!(summary.get(key).is_some(), "{key} is missing in {text}");
    }
    assert_eq!(summary["nodes"].as_array().map(Vec::len), Some(5));
    assert!(
        std::fs::read(out.join("run.mcap"))
            .expect("run.mcap")
            .starts_with(b"\x89MCAP0\r\n")
    );
    let report = std::fs::read_to_string(out.join("report.html")).expect("report.html");
    assert!(report.contains("<html") && report.contains("flat"));
}

#[test]
fn an_expectation_that_does_not_hold_is_exit_status_1() {
    let out = folder("kept-up");
    let kept_up = scenario("staircase-front-kept-up");
    let output = demo(&[
        "--nodes",
        "host",
        "--guard",
        "off",
        "--scenario",
        &kept_up,
        "--out",
        out.to_str().expect("text"),
    ]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(
        String::from_utf8_lossy(&output.stdout).contains("toppled"),
        "{output:?}"
    );
}

#[test]
fn bad_scenario_files_are_named_before_anything_starts_with_exit_status_2() {
    let good = std::fs::read_to_string(scenario("staircase")).expect("shipped");
    let cases: &[(&str, String, &[&str])] = &[
        ("empty", String::new(), &["is empty"]),
        (
            "wrong-type",
            good.replace("friction = 1.0", "friction = \"rough\""),
            &["friction"],
        ),
        (
            "negative-riser",
            good.replace("riser_m = 0.15", "riser_m = -0.15"),
            &["riser_m", "-0.15"],
        ),
        (
            "short-belt",
            good.replace("k_m = 1.232", "k_m = 0.7"),
            &["k_m", "0.7", "0.78"],
        ),
        (
            "unknown-key",
            good.replace("friction = 1.0", "friction = 1.0\nfricton = 2.0"),
            &["fricton"],
        ),
        (
            "nan",
            good.replace("friction = 1.0", "friction = nan"),
            &["friction", "NaN"],
        ),
    ];
    for (name, text, expected) in cases {
        let file = folder("bad").join(format!("{name}.toml"));
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
        std::fs::write(&file, text).expect("written");
        let output = demo(&["--scenario", file.to_str().expect("text")]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {error}");
        assert!(
            !String::from_utf8_lossy(&output.stdout).contains("building"),
            "{name}: something started"
        );
        for word in *expected {
            assert!(
                error.to_lowercase().contains(&word.to_lowercase()),
                "{name}: {error} lacks {word}"
            );
        }
    }
}

#[test]
fn a_missing_file_and_an_unknown_switch_are_exit_status_2() {
    for arguments in [
        &["--scenario", "no-such-file.toml"][..],
        &["--no-such-switch"],
    ] {
        let output = demo(arguments);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
    }
}
