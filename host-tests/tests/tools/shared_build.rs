//! Tests that `cargo demo` and `cargo test` share one build of the dependencies.

use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;
use tautrack_host_tests::programs::setup::checkout;

/// What cargo compiles for a command, except the workspace's own packages: package, target,
/// features and the settings of the profile.
fn compiled(command: &[&str]) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(command)
        .args(["--locked", "--unit-graph", "-Zunstable-options"])
        // The list of what is compiled is an unstable feature of cargo.
        .env("RUSTC_BOOTSTRAP", "1")
        .current_dir(checkout::root().expect("a checkout"))
        .output()
        .expect("cargo starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}:\n{errors}");
    let graph: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let units = graph["units"].as_array().expect("a list");
    let foreign = units.iter().filter(|unit| {
        let package = unit["pkg_id"].as_str().expect("a package");
        !package.starts_with("path+")
    });
    foreign
        .map(|unit| {
            let mut profile = unit["profile"].clone();
            // Tests have a profile of another name and with the same settings.
            profile["name"] = Value::Null;
            let fields = ["pkg_id", "target", "mode", "features"];
            format!(
                "{} {profile}",
                fields.map(|field| unit[field].to_string()).join(" ")
            )
        })
        .collect()
}

#[test]
fn the_demo_needs_no_dependency_that_the_tests_build_otherwise() {
    let demo = compiled(&["build", "-p", "tautrack-host-tests", "--bin", "demo"]);
    let tests = compiled(&["test", "--workspace", "--no-run"]);
    assert!(demo.len() > 100, "{demo:#?}");
    let own: Vec<_> = demo.difference(&tests).collect();
    assert!(own.is_empty(), "{own:#?}");
}
