//! Tests that every dependency has a licence that deny.toml allows, and that NOTICE names the
//! dependencies whose licences demand it.

use serde_json::Value;
use spdx::{Expression, ParseMode};
use std::fs;
use std::path::Path;
use std::process::Command;
use tautrack_host_tests::programs::setup::checkout;

fn root() -> &'static Path {
    checkout::root().unwrap()
}

fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

#[test]
fn every_licence_is_allowed() {
    let deny = fs::read_to_string(root().join("deny.toml")).unwrap();
    let list = deny
        .split("allow = [")
        .nth(1)
        .unwrap()
        .split(']')
        .next()
        .unwrap();
    let allowed: Vec<&str> = list.split('"').skip(1).step_by(2).collect();
    for package in packages() {
        let name = &package["name"];
        let licence = package["license"]
            .as_str()
            .unwrap_or_else(|| panic!("{name} states no licence"));
        let expression = Expression::parse_mode(licence, ParseMode::LAX).unwrap();
        let fits =
            expression.evaluate(|requirement| allowed.contains(&requirement.to_string().as_str()));
        assert!(fits, "{name}: {licence} is not in deny.toml");
    }
}

#[test]
fn notice_names_every_package_under_the_mozilla_licence() {
    let notice = fs::read_to_string(root().join("NOTICE")).unwrap();
    for package in packages() {
        if package["license"] == "MPL-2.0" {
            let line = format!(
                "{} {}",
                package["name"].as_str().unwrap(),
                package["version"].as_str().unwrap()
            );
            assert!(notice.contains(&line), "NOTICE lacks {line}");
        }
    }
}
