//! Tests the mounting of the sensor board against rotations in double precision.

use crate::random::Random;
use tautrack::estimate::attitude::pitch_and_roll;
use tautrack::sensing::mounting::Mounting;
use tautrack::sensors::BodySensors;
use tautrack::units::Angle;

/// Turns a vector about one axis.
fn turned(vector: [f64; 3], axis: usize, angle: f64) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut result = vector;
    result[first] = vector[first] * cosine - vector[second] * sine;
    result[second] = vector[first] * sine + vector[second] * cosine;
    result
}

/// From the axes of the board to those of the body: about x, then y, then z.
fn to_body(vector: [f64; 3], angles: [f64; 3]) -> [f64; 3] {
    (0..3).fold(vector, |vector, axis| turned(vector, axis, angles[axis]))
}

fn mounting(angles: [f64; 3]) -> Mounting {
    let angles = angles.map(|angle| Angle::from_radians(angle as f32));
    Mounting::new(angles, [0.01, -0.02, 0.03], [0.04, -0.05])
}

fn close(got: [f32; 3], exact: [f64; 3]) -> bool {
    got.into_iter()
        .zip(exact)
        .all(|(got, exact)| (f64::from(got) - exact).abs() < 1e-4)
}

#[test]
fn readings_are_turned_about_x_then_y_then_z() {
    let mut random = Random(11);
    for _ in 0..100 {
        let angles = [0; 3].map(|_| 3.0 * random.next());
        let vectors = [[0; 3]; 3].map(|vector| vector.map(|_| 10.0 * random.next()));
        let [force, rate, field] = vectors.map(|vector| vector.map(|value| value as f32));
        let sensors = BodySensors {
            specific_force: force,
            angular_rate: rate,
            magnetic_field: field,
            ..BodySensors::default()
        };
        let body = mounting(angles).apply(&sensors);
        assert!(close(body.specific_force, to_body(vectors[0], angles)));
        assert!(close(body.magnetic_field, to_body(vectors[2], angles)));
        let [x, y, z] = to_body(vectors[1], angles);
        assert!(close(body.angular_rate, [x - 0.01, y + 0.02, z - 0.03]));
    }
}

/// Pitch and roll of a body whose board is turned are those of its direction up.
#[test]
fn the_inclinometer_of_a_turned_board_shows_the_inclination_of_the_body() {
    let mut random = Random(13);
    for _ in 0..200 {
        let angles = [0; 3].map(|_| 0.6 * random.next());
        let [pitch, roll] = [0; 2].map(|_| 0.9 * random.next());
        // Up in the axes of a board with this pitch and roll.
        let up = [
            pitch.sin() * roll.cos(),
            roll.sin(),
            pitch.cos() * roll.cos(),
        ];
        let [x, y, z] = to_body(up, angles);
        let exact = [x.atan2(z), y.atan2(x.hypot(z))];
        let sensors = BodySensors {
            inclination: [pitch as f32, roll as f32],
            ..BodySensors::default()
        };
        let mounting = mounting(angles);
        let body = mounting.apply(&sensors).inclination;
        let direct = mounting.inclination(sensors.inclination);
        for axis in 0..2 {
            let level = [0.04, -0.05][axis];
            assert!(
                (f64::from(direct[axis]) - exact[axis]).abs() < 1e-4,
                "{angles:?}"
            );
            assert!((f64::from(body[axis]) - exact[axis] + level).abs() < 1e-4);
        }
        let found = pitch_and_roll([x, y, z].map(|value| (9.0 * value) as f32));
        assert!((f64::from(found[1]) - exact[1]).abs() < 1e-4);
    }
}

#[test]
fn a_board_that_is_not_turned_loses_its_constant_errors_alone() {
    let sensors = BodySensors {
        inclination: [0.1, 0.2],
        specific_force: [1.0, 2.0, 3.0],
        ..BodySensors::default()
    };
    let body = mounting([0.0; 3]).apply(&sensors);
    assert_eq!(body.specific_force, [1.0, 2.0, 3.0]);
    let [pitch, roll] = body.inclination;
    assert!((pitch - 0.06).abs() < 1e-6 && (roll - 0.25).abs() < 1e-6);
}
