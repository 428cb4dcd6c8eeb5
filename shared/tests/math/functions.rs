//! Tests of the elementary functions against double precision and against the definitions of IEEE
//! 754.

use crate::support::sweep::unless_unchanged;
use crate::support::{RADIANS_PER_BIT, worst_over_all_angles};
use proptest::prelude::*;
use tautrack::math::cubic::{mul_high, mul_high_add, mul_high_add_plain};
use tautrack::math::cubic::{mul_high_plain, mul_high_sub, mul_high_sub_plain};
use tautrack::math::{atan2, clamp, limit, max, min, sin_cos, sin_cos_q30, sqrt};
use tautrack::units::Angle;

/// What the errors of sine and cosine depend on.
const SOURCES: [&str; 6] = [
    "src/math/trig.rs",
    "src/math/cubic.rs",
    "src/math/mod.rs",
    "src/units.rs",
    "tests/math/functions.rs",
    "tests/support/mod.rs",
];

/// Values at which comparisons, roots and quotients have special cases.
const EDGES: [f32; 17] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::from_bits(1),
    -f32::from_bits(1),
    f32::from_bits(0x007f_ffff),
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::from_bits(0xffc0_0000),
    f32::from_bits(0x7f80_0001),
];

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits()
}

#[test]
fn sine_and_cosine_keep_their_errors_over_every_angle() {
    unless_unchanged("sine_and_cosine", &SOURCES, every_angle);
}

fn every_angle() {
    const ONE: f64 = (1 << 30) as f64;
    let worst = worst_over_all_angles(|angle, sin, cos| {
        let (sin_q30, cos_q30) = sin_cos_q30(angle);
        let (sin_f32, cos_f32) = sin_cos(angle);
        [
            f64::from(sin_q30) / ONE - sin,
            f64::from(cos_q30) / ONE - cos,
            f64::from(sin_f32) - sin,
            f64::from(cos_f32) - cos,
            f64::from(sin_q30.unsigned_abs().max(cos_q30.unsigned_abs())) / ONE,
        ]
    });
    println!("sin, cos Q30; sin, cos f32; largest value: {worst:?}");
    assert!(worst[0] <= 3.2e-8 && worst[1] <= 3.2e-8);
    assert!(worst[2] <= 6.2e-8 && worst[3] <= 6.2e-8);
    assert!(worst[4] <= 1.0, "nothing exceeds one");
    assert_eq!(sin_cos_q30(Angle::ZERO).0, 0);
    assert_eq!(sin_cos_q30(Angle::QUARTER_TURN).1, 0);
}

