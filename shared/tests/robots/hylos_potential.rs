//! Tests Hylos' stability potential: it is smooth, and constants that would divide by zero are
//! refused.

use tautrack::robots::hylos::{Potential, PotentialError};

#[test]
fn the_potential_falls_smoothly_to_zero_at_its_limit() {
    let potential = Potential::<f64>::new(0.004, 0.35, 0.02).unwrap();
    let mut before = f64::INFINITY;
    for step in -2000..2000 {
        let angle = f64::from(step) * 2e-4 + 1e-5;
        let (value, slope) = potential.of_angle(angle);
        let h = 1e-8;
        let change =
            (potential.of_angle(angle + h).0 - potential.of_angle(angle - h).0) / (2.0 * h);
        assert!(
            (slope - change).abs() <= 2e-5 * (1.0 + slope.abs()),
            "{angle}: {slope} {change}"
        );
        assert!(value <= before && slope <= 0.0 && value >= 0.0);
        before = value;
    }
    assert_eq!(before, 0.0);
    assert!(potential.total(&[0.5, f64::NAN]).is_nan());
}

#[test]
fn potentials_that_would_divide_by_zero_are_refused() {
    let new = Potential::<f32>::new;
    assert_eq!(new(-1.0, 0.3, 0.1), Err(PotentialError::Gain(-1.0)));
    for (limit, floor) in [
        (0.3, 0.0),
        (0.3, -0.1),
        (0.1, 0.3),
        (f64::INFINITY, 0.1),
        (0.3, f64::NAN),
    ] {
        assert!(matches!(
            new(0.004, limit, floor),
            Err(PotentialError::Angles { .. })
        ));
    }
}
