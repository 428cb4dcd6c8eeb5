//! Tests the program `cargo evaluate`: its results match the vectors, and it reports errors in a
//! document.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Write;
use std::process::{Command, Output, Stdio};
use tautrack_host_tests::tools::evaluate::{Precision, evaluate};

/// One step of 2^-24 m, the resolution of the screw.
const LSB: f64 = 1.0 / 16_777_216.0;

fn vectors(group: &str) -> Value {
    let path = format!("{}/vectors/{group}.json", env!("CARGO_MANIFEST_DIR"));
    let mut document: Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let functions = document["functions"].as_object_mut().unwrap();
    // The file contains its own check of the driving force; `shared/tests/robots/crawler_model.rs`
    // has another one.
    if let Some(Value::Array(cases)) = functions.get_mut("driving_force") {
        for case in cases {
            case["out"].as_object_mut().unwrap().remove("Pn_quadrature");
        }
    }
    document
}

/// Error that is allowed in double precision, relative to the number, or absolute for numbers below
/// 1. Results that use a pseudo-inverse are less accurate by its condition number.
fn allowed_f64(component: &str) -> f64 {
    match component {
        "state.dU_dqa_total" | "control.xp_dot" | "control.omega" | "control.gamma_des"
        | "control.gamma_dot" => 1e-8,
        _ => 1e-10,
    }
}

