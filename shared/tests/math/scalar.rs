//! Tests of the elementary functions of the models' scalars against an independent library.

use tautrack::math::Scalar;

/// Returns angles up to `largest`, rad: over many turns, near every multiple of a quarter turn, and
/// tiny ones.
fn arguments(largest: f64) -> impl Iterator<Item = f64> {
    let spread = (-200_000..=200_000).map(move |i| f64::from(i) / 200_000.0 * largest);
    let near_quarters = (-4000..=4000).flat_map(|k| {
        let quarter = f64::from(k) * std::f64::consts::FRAC_PI_2;
        [-1e-3, -1e-9, 0.0, 1e-12, 1e-6].map(|offset| quarter + offset)
    });
    let turn = (-300_000..=300_000).map(|i| f64::from(i) * 2.1e-5);
    spread
        .chain(near_quarters)
        .chain(turn)
        .filter(move |angle| angle.abs() <= largest)
}

#[test]
fn sines_keep_their_errors() {
    let (mut single, mut double) = (0.0f64, 0.0f64);
    for angle in arguments(8192.0) {
        let narrow = angle as f32;
        let (sine, cosine) = Scalar::sin_cos(narrow);
        single = single
            .max((f64::from(sine) - libm::sin(f64::from(narrow))).abs())
            .max((f64::from(cosine) - libm::cos(f64::from(narrow))).abs());
    }
    for angle in arguments(1e6) {
        let (sine, cosine) = Scalar::sin_cos(angle);
        double = double
            .max((sine - libm::sin(angle)).abs())
            .max((cosine - libm::cos(angle)).abs());
    }
    println!("f32 {single:.2e}, f64 {double:.2e}");
    assert!(single <= 9e-8, "{single:e}");
    assert!(double <= 1.2e-16, "{double:e}");
}

/// The library's own error is below one unit.
#[test]
fn sines_in_double_precision_are_within_two_units_in_the_last_place() {
    let mut worst = 0;
    for angle in arguments(1e6) {
        let (sine, cosine) = Scalar::sin_cos(angle);
        for (got, expected) in [(sine, libm::sin(angle)), (cosine, libm::cos(angle))] {
            worst = worst.max(got.to_bits().abs_diff(expected.to_bits()));
        }
    }
    println!("{worst} units");
    assert!(worst <= 1, "{worst}");
}

#[test]
fn sines_beyond_their_domain_are_no_numbers() {
    for angle in [f64::NAN, f64::INFINITY, -1.1e6] {
        let (sine, cosine) = Scalar::sin_cos(angle);
        assert!(sine.is_nan() && cosine.is_nan(), "{angle}");
        let (sine, cosine) = Scalar::sin_cos(angle as f32);
        assert!(sine.is_nan() && cosine.is_nan(), "{angle}");
    }
    assert_eq!(Scalar::sin_cos(0.0f64), (0.0, 1.0));
    assert_eq!(Scalar::sin_cos(-0.0f32), (0.0, 1.0));
}

#[test]
fn arc_tangent_in_double_precision_keeps_its_error() {
    let mut worst = 0.0f64;
    for i in -400_000..=400_000 {
        let angle = f64::from(i) / 400_000.0 * std::f64::consts::PI;
        for size in [1.0, 1e-200, 3.7e150] {
            let (y, x) = (size * libm::sin(angle), size * libm::cos(angle));
            worst = worst.max((Scalar::atan2(y, x) - libm::atan2(y, x)).abs());
        }
    }
    println!("{worst:.2e}");
    assert!(worst <= 9e-16, "{worst:e}");
}

#[test]
fn arc_tangent_in_double_precision_has_the_special_values_of_ieee_754() {
    let special = [0.0, -0.0, 1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY];
    for y in special {
        for x in special {
            let (got, expected) = (Scalar::atan2(y, x), libm::atan2(y, x));
            assert!(
                (got - expected).abs() <= 4.5e-16
                    && got.is_sign_negative() == expected.is_sign_negative(),
                "{y} {x}: {got} {expected}"
            );
        }
        assert!(Scalar::atan2(y, f64::NAN).is_nan() && Scalar::atan2(f64::NAN, y).is_nan());
    }
}

#[test]
fn roots_are_correctly_rounded() {
    for i in 0..100_000 {
        let value = 1.37e-3 * f64::from(i) * f64::from(i);
        assert_eq!(Scalar::sqrt(value), libm::sqrt(value));
    }
    assert!(Scalar::sqrt(-1.0f64).is_nan() && Scalar::sqrt(f64::NAN).is_nan());
}
