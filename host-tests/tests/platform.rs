//! Tests that a run does not depend on the mathematical functions of the platform (of its C
//! library), whose last bits differ between platforms.
//!
//! This program defines these functions itself, so that all code in it, also that of the nodes and
//! of the physics engine, calls these definitions. They can return slightly different results.

#[path = "support/unchanged.rs"]
#[allow(dead_code)] // other tests name their inputs themselves
mod unchanged;

use clap::ValueEnum;
use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicU64};
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::{Expect, Scenario};
use tautrack_host_tests::simulator::run::{Options, run};
use unchanged::unless_unchanged;

/// Virtual time of the runs that are compared, s. All robots stand on their ground by then.
const RUN_S: f64 = 4.0;

/// Whether the functions return other results.
static CHANGED: AtomicBool = AtomicBool::new(false);
/// Number of results that were changed.
static CHANGES: AtomicU64 = AtomicU64::new(0);

/// Flips the last bit of a result. Whole numbers stay: all libraries compute `cos(0)` exactly.
fn changed(exact: f64) -> f64 {
    if !CHANGED.load(Relaxed) || libm::floor(exact) == exact {
        return exact;
    }
    CHANGES.fetch_add(1, Relaxed);
    f64::from_bits(exact.to_bits() ^ 1)
}

fn changed_f32(exact: f32) -> f32 {
    if !CHANGED.load(Relaxed) || libm::floorf(exact) == exact {
        return exact;
    }
    CHANGES.fetch_add(1, Relaxed);
    f32::from_bits(exact.to_bits() ^ 1)
}

/// Defines functions of the C library that IEEE 754 does not specify to the last bit.
macro_rules! functions {
    ($changed:ident, $float:ident: $($name:ident($($argument:ident),*);)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($argument: $float),*) -> $float {
            $changed(libm::$name($($argument),*))
        }
    )*};
}

functions! { changed, f64:
    sin(x); cos(x); tan(x); asin(x); acos(x); atan(x); atan2(y, x);
    sinh(x); cosh(x); tanh(x); asinh(x); acosh(x); atanh(x);
    exp(x); exp2(x); expm1(x); log(x); log2(x); log10(x); log1p(x);
    pow(x, y); hypot(x, y); cbrt(x);
}

functions! { changed_f32, f32:
    sinf(x); cosf(x); tanf(x); asinf(x); acosf(x); atanf(x); atan2f(y, x);
    expf(x); exp2f(x); expm1f(x); logf(x); log2f(x); log10f(x); log1pf(x);
    powf(x, y); hypotf(x, y); cbrtf(x);
}

/// The sine and the cosine in one call. The compiler calls it where code takes both.
///
/// # Safety
/// As for every C function that writes to its arguments: both must point to a number.
#[unsafe(no_mangle)]
unsafe extern "C" fn sincos(x: f64, sine: *mut f64, cosine: *mut f64) {
    // SAFETY: the caller passes pointers to two numbers.
    unsafe {
        *sine = changed(libm::sin(x));
        *cosine = changed(libm::cos(x));
    }
}

/// The nodes of a robot, in this process.
fn nodes(kind: Kind) -> Programs {
    kind.programs(Board::Host)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Runs the beginning of a shipped scenario with nodes in this process and returns its hash.
fn hash(kind: Kind, file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios")
        .join(file);
    let mut description = Scenario::load(&path)
        .unwrap_or_else(|error| panic!("{error}"))
        .description();
    description.duration_s = RUN_S;
    description.expect = Expect::default();
    description.operator.events.truncate(1);
    let beginning = Scenario::checked(description).unwrap_or_else(|error| panic!("{error}"));
    run(&beginning, &nodes(kind), Options::default())
        .unwrap_or_else(|error| panic!("{error}"))
        .facts
        .state_hash
}

#[test]
fn hashes_do_not_depend_on_the_platforms_functions() {
    let programs = Kind::value_variants().iter().map(|kind| nodes(*kind));
    let programs = programs.flat_map(|programs| unchanged::nodes(&programs));
    unless_unchanged("platform", programs, || {
        CHANGED.store(true, Relaxed);
        assert_ne!(black_box(0.5_f64).sin(), libm::sin(0.5));
        assert_ne!(black_box(0.5_f64).sin_cos().1, libm::cos(0.5));
        assert_eq!(CHANGES.load(Relaxed), 3, "the functions above are in use");

        let robots = Kind::value_variants();
        let defaults = robots
            .iter()
            .map(|kind| (*kind, kind.facts().scenario_file));
        let loaded = [(Kind::B2p2, "hazards/payload-1-kg.toml")];
        for (kind, file) in defaults.chain(loaded) {
            let [plain, other] = [false, true].map(|change| {
                CHANGED.store(change, Relaxed);
                CHANGES.store(0, Relaxed);
                hash(kind, file)
            });
            println!("{file}: {} results changed", CHANGES.load(Relaxed));
            assert_eq!(plain, other, "{file}");
        }
    });
}