fn run(arguments: &[&str], document: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_evaluate"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text = document.to_owned();
    let writer = std::thread::spawn(move || {
        // A program that does not accept its arguments does not read its input.
        let _ = stdin.write_all(text.as_bytes());
    });
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

/// Collects pairs (computed, expected) of all numbers in `got` and `want`, by the name of the
/// output component.
fn collect(name: &str, got: &Value, want: &Value, into: &mut BTreeMap<String, Vec<[f64; 2]>>) {
    match (got, want) {
        (Value::Object(got), Value::Object(want)) => {
            assert!(got.keys().eq(want.keys()), "{name}: {got:?} {want:?}");
            for (member, want) in want {
                let path = format!("{name}.{member}");
                collect(&path, &got[member], want, into);
            }
        }
        (Value::Array(got), Value::Array(want)) => {
            assert_eq!(got.len(), want.len(), "{name}");
            for (got, want) in got.iter().zip(want) {
                collect(name, got, want, into);
            }
        }
        (Value::Null, Value::Null) => {}
        (Value::Bool(got), Value::Bool(want)) => assert_eq!(got, want, "{name}"),
        _ => into.entry(name.to_owned()).or_default().push([
            got.as_f64()
                .unwrap_or_else(|| panic!("{name}: {got} {want}")),
            want.as_f64()
                .unwrap_or_else(|| panic!("{name}: {got} {want}")),
        ]),
    }
}

fn compare(computed: &Value, expected: &Value) -> BTreeMap<String, Vec<[f64; 2]>> {
    let mut pairs = BTreeMap::new();
    for (name, cases) in expected["functions"].as_object().unwrap() {
        for (index, case) in cases.as_array().unwrap().iter().enumerate() {
            let other = &computed["functions"][name][index];
            assert_eq!(other["in"], case["in"], "the inputs come back");
            collect(name, &other["out"], &case["out"], &mut pairs);
        }
    }
    pairs
}

/// The document without any `out`, so that the program cannot return the expected ones.
fn without_outputs(document: &Value) -> Value {
    let mut stripped = document.clone();
    for cases in stripped["functions"].as_object_mut().unwrap().values_mut() {
        for case in cases.as_array_mut().unwrap() {
            case.as_object_mut().unwrap().remove("out");
        }
    }
    stripped
}

fn check(group: &str, precision: Precision, computed: &Value) {
    for (name, pairs) in compare(computed, &vectors(group)) {
        let largest = pairs
            .iter()
            .fold(0.0f64, |all, [_, want]| all.max(want.abs()));
        let worst = pairs.iter().fold(0.0f64, |all, [got, want]| {
            let allowed = match precision {
                Precision::F64 => allowed_f64(&name) * want.abs().max(1.0),
                Precision::F32 => 1e-4 * largest,
            };
            let difference = (got - want).abs();
            assert!(difference <= allowed, "{name}: {got} {want}");
            all.max(difference)
        });
        println!(
            "{group} {precision:?} {name}: {worst:.2e} of {largest:.3}, {} numbers",
            pairs.len()
        );
    }
}

#[test]
fn every_model_meets_the_vectors_in_both_precisions() {
    for group in [
        "b2p2_fk_com",
        "b2p2_dynamics",
        "b2p2_clearance",
        "b2p2_zmp",
        "crawler",
        "hylos_margin",
        "hylos_control",
        "rt_mover",
    ] {
        let document = without_outputs(&vectors(group)).to_string();
        for (precision, flag) in [(Precision::F64, "f64"), (Precision::F32, "f32")] {
            let output = run(&["--scalar", flag, "-"], &document);
            assert!(output.status.success(), "{output:?}");
            let computed = serde_json::from_slice(&output.stdout).unwrap();
            check(group, precision, &computed);
            assert_eq!(evaluate(&document, precision).unwrap(), computed);
        }
    }
}

#[test]
fn the_screw_meets_the_vectors_to_its_resolution() {
    let path = format!("{}/vectors/b2p2_screw.json", env!("CARGO_MANIFEST_DIR"));
    for flag in ["f32", "f64"] {
        let output = run(&["--scalar", flag, &path], "");
        assert!(output.status.success(), "{output:?}");
        let computed = serde_json::from_slice(&output.stdout).unwrap();
        for (name, pairs) in compare(&computed, &vectors("b2p2_screw")) {
            let worst = pairs
                .iter()
                .fold(0.0f64, |all, [a, b]| all.max((a - b).abs()));
            println!("{name}: {worst:.2e}");
            let allowed = match name.as_str() {
                "screw.r" | "screw.l3" | "screw.L_axle1_axle3" => LSB,
                "screw.dl3_dtheta" => 1e-6,
                "screw.d2l3_dtheta2" if flag == "f64" => 1e-10,
                "screw.d2l3_dtheta2" => 1e-6,
                "screw.inverse_abs_theta" => 5e-6,
                _ => panic!("{name}"),
            };
            assert!(worst <= allowed, "{flag} {name}: {worst:e}");
        }
    }
}

#[test]
fn single_precision_is_what_runs_unless_asked() {
    let document = without_outputs(&vectors("b2p2_zmp")).to_string();
    let output = run(&["-"], &document);
    let computed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(evaluate(&document, Precision::F32).unwrap(), computed);
    assert_ne!(evaluate(&document, Precision::F64).unwrap(), computed);
}

/// Runs a document that is refused, checks exit status and output, and returns the standard error.
fn refusal(document: &str) -> String {
    let output = run(&["-"], document);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

#[test]
fn a_refusal_names_what_is_wrong() {
    let good = without_outputs(&vectors("b2p2_fk_com"));
    let changed = |change: fn(&mut Value)| {
        let mut document = good.clone();
        change(&mut document);
        refusal(&document.to_string())
    };
    for (error, words) in [
        (changed(|d| d["group"] = json!("b2p3")), "\"b2p3\""),
        (changed(|d| d["functions"]["ik"] = json!([])), "\"ik\""),
        (
            changed(|d| d["functions"]["fk_com"][3]["in"] = json!({})),
            "functions.fk_com[3].in.q is missing",
        ),
        (
            changed(|d| d["functions"]["fk_com"][1]["in"]["q"][7] = json!("x")),
            "functions.fk_com[1].in.q[7] must be a number",
        ),
        (
            changed(|d| d["functions"]["fk_com"][1]["in"]["q"] = json!([0.0])),
            "functions.fk_com[1].in.q must be an array of 8, not of 1",
        ),
        (
            changed(|d| drop(d["params"].as_object_mut().unwrap().remove("mass"))),
            "params.mass is missing",
        ),
        (
            changed(|d| d["params"]["mass"][1] = json!(0.0)),
            "params is refused: Mass { segment: 2, got: 0.0 }",
        ),
        (
            changed(|d| d["params"]["inertia_origin"][2][0][0] = json!(0.04)),
            "params is refused: InertiaImpossible { segment: 3 }",
        ),
        (
            refusal("{\"group\": \"b2p2_zmp\",\n  \"params\": }"),
            "line 2 column 13",
        ),
        (refusal("[]"), "the document must be an object"),
    ] {
        assert!(error.contains(words), "{error}");
    }
    let output = run(&["no-such-file.json"], "");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("no-such-file.json")
    );
}

#[test]
fn a_margin_needs_three_or_four_contacts() {
    let mut document = without_outputs(&vectors("hylos_margin"));
    document["functions"]["margins"][2]["in"]["contacts_cw"] = json!([[0, 0, 0], [1, 0, 0]]);
    let error = refusal(&document.to_string());
    assert!(error.contains("margins[2].in.contacts_cw"), "{error}");
}