#[test]
fn arc_tangent_keeps_its_error_in_every_direction() {
    let mut worst = 0.0f64;
    for i in 0..4_000_000i32 {
        let (sin, cos) = (f64::from(i.wrapping_mul(1_073_741_827)) * RADIANS_PER_BIT).sin_cos();
        let size = 2f64.powi(i % 200 - 100);
        let (y, x) = ((sin * size) as f32, (cos * size) as f32);
        worst = worst.max((f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs());
    }
    println!("atan2 {worst:e} rad");
    assert!(worst <= 4e-7);
}

#[test]
fn arc_tangent_follows_ieee_754_at_the_edges() {
    for y in EDGES {
        for x in EDGES {
            let (got, expected) = (atan2(y, x), y.atan2(x));
            if expected.is_nan() {
                assert!(
                    same(got, f32::NAN),
                    "atan2({y:e}, {x:e}) = {:08x}",
                    got.to_bits()
                );
            } else {
                assert!(
                    (got - expected).abs() <= 4e-7,
                    "atan2({y:e}, {x:e}) = {got:e}, not {expected:e}"
                );
                assert_eq!(
                    got.is_sign_negative(),
                    expected.is_sign_negative(),
                    "atan2({y:e}, {x:e})"
                );
            }
        }
    }
}

#[test]
fn square_root_is_correctly_rounded() {
    let every_exponent = (0..2_000_000u32).map(|i| f32::from_bits(i * 1069));
    for value in every_exponent.chain(EDGES) {
        let root = sqrt(value);
        // The root of a float in double precision, rounded to `f32`, is the correctly rounded root.
        let expected = f64::from(value).sqrt() as f32;
        if value < 0.0 || value.is_nan() {
            assert!(same(root, f32::NAN), "sqrt({value:e})");
        } else {
            assert!(
                same(root, expected),
                "sqrt({value:e}) = {root:e}, not {expected:e}"
            );
        }
    }
}

/// Returns the rank of a value in the order of IEEE 754-2019 `minimum`, in which -0 is below +0. It
/// has no meaning for NaN.
fn rank(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    if bits < 0 { !(bits & i32::MAX) } else { bits }
}

#[test]
fn minimum_and_maximum_order_zeros_and_pass_on_nan() {
    for a in EDGES {
        for b in EDGES {
            let (low, high) = if a.is_nan() || b.is_nan() {
                (f32::NAN, f32::NAN)
            } else if rank(a) <= rank(b) {
                (a, b)
            } else {
                (b, a)
            };
            assert!(same(min(a, b), low), "min({a:e}, {b:e})");
            assert!(same(max(a, b), high), "max({a:e}, {b:e})");
        }
    }
}

#[test]
fn limit_is_zero_for_what_is_no_number() {
    for bound in EDGES {
        assert!(same(limit(f32::NAN, bound), 0.0));
        assert!(same(
            limit(f32::INFINITY, bound),
            if bound > 0.0 { bound } else { 0.0 }
        ));
    }
    assert!(same(limit(1.0, f32::NAN), 0.0) && same(limit(1.0, -1.0), 0.0));
    assert!(
        same(limit(-3.0, 2.0), -2.0)
            && same(limit(-1.5, 2.0), -1.5)
            && same(limit(-0.0, 2.0), -0.0)
    );
}

#[test]
fn angles_convert_to_the_nearest_bit_and_wrap() {
    assert_eq!(Angle::from_degrees(90.0), Angle::QUARTER_TURN);
    assert_eq!(Angle::from_degrees(-180.0), Angle::HALF_TURN);
    assert_eq!(Angle::from_degrees(450.0), Angle::QUARTER_TURN);
    assert_eq!(-Angle::HALF_TURN, Angle::HALF_TURN);
    assert_eq!(Angle::HALF_TURN + Angle::HALF_TURN, Angle::ZERO);
    for value in EDGES.iter().filter(|x| x.is_nan() || x.abs() > 1e9) {
        assert_eq!(Angle::from_radians(*value), Angle::ZERO);
        assert_eq!(Angle::from_degrees(*value), Angle::ZERO);
    }
}

fn any_bits() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn angle_and_radians_agree(bits: i32, radians in -1e6f32..1e6) {
        let angle = Angle::from_bits(bits);
        prop_assert!((f64::from(angle.radians()) - f64::from(bits) * RADIANS_PER_BIT).abs() <= 3e-7);
        prop_assert!((f64::from(angle.degrees()) - f64::from(bits) * 180.0 / 2_147_483_648.0).abs() <= 2e-5);
        let turns = (f64::from(radians) - f64::from(Angle::from_radians(radians).to_bits()) * RADIANS_PER_BIT)
            / std::f64::consts::TAU;
        prop_assert!((turns - turns.round()).abs() <= 1.0 / 4_294_967_296.0);
    }

    #[test]
    fn limit_never_exceeds_its_bound(value in any_bits(), bound in any_bits()) {
        let limited = limit(value, bound);
        prop_assert!(limited == 0.0 || limited.abs() <= bound);
        prop_assert!(!limited.is_nan());
    }

    #[test]
    fn clamp_stays_between_or_says_nan(value in any_bits(), a in any_bits(), b in any_bits()) {
        let clamped = clamp(value, a, b);
        if value.is_nan() || a.is_nan() || b.is_nan() {
            prop_assert!(same(clamped, f32::NAN));
        } else {
            prop_assert!(clamped <= b && (a > b || clamped >= a));
            prop_assert!([value, a, b].iter().any(|x| same(*x, clamped)));
        }
    }

    #[test]
    fn high_products_are_the_defined_ones(sum: i32, a: i32, b: i32) {
        let exact = i128::from(a) * i128::from(b);
        let rounded = (i128::from(sum) << 32) + exact + (1 << 31);
        for product in [mul_high(a, b), mul_high_plain(a, b)] {
            prop_assert_eq!(product, (exact >> 32) as i32);
        }
        for result in [mul_high_add(sum, a, b), mul_high_add_plain(sum, a, b)] {
            prop_assert_eq!(result, (rounded >> 32) as i32);
        }
        let rounded = (i128::from(sum) << 32) - exact + (1 << 31);
        for result in [mul_high_sub(sum, a, b), mul_high_sub_plain(sum, a, b)] {
            prop_assert_eq!(result, (rounded >> 32) as i32);
        }
    }
}
