//! Tests the screw's geometry against double precision, the reference vectors and itself.

mod support;

use crate::support::sweep::unless_unchanged;
use crate::support::{RADIANS_PER_BIT, worst_over_all_angles};
use fixed::types::I4F28;
use proptest::prelude::*;
use serde_json::Value;
use tautrack::screw::{Geometry, GeometryError, SlackLaw};
use tautrack::units::Angle;

/// What the error over every angle depends on.
const SOURCES: [&str; 7] = [
    "src/screw.rs",
    "src/math/trig.rs",
    "src/math/cubic.rs",
    "src/math/mod.rs",
    "src/units.rs",
    "tests/screw.rs",
    "tests/support/mod.rs",
];

/// One step of 2^-24 m, the guaranteed resolution.
const LSB: f64 = 1.0 / 16_777_216.0;

fn geometry(l1: f64, l2: f64, k: f64) -> Result<Geometry, GeometryError> {
    let length = |x: f64| I4F28::saturating_from_num(x);
    Geometry::new(length(l1), length(l2), length(k))
}

fn nominal() -> Geometry {
    Geometry::from_micrometres(320_000, 230_000, 1_232_000).unwrap()
}

/// Extension and derivative in double precision, from the lengths as rounded to fixed point.
fn reference(geometry: &Geometry, sin: f64, cos: f64) -> (f64, f64) {
    let [l1, l2, k] = [geometry.l1(), geometry.l2(), geometry.k()].map(metres);
    let per_u = 1.0 / (k + l1 * cos);
    let r = 0.5 * (k * k - l1 * l1) * per_u;
    (r - l2, r * l1 * sin * per_u)
}

/// Converts a length to metres. The library's own conversion is general, and slow in a sweep.
fn metres(length: I4F28) -> f64 {
    f64::from(length.to_bits()) / 268_435_456.0
}

fn errors(geometry: &Geometry, theta: Angle, sin: f64, cos: f64) -> [f64; 3] {
    let (length, derivative) = reference(geometry, sin, cos);
    let extension = geometry.extension(theta);
    [
        metres(extension.length) - length,
        metres(extension.derivative) - derivative,
        metres(extension.length) - metres(geometry.length(theta)),
    ]
}

fn radians(theta: Angle) -> f64 {
    f64::from(theta.to_bits()) * RADIANS_PER_BIT
}

/// Belt slack from the distances between the axles, in double precision.
fn slack_reference(geometry: &Geometry, theta: Angle, length: f64) -> f64 {
    let (l1, k) = (geometry.l1().to_num::<f64>(), geometry.k().to_num::<f64>());
    let r = geometry.l2().to_num::<f64>() + length;
    let (sin, cos) = radians(theta).sin_cos();
    k - r - (l1 + r * cos).hypot(r * sin)
}

