//! Tests the fit of an ellipse with ellipses of known centre, half axes and direction.

use std::f64::consts::TAU;
use tautrack::estimate::ellipse::EllipseFit;

/// A point of an ellipse with these half axes, uT, the first of which has this direction, rad.
fn point(centre: [f64; 2], [long, short]: [f64; 2], direction: f64, angle: f64) -> [f32; 2] {
    let (x, y) = (long * angle.cos(), short * angle.sin());
    let (sine, cosine) = direction.sin_cos();
    [
        (centre[0] + x * cosine - y * sine) as f32,
        (centre[1] + x * sine + y * cosine) as f32,
    ]
}

/// Also far from the origin, where the squares of the readings have no digit for the ellipse.
#[test]
fn centre_radius_and_shape_are_those_of_the_ellipse() {
    for (centre, origin) in [
        ([31.0, -14.0], [40.0, -10.0]),
        ([-20.0, 35.0], [0.0, 0.0]),
        ([3_000.0, -2_000.0], [3_010.0, -1_980.0]),
    ] {
        for axes in [[24.0, 18.0], [20.0, 20.0], [60.0, 30.0]] {
            for direction in [0.0, 0.5, 2.3] {
                let mut fit = EllipseFit::around(origin);
                for step in 0..100_u32 {
                    assert_eq!(fit.count(), step);
                    let angle = f64::from(step) / 100.0 * TAU;
                    fit.add(point(centre, axes, direction, angle));
                }
                let found = fit.solve().expect("an ellipse");
                let case = (centre, axes, direction, found);
                for (got, exact) in found.centre.into_iter().zip(centre) {
                    assert!((f64::from(got) - exact).abs() < 0.02, "{case:?}");
                }
                let radius = (axes[0] * axes[1]).sqrt();
                assert!((f64::from(found.radius) - radius).abs() < 0.02, "{case:?}");
                let [xx, yy, xy] = found.correction.map(f64::from);
                assert!((xx * yy - xy * xy - 1.0).abs() < 1e-3, "{case:?}");
                for step in 0..20 {
                    let [x, y] = point([0.0; 2], axes, direction, f64::from(step) * 0.3);
                    let (x, y) = (f64::from(x), f64::from(y));
                    let distance = (xx * x + xy * y).hypot(xy * x + yy * y);
                    assert!((distance - radius).abs() < 0.05, "{case:?}: {distance}");
                }
            }
        }
    }
}

#[test]
fn a_hyperbola_is_no_ellipse() {
    let mut fit = EllipseFit::around([0.0; 2]);
    for step in -20..20 {
        let x = f64::from(step) * 0.1;
        for side in [-1.0, 1.0] {
            fit.add([(30.0 * side * x.cosh()) as f32, (20.0 * x.sinh()) as f32]);
        }
    }
    assert_eq!(fit.solve(), None);
}
