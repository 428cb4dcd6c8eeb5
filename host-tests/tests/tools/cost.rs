//! Tests the cost of the control code on the core, and that the control ticks reach no forbidden
//! functions.

use crate::unchanged::{digests, emulator};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::OnceLock;
use std::{env, fs};
use tautrack_host_tests::programs::{self, Board};
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::tools::cost;
use tautrack_host_tests::tools::cost::{Measurement, image, ledger, page};

/// A measurement, and what it was made of.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Version of QEMU and digests of the programs.
    of: Vec<String>,
    measurement: Measurement,
}

/// Measures, unless the same QEMU has measured the same programs: the counts would be the same, and
/// they take two minutes. `TAUTRACK_SWEEPS` set to anything always measures.
fn measurement() -> &'static Measurement {
    static MEASUREMENT: OnceLock<Measurement> = OnceLock::new();
    MEASUREMENT.get_or_init(|| {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("measurement.json");
        let of = measured();
        let kept: Option<Kept> = fs::read(&place)
            .ok()
            .and_then(|text| serde_json::from_slice(&text).ok());
        if let Some(kept) = kept.filter(|kept| kept.of == of)
            && env::var_os("TAUTRACK_SWEEPS").is_none()
        {
            return kept.measurement;
        }
        let measurement = cost::measure().unwrap_or_else(|error| panic!("{error}"));
        let kept = Kept { of, measurement };
        fs::write(place, serde_json::to_vec(&kept).expect("plain numbers")).expect("a file");
        kept.measurement
    })
}

/// Version of QEMU and digests of the programs that a measurement depends on.
fn measured() -> Vec<String> {
    let instruments = programs::instruments().unwrap_or_else(|error| panic!("{error}"));
    let [axle, screw] = programs::drives().unwrap_or_else(|error| panic!("{error}"));
    let guard = Kind::B2p2
        .programs(Board::Qemu)
        .unwrap_or_else(|error| panic!("{error}"))
        .nodes;
    let programs = [&instruments.cost, &instruments.ticks, &axle, &screw, &guard];
    [emulator()].into_iter().chain(digests(programs)).collect()
}

#[test]
fn every_kernel_keeps_its_ceiling_and_its_pinned_count() {
    let ledger = ledger::read().expect("cost.toml");
    let violations = ledger::violations(measurement(), &ledger);
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

#[test]
fn the_page_is_what_a_run_gives() {
    let ledger = ledger::read().expect("cost.toml");
    if measurement().rustc != ledger.rustc {
        eprintln!(
            "skipped: docs/cost.md was made with rustc {}, this is {}",
            ledger.rustc,
            measurement().rustc
        );
        return;
    }
    let written = fs::read_to_string(page::path().expect("a checkout")).expect("docs/cost.md");
    assert!(
        written == page::page(measurement(), &ledger),
        "docs/cost.md is not what a run gives; if that is meant: cargo cost --write"
    );
}

/// Parts of the names of functions that no control tick may reach, and what these functions are.
const FORBIDDEN: [(&str, &str); 12] = [
    ("__aeabi_d", "double precision in software"),
    ("__aeabi_f2d", "double precision in software"),
    ("df3", "double precision in software"),
    ("ldivmod", "64-bit division"),
    ("divdi3", "64-bit division"),
    ("moddi", "64-bit division"),
    ("divti3", "128-bit division"),
    ("u64_div_rem", "64-bit division"),
    ("a_tick_can_panic", "a panic"),
    ("panic", "a panic"),
    ("4core3fmt", "formatting"),
    ("alloc", "allocation"),
];

#[test]
fn no_tick_reaches_double_precision_long_division_panics_formatting_or_allocation() {
    let ticks = programs::instruments()
        .unwrap_or_else(|error| panic!("{error}"))
        .ticks;
    let functions =
        image::functions(&fs::read(ticks.path).expect("it was built")).expect("an ELF file");
    for tick in ["4Axle14tick_following", "5guard7sensing"] {
        assert!(
            functions
                .iter()
                .any(|function| function.name.contains(tick)),
            "no function of {tick} is linked"
        );
    }
    let reached: Vec<String> = functions
        .iter()
        .flat_map(|function| {
            // The hash at the end of a name is any text of 16 hexadecimal digits.
            let name = &function.name;
            let name = name.rsplit_once("17h").map_or(&name[..], |(name, _)| name);
            FORBIDDEN
                .iter()
                .filter(move |(part, _)| name.contains(part))
                .map(move |(_, what)| format!("{what}: {name}"))
        })
        .collect();
    assert!(reached.is_empty(), "\n{}", reached.join("\n"));
}