/// Reproducible sequence of numbers from 0 to 1.
fn random(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Corners of the accepted domain, and then random geometries within it.
fn sampled_geometries() -> Vec<Geometry> {
    const SEED: u64 = 20_090_100;
    println!("seed {SEED}");
    let mut state = SEED;
    let mut all = vec![nominal()];
    for l1 in [0.01, 0.32, 1.0] {
        for k in [2.4 * l1, 4.0] {
            all.extend([0.0, 0.5 * (k - l1)].map(|l2| geometry(l1, l2, k).unwrap()));
        }
    }
    for _ in 0..60 {
        let l1 = 0.01 + 0.99 * random(&mut state);
        let k = 2.4 * l1 + (4.0 - 2.4 * l1) * random(&mut state).powi(3);
        all.push(geometry(l1, 0.5 * (k - l1) * random(&mut state), k).unwrap());
    }
    all
}

#[test]
fn extension_keeps_its_errors_over_every_angle() {
    unless_unchanged("screw", &SOURCES, every_angle);
}

fn every_angle() {
    let nominal = nominal();
    let [length, derivative, disagreement] =
        worst_over_all_angles(|theta, sin, cos| errors(&nominal, theta, sin, cos));
    println!(
        "length {:.4} LSB of 2^-24 m, derivative {derivative:.3e} m/rad",
        length / LSB
    );
    assert!(length <= 0.08 * LSB, "length {length:e} m");
    assert!(derivative <= 1.5e-7, "derivative {derivative:e} m/rad");
    assert_eq!(disagreement, 0.0, "length() and extension() differ");
}

/// What the error of a released belt depends on, besides [`SOURCES`].
const SLACK_SOURCES: [&str; 2] = ["src/screw/slack.rs", "src/screw/table.rs"];

/// Errors of length and derivative of a released belt. The reference is eq. 2 with `K - slack`.
fn slack_errors(geometry: &Geometry, slack: f32, theta: Angle, sin: f64, cos: f64) -> [f64; 2] {
    let [l1, l2, k] = [geometry.l1(), geometry.l2(), geometry.k()].map(metres);
    let k = k - f64::from(slack);
    let per_u = 1.0 / (k + l1 * cos);
    let r = 0.5 * (k * k - l1 * l1) * per_u;
    let extension = SlackLaw::new(geometry).extension(geometry.extension(theta), slack);
    [
        metres(extension.length) - (r - l2),
        metres(extension.derivative) - r * l1 * sin * per_u,
    ]
}

#[test]
fn extension_with_50_mm_of_slack_keeps_its_errors_over_every_angle() {
    let sources = [&SOURCES[..], &SLACK_SOURCES].concat();
    unless_unchanged("screw-slack", &sources, || {
        let nominal = nominal();
        let [length, derivative] =
            worst_over_all_angles(|theta, sin, cos| slack_errors(&nominal, 0.05, theta, sin, cos));
        println!("length {length:.3e} m, derivative {derivative:.3e} m/rad");
        assert!(length <= 1.5e-8, "length {length:e} m");
        assert!(derivative <= 1.5e-7, "derivative {derivative:e} m/rad");
    });
}

/// A grid of slacks from what the bus can carry to what no extension can give, and angles that
/// reach every position within a piece.
#[test]
fn extension_with_slack_keeps_its_errors_over_a_grid_of_slacks() {
    let nominal = nominal();
    let mut worst = [0.0_f64; 2];
    let slacks = (0..96).map(|step| 0.456 * (step as f32 / 95.0).powi(2));
    for slack in slacks.chain([1.0 / 16_777_216.0, 1e-6, 1e-4]) {
        for step in 0..40_000_i32 {
            let theta = Angle::from_bits(step.wrapping_mul(104_729 * 17 + 2));
            let (sin, cos) = radians(theta).sin_cos();
            let errors = slack_errors(&nominal, slack, theta, sin, cos).map(f64::abs);
            worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
        }
    }
    println!(
        "length {:.3e} m, derivative {:.3e} m/rad",
        worst[0], worst[1]
    );
    assert!(worst[0] <= 1.2e-7, "length {:e} m", worst[0]);
    assert!(worst[1] <= 2e-7, "derivative {:e} m/rad", worst[1]);
}

#[test]
fn extension_keeps_its_errors_over_accepted_geometries() {
    let mut worst = [0.0f64; 2];
    for geometry in sampled_geometries() {
        let mut own = [0.0f64; 2];
        // An odd stride reaches every position within a piece; the ends are tested separately.
        let strided = (0..200_000).map(|i: i32| i.wrapping_mul(104_729 * 17 + 2));
        for bits in strided.chain([0, -1, 1, i32::MAX, i32::MIN, i32::MIN + 1]) {
            let theta = Angle::from_bits(bits);
            let (sin, cos) = radians(theta).sin_cos();
            let [length, derivative, disagreement] = errors(&geometry, theta, sin, cos);
            assert_eq!(disagreement, 0.0);
            own = [own[0].max(length.abs()), own[1].max(derivative.abs())];
        }
        let name = (geometry.l1(), geometry.l2(), geometry.k());
        assert!(own[0] <= 0.081 * LSB && own[1] <= 1e-6, "{name:?}: {own:?}");
        worst = [worst[0].max(own[0]), worst[1].max(own[1])];
    }
    println!(
        "length {:.4} LSB of 2^-24 m, derivative {:.3e} m/rad",
        worst[0] / LSB,
        worst[1]
    );
}

#[test]
fn vectors_are_met() {
    let text = include_str!("../../host-tests/vectors/b2p2_screw.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let cases = file["functions"]["screw"].as_array().unwrap();
    assert_eq!(cases.len(), 50);
    for case in cases {
        let number = |side: &str, name: &str| case[side][name].as_f64().unwrap();
        let (l1, l2, k) = (number("in", "l1"), number("in", "l2"), number("in", "K"));
        let result = geometry(l1, l2, k);
        assert_eq!(
            result.is_ok(),
            k >= l1 + 2.0 * l2 && k >= 2.4 * l1,
            "{case}"
        );
        let Ok(geometry) = result else { continue };
        let theta = number("in", "theta");
        let angle = Angle::from_bits((theta / RADIANS_PER_BIT).round() as i64 as i32);
        let extension = geometry.extension(angle);
        // The rounding of the lengths to 2^-28 m adds to the table's error.
        assert!(
            (extension.length.to_num::<f64>() - number("out", "l3")).abs() <= 0.3 * LSB,
            "{case}"
        );
        assert!(
            (extension.derivative.to_num::<f64>() - number("out", "dl3_dtheta")).abs() <= 3e-7,
            "{case}"
        );
        let inverse = radians(geometry.inverse(extension.length).unwrap());
        if let Some(expected) = case["out"]["inverse_abs_theta"].as_f64() {
            // The length is flat at both ends, where one step of length is a wide range of angles.
            let steep = number("out", "dl3_dtheta").abs().max(1e-4);
            assert!(
                (inverse - expected).abs() <= 2e-6 + 0.3 * LSB / steep,
                "{inverse} {case}"
            );
        }
    }
}

#[test]
fn geometries_beyond_a_bound_are_refused_with_the_bound() {
    use GeometryError as E;
    let um = Geometry::from_micrometres;
    assert!(
        matches!(um(9_999, 0, 1_000_000), Err(E::L1OutOfRange { minimum, .. }) if minimum == Geometry::MIN_L1)
    );
    assert!(matches!(
        um(1_000_001, 0, 3_000_000),
        Err(E::L1OutOfRange { .. })
    ));
    assert!(matches!(um(i32::MIN, 0, 0), Err(E::L1OutOfRange { got, .. }) if got == I4F28::MIN));
    assert!(matches!(
        um(320_000, -1, 1_000_000),
        Err(E::L2BelowMinimum { .. })
    ));
    assert!(
        matches!(um(320_000, 230_000, 779_999), Err(E::KBelowChain { got, minimum }) if got < minimum)
    );
    assert!(matches!(
        um(320_000, i32::MAX, 1_000_000),
        Err(E::KBelowChain { .. })
    ));
    assert!(
        matches!(um(320_000, 0, 767_999), Err(E::KBelowRatio { got, minimum }) if got < minimum)
    );
    assert!(matches!(
        um(320_000, 0, 4_000_001),
        Err(E::KAboveMaximum { .. })
    ));
    // Values on the bound, although neither 0.32 nor 0.768 is a fixed-point number.
    assert!(um(320_000, 0, 768_000).is_ok());
    assert!(um(320_000, 230_000, 780_000).is_ok());
}

#[test]
fn lengths_in_micrometres_are_rounded_to_the_nearest_step() {
    // Twice the exact number of steps of 2^-28 m, as a fraction of 10^6.
    let nearest = |um: i64| (((um << 29) + 1_000_000).div_euclid(2_000_000)) as i32;
    for um in [10_000, 10_001, 319_999, 320_000, 654_321, 999_999] {
        let geometry = Geometry::from_micrometres(um, 1, 4 * um.min(900_000)).unwrap();
        assert_eq!(geometry.l1().to_bits(), nearest(i64::from(um)), "{um}");
        assert_eq!(geometry.l2().to_bits(), nearest(1));
    }
    for um in [-1, -2, -1_000_003] {
        match Geometry::from_micrometres(320_000, um, 1_000_000) {
            Err(GeometryError::L2BelowMinimum { got, .. }) => {
                assert_eq!(got.to_bits(), nearest(i64::from(um)), "{um}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_check_without_the_table_refuses_the_same_lengths() {
    let mut state = 7;
    for _ in 0..200 {
        let mut um = |from: f64, to: f64| (from + (to - from) * random(&mut state)) as i32;
        let (l1, l2, k) = (um(0.0, 1.1e6), um(-2e5, 1e6), um(0.0, 4.2e6));
        assert_eq!(
            Geometry::check_micrometres(l1, l2, k),
            Geometry::from_micrometres(l1, l2, k).map(|_| ()),
            "{l1} {l2} {k}"
        );
    }
}

#[test]
fn two_steps_below_a_bound_are_rounding_and_three_are_refused() {
    let (l1, l2) = (I4F28::from_num(0.3125), I4F28::from_num(0.25));
    let short = |k: f64, steps: i32| I4F28::from_num(k) - I4F28::from_bits(steps);
    // `L1 + 2 L2` and `2.4 L1`; all of them are fixed-point numbers.
    for (l2, k) in [(l2, 0.8125), (I4F28::ZERO, 0.75)] {
        assert!(Geometry::check(l1, l2, short(k, 2)).is_ok(), "{k}");
        assert!(Geometry::check(l1, l2, short(k, 3)).is_err(), "{k}");
    }
}

#[test]
fn the_released_length_is_the_taut_one_at_angle_zero() {
    for geometry in sampled_geometries() {
        let (released, _) = reference(&geometry, 0.0, 1.0);
        let length = metres(geometry.released_length());
        assert!((length - released).abs() <= 2.0 * metres(I4F28::DELTA));
    }
}

#[test]
fn an_extension_counts_as_an_end_up_to_a_step_of_the_resolution_beyond_it() {
    let geometry = nominal();
    let (low, high) = (geometry.inverse(I4F28::MIN), geometry.inverse(I4F28::MAX));
    let (low, high) = (low.unwrap_err().minimum, high.unwrap_err().maximum);
    for (beyond, accepted) in [(0, true), (16, true), (18, false)] {
        let beyond = I4F28::from_bits(beyond);
        let ends = [
            geometry.inverse(low - beyond),
            geometry.inverse(high + beyond),
        ];
        assert_eq!(ends[0].ok(), accepted.then_some(Angle::ZERO), "{beyond}");
        assert_eq!(ends[1].is_ok(), accepted, "{beyond}");
    }
}

#[test]
fn inverse_returns_the_angle_of_every_extension() {
    for geometry in sampled_geometries() {
        for step in 0..=1000 {
            let theta = Angle::from_bits((i64::from(i32::MAX) * step / 1000) as i32);
            let extension = geometry.extension(theta);
            let found = geometry.inverse(extension.length).unwrap();
            assert!(found.to_bits() >= 0);
            // Compared as lengths, with a tolerance for the angle: near both ends the length hardly
            // depends on the angle.
            let (sin, cos) = radians(found).sin_cos();
            let back = reference(&geometry, sin, cos).0 - extension.length.to_num::<f64>();
            assert!(
                back.abs() <= 2e-6 * extension.derivative.to_num::<f64>().abs() + 0.3 * LSB,
                "{:?} {theta:?} {back:e}",
                (geometry.l1(), geometry.l2(), geometry.k())
            );
        }
        let beyond = I4F28::from_bits(32);
        let (low, high) = (
            geometry.released_length(),
            geometry.length(Angle::from_bits(i32::MAX)),
        );
        assert!(low <= high);
        let error = geometry.inverse(high + beyond).unwrap_err();
        assert!(
            error.got == high + beyond
                && error.minimum == low
                && (error.maximum - high).abs() < 8 * I4F28::DELTA
        );
        assert!(geometry.inverse(low - beyond).is_err());
    }
}

#[test]
fn slack_is_belt_minus_triangle() {
    for geometry in sampled_geometries() {
        let (low, high) = (
            geometry.released_length(),
            geometry.length(Angle::HALF_TURN),
        );
        for step in -100..=100 {
            let theta = Angle::from_bits(step * 21_474_836);
            let taut = geometry.length(theta);
            assert_eq!(
                geometry.slack(theta, taut),
                0,
                "the taut length leaves no slack"
            );
            assert!(
                geometry.slack(theta, low) >= -4 * I4F28::DELTA,
                "released means slack at any angle"
            );
            for share in 0..=10 {
                let length = I4F28::from_num(
                    low.to_num::<f64>() + (high - low).to_num::<f64>() * f64::from(share) / 8.0,
                );
                let slack = geometry.slack(theta, length).to_num::<f64>();
                let expected = slack_reference(&geometry, theta, length.to_num());
                // The tolerance is two steps of the table's resolution: the taut side is known no
                // better than the table, and near a folded triangle the distance between the axles
                // magnifies its error.
                assert!(
                    (slack - expected).abs() <= 2.0 * LSB + 1e-6 * expected.abs(),
                    "{:?} {theta:?} {slack} {expected}",
                    (geometry.l1(), geometry.l2(), geometry.k())
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_input_panics(l1: i32, l2: i32, k: i32, theta: i32, length: i32, um: [i32; 3]) {
        let _ = Geometry::from_micrometres(um[0], um[1], um[2]);
        let _ = Geometry::new(I4F28::from_bits(l1), I4F28::from_bits(l2), I4F28::from_bits(k));
        // Mapped into the domain, so that the rest is exercised as well.
        let within = |bits: i32, low: f64, high: f64| low + (high - low) * (f64::from(bits) / 4_294_967_296.0 + 0.5);
        let l1 = within(l1, 0.01, 1.0);
        let k = within(k, 2.4 * l1, 4.0);
        let geometry = geometry(l1, within(l2, 0.0, 0.5 * (k - l1)), k).unwrap();
        let (theta, length) = (Angle::from_bits(theta), I4F28::from_bits(length));
        let _ = (geometry.extension(theta), geometry.inverse(length));
        let slack = geometry.slack(theta, length).to_num::<f64>();
        let expected = slack_reference(&geometry, theta, length.to_num()).clamp(-8.0, 8.0);
        prop_assert!((slack - expected).abs() < 1e-5, "{} {}", slack, expected);
    }
}

#[test]
fn a_slack_of_zero_or_nan_changes_nothing_and_an_absurd_one_is_bounded() {
    let geometry = nominal();
    let law = SlackLaw::new(&geometry);
    for bits in (0..1_000_i32).map(|step| step.wrapping_mul(0x0123_4567)) {
        let taut = geometry.extension(Angle::from_bits(bits));
        for slack in [0.0, -0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(law.extension(taut, slack), taut, "{slack}");
        }
        for slack in [0.456, 0.5, 1e9, f32::INFINITY] {
            assert_eq!(
                law.extension(taut, slack),
                law.extension(taut, 0.456),
                "{slack}"
            );
        }
    }
}

/// By virtual work: a belt pulls with its tension times the growth of its loop. Also at the
/// released length, where the belt has less slack than commanded.
#[test]
fn tension_per_force_is_that_of_two_loops_around_the_axles() {
    let mut worst = [0.0_f64; 2];
    for k in [0.80, 1.232, 1.5] {
        let geometry = geometry(0.32, 0.23, k).unwrap();
        let law = SlackLaw::new(&geometry);
        let released = geometry.released_length();
        for (step, slack) in
            (-100..=100).flat_map(|step| [0.0, 0.01, 0.06, 0.12].map(|s| (step, s)))
        {
            let theta = 0.0175 * f64::from(step);
            let loop_at = |r: f64| r + (0.32 + r * theta.cos()).hypot(r * theta.sin());
            let taut = geometry.extension(Angle::from_radians(theta as f32));
            let mut extension = law.extension(taut, slack);
            let ends = extension.length < released;
            extension.length = extension.length.max(released);
            let r = 0.23 + metres(extension.length);
            let growth = (loop_at(r + 1e-5) - loop_at(r - 1e-5)) / 2e-5;
            let found = f64::from(law.tension_per_force(extension, slack));
            let error = (found * 2.0 * growth - 1.0).abs();
            let place = &mut worst[usize::from(ends)];
            *place = place.max(error);
        }
    }
    println!(
        "by the law {:.1e}, at the released length {:.3}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 3e-7, "{worst:?}");
    assert!(worst[1] < 0.18, "{worst:?}");
}
