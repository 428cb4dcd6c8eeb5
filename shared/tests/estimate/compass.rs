//! Tests the compass against the tilted field in double precision.

use crate::tilted;
use proptest::prelude::*;
use std::f64::consts::PI;
use tautrack::estimate::compass::{Compass, CompassError, HORIZONTAL_SHARE};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// Converts a field (north, west, up; uT) to the axes of a body with this heading, roll and pitch
/// (rad), in double precision.
fn in_body([north, west, up]: [f64; 3], [heading, roll, pitch]: [f64; 3]) -> [f32; 3] {
    // World axes to heading axes (about z), then roll about x (left side up), then pitch about y
    // (nose up).
    let (x, y) = (
        north * heading.cos() + west * heading.sin(),
        -north * heading.sin() + west * heading.cos(),
    );
    let (y, z) = (
        y * roll.cos() + up * roll.sin(),
        -y * roll.sin() + up * roll.cos(),
    );
    let (x, z) = (
        x * pitch.cos() + z * pitch.sin(),
        -x * pitch.sin() + z * pitch.cos(),
    );
    [x, y, z].map(|component| component as f32)
}

#[test]
fn the_compass_keeps_its_error_over_directions_tilts_strengths_and_inclinations() {
    let (iron, declination) = ([11.0_f64, -7.0, 20.0], 3.7_f64.to_radians());
    let compass = Compass::new(
        iron.map(|component| component as f32),
        Angle::from_radians(declination as f32),
    );
    let mut worst = 0.0_f64;
    for (roll, pitch) in [
        (0.0, 0.0),
        (0.3, 0.0),
        (0.0, 0.75),
        (-0.4, 0.5),
        (0.2, -1.2),
    ] {
        let axes = tilted(roll, pitch).level_axes();
        for (strength, inclination) in [(20.0, 0.0), (47.5, 62.0), (65.0, -70.0), (50.0, 79.0)] {
            let inclination = f64::to_radians(inclination);
            let level = strength * inclination.cos();
            let field = [
                level * declination.cos(),
                -level * declination.sin(),
                -strength * inclination.sin(),
            ];
            for step in 0..36_000 {
                let heading = f64::from(step) / 18_000.0 * PI - PI;
                let mut reading = in_body(field, [heading, roll, pitch]);
                for (component, iron) in reading.iter_mut().zip(iron) {
                    *component += iron as f32;
                }
                let got = compass.heading(reading, &axes).expect("an earth's field");
                let exact = Angle::from_radians(heading as f32);
                worst = worst.max(f64::from((got - exact).degrees()).abs());
            }
        }
    }
    println!("worst error of the compass: {worst:.4} degrees");
    assert!(worst <= 0.163, "{worst} degrees");
}

#[test]
fn readings_that_are_no_earth_s_field_give_no_heading() {
    let (compass, level) = (Compass::default(), tilted(0.0, 0.0).level_axes());
    let heading = |field| compass.heading(field, &level);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut field = [20.0, 0.0, -40.0];
            field[axis] = bad;
            assert_eq!(heading(field), Err(CompassError::NotFinite));
        }
    }
    assert_eq!(heading([0.0; 3]), Err(CompassError::Strength(0.0)));
    assert_eq!(heading([-0.0; 3]), Err(CompassError::Strength(0.0)));
    assert!(matches!(heading([3e38; 3]), Err(CompassError::Strength(_))));
    assert!(matches!(
        heading([100.0, 0.0, 0.0]),
        Err(CompassError::Strength(_))
    ));
    assert!(matches!(
        heading([5.0, 0.0, -5.0]),
        Err(CompassError::Strength(_))
    ));
    let Err(CompassError::Steep(share)) = heading([5.0, 0.0, -45.0]) else {
        panic!("a field of 84 degrees")
    };
    assert!(share < HORIZONTAL_SHARE);
}

proptest! {
    #[test]
    fn no_field_makes_the_compass_panic(bits in any::<[u32; 3]>(), tilt in any::<[i16; 2]>()) {
        let [roll, pitch] = tilt.map(|tilt| f64::from(tilt) * 1e-4);
        let _ = Compass::default().heading(bits.map(f32::from_bits), &tilted(roll, pitch).level_axes());
    }
}

/// Iron stretches the horizontal field by a symmetric matrix and adds a constant field. With the
/// inverse matrix, the compass shows the heading of the undisturbed field.
#[test]
fn a_compass_with_the_calibration_in_its_settings_sees_through_hard_and_soft_iron() {
    let (iron, [xx, yy, xy]) = ([12.0, -8.0, 3.0], [1.2, 0.9, 0.15]);
    let determinant: f64 = xx * yy - xy * xy;
    let mut settings = Settings::default();
    for (setting, value) in [
        (Setting::HardIronForward, iron[0] * 1e3),
        (Setting::HardIronLeft, iron[1] * 1e3),
        (Setting::HardIronUp, iron[2] * 1e3),
        (Setting::SoftIronForward, xx * 1e4),
        (Setting::SoftIronLeft, yy * 1e4),
        (Setting::SoftIronCross, xy * 1e4),
        (Setting::Declination, 4e3),
    ] {
        let key = setting.description().key;
        settings
            .set(key, f64::round(value) as i32)
            .expect("a valid setting");
    }
    let compass = Compass::with_settings(&settings);
    let axes = tilted(0.0, 0.0).level_axes();
    for step in 0..36 {
        let heading = f64::from(step) * PI / 18.0 - PI;
        let [x, y, z] = in_body([20.0, 0.0, -40.0], [heading, 0.0, 0.0]).map(f64::from);
        let disturbed = [
            (yy * x - xy * y) / determinant + iron[0],
            (xx * y - xy * x) / determinant + iron[1],
            z + iron[2],
        ];
        let got = compass.heading(disturbed.map(|value| value as f32), &axes);
        let exact = Angle::from_radians(heading as f32) - Angle::from_degrees(4.0);
        let error = (got.expect("a heading") - exact).degrees();
        assert!(error.abs() < 0.2, "{heading}: {error}");
    }
}
