//! Tests the attitude against rotations in double precision.

use tautrack::estimate::attitude::Attitude;
use tautrack::sensors::{BodySensors, Fresh};
use tautrack::units::Angle;

type Matrix = [[f64; 3]; 3];

const GYROSCOPE: Fresh = Fresh {
    gyroscope: true,
    ..Fresh::NONE
};

fn product(a: Matrix, b: Matrix) -> Matrix {
    let entry = |row: usize, column: usize| (0..3).map(|k| a[row][k] * b[k][column]).sum();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| entry(row, column)))
}

fn transposed(a: Matrix) -> Matrix {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| a[column][row]))
}

/// Axes of a body in the world: turned by the heading, then rolled (left side up), then pitched
/// (nose up).
fn axes([heading, roll, pitch]: [f64; 3]) -> Matrix {
    let ((sh, ch), (sr, cr), (sp, cp)) = (heading.sin_cos(), roll.sin_cos(), pitch.sin_cos());
    let turned = [[ch, -sh, 0.0], [sh, ch, 0.0], [0.0, 0.0, 1.0]];
    let rolled = [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]];
    let pitched = [[cp, 0.0, -sp], [0.0, 1.0, 0.0], [sp, 0.0, cp]];
    product(turned, product(rolled, pitched))
}

/// Angular rate in body axes while the three angles change with these rates, from the axes a moment
/// before and after.
fn body_rate(angles: [f64; 3], rates: [f64; 3]) -> [f32; 3] {
    const MOMENT: f64 = 1e-5;
    let at = |time: f64| axes([0, 1, 2].map(|index| angles[index] + rates[index] * time));
    let (before, after) = (at(-MOMENT), at(MOMENT));
    let step = [0, 1, 2].map(|row| {
        [0, 1, 2].map(|column| (after[row][column] - before[row][column]) / MOMENT / 2.0)
    });
    let spin = product(transposed(at(0.0)), step);
    [spin[2][1], spin[0][2], spin[1][0]].map(|rate| rate as f32)
}

/// An attitude with this heading, roll and pitch.
fn attitude([heading, roll, pitch]: [f64; 3]) -> Attitude {
    let mut attitude = Attitude::default();
    let sensors = BodySensors {
        inclination: [pitch as f32, roll as f32],
        ..BodySensors::default()
    };
    assert!(attitude.update(&sensors, 1e-3));
    attitude.correct_heading(Angle::from_radians(heading as f32), 1e-3);
    attitude
}

#[test]
fn heading_roll_and_pitch_follow_the_gyroscope_of_a_tilted_body() {
    for angles in [
        [0.0, 0.0, 0.0],
        [0.4, 0.5, 0.8],
        [-1.0, -0.9, 0.3],
        [2.0, 0.3, -1.1],
    ] {
        for rates in [
            [0.5, 0.0, 0.0],
            [0.0, 0.4, 0.0],
            [0.0, 0.0, -0.6],
            [0.3, -0.2, 0.5],
        ] {
            let mut attitude = attitude(angles);
            let (mut exact, period) = (angles, 1e-3);
            for _ in 0..200 {
                let middle = [0, 1, 2].map(|axis| exact[axis] + 0.5 * period * rates[axis]);
                let sensors = BodySensors {
                    angular_rate: body_rate(middle, rates),
                    fresh: GYROSCOPE,
                    ..BodySensors::default()
                };
                attitude.update(&sensors, period as f32);
                exact = [0, 1, 2].map(|axis| exact[axis] + period * rates[axis]);
            }
            let got = [attitude.heading(), attitude.roll(), attitude.pitch()];
            for (got, exact) in got.into_iter().zip(exact) {
                let error = (got - Angle::from_radians(exact as f32)).radians();
                assert!(error.abs() < 1e-3, "{angles:?} {rates:?}: {error}");
            }
            let error = f64::from(attitude.pitch_rate()) - rates[2];
            assert!(error.abs() < 2e-3, "{angles:?} {rates:?}: {error}");
        }
    }
}

/// The mean of two readings counts for the time between them. The last reading alone would be wrong
/// by 10 mrad.
#[test]
fn a_slow_gyroscope_of_an_accelerating_body_loses_no_angle() {
    const ACCELERATION: f32 = 2.0;
    let mut attitude = attitude([0.0; 3]);
    for step in 0..1_001_u16 {
        let rate = ACCELERATION * f32::from(step) * 1e-3;
        let sensors = BodySensors {
            angular_rate: [0.0, -rate, 0.0],
            fresh: if step % 10 == 0 {
                GYROSCOPE
            } else {
                Fresh::NONE
            },
            ..BodySensors::default()
        };
        attitude.update(&sensors, 1e-3);
    }
    let error = attitude.pitch().radians() - 0.5 * ACCELERATION;
    assert!(error.abs() < 2e-3, "{error}");
}

#[test]
fn a_distance_in_no_time_is_no_acceleration() {
    let mut attitude = attitude([0.0; 3]);
    attitude.travel(0, 1e-3);
    attitude.travel(100, 0.0);
    attitude.update(&BodySensors::default(), 1e-3);
    assert_eq!(attitude.pitch(), Angle::ZERO);
}

#[test]
fn the_first_compass_heading_is_the_heading() {
    for degrees in [-170.0, -20.0, 60.0, 179.0] {
        let heading = Angle::from_degrees(degrees);
        let mut attitude = Attitude::default();
        attitude.update(&BodySensors::default(), 1e-3);
        attitude.correct_heading(heading, 1e-3);
        assert_eq!(attitude.heading(), heading);
    }
}

/// It turns by at most 0.25 rad/s, and within two seconds by 1 - 1/e of a small difference.
#[test]
fn later_compass_headings_turn_the_heading_slowly() {
    for error in [-2.0, -0.3, 0.3, 2.0_f32] {
        let mut attitude = attitude([1.0, 0.0, 0.0]);
        let start = attitude.heading();
        let compass = start + Angle::from_radians(error);
        attitude.correct_heading(compass, 0.1);
        let step = (attitude.heading() - start).radians();
        let expected = error.abs().min(0.5) / 2.0 * 0.1 * error.signum();
        assert!((step - expected).abs() < 1e-5, "{error}: {step} {expected}");
    }
}

#[test]
fn a_compass_that_begins_late_does_not_make_a_robot_turn() {
    let mut attitude = Attitude::default();
    for _ in 0..400 {
        attitude.update(&BodySensors::default(), 1e-3);
    }
    attitude.correct_heading(Angle::from_degrees(90.0), 0.1);
    let turned = attitude.heading().radians();
    assert!((0.02..0.026).contains(&turned), "{turned}");
}

#[test]
fn axes_of_a_body_that_is_pitched_further_are_those_of_the_larger_pitch() {
    for (roll, pitch, more) in [(0.0, 0.0, 0.5), (0.4, 0.6, 0.7), (-0.3, -0.8, -0.4)] {
        let further = (f64::sin(more) as f32, f64::cos(more) as f32);
        let got = attitude([0.0, roll, pitch]).level_axes().pitched(further);
        let exact = axes([0.0, roll, pitch + more]);
        for (axis, vector) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            for (row, got) in got.of(vector).into_iter().enumerate() {
                assert!(
                    (f64::from(got) - exact[row][axis]).abs() < 1e-5,
                    "{roll} {pitch} {more}"
                );
            }
        }
    }
}

/// Drives on level ground that turn with `speed` and `yaw_rate` for 15 s. The body moves with
/// `grip` times their speed. The gyroscope is wrong by `drift` about x and y, rad/s.
struct Turn {
    speed: f64,
    yaw_rate: f64,
    grip: f64,
    drift: f64,
}

impl Turn {
    /// Largest errors of pitch and roll, degrees. Inclinations follow from the body's acceleration.
    fn errors(&self) -> [f64; 2] {
        let (mut attitude, mut worst) = (Attitude::default(), [0.0_f64; 2]);
        let (mut distance, mut before) = (0.0, 0.0);
        for step in 0..19_000_u32 {
            let time = f64::from(step) * 1e-3;
            // The drives take 0.25 s to start and to stop.
            let share = (4.0 * (time - 2.0))
                .min(4.0 * (17.25 - time))
                .clamp(0.0, 1.0);
            distance += self.speed * share * 1e-3;
            let speed = self.grip * self.speed * share;
            let yaw_rate = self.yaw_rate * share;
            let (along, aside) = ((speed - before) * 1e3, speed * yaw_rate);
            before = speed;
            let sensors = BodySensors {
                inclination: [
                    along.atan2(9.806_65) as f32,
                    aside.atan2(along.hypot(9.806_65)) as f32,
                ],
                angular_rate: [self.drift as f32, self.drift as f32, yaw_rate as f32],
                fresh: Fresh {
                    inclinometer: step.is_multiple_of(10),
                    ..Fresh::ALL
                },
                ..BodySensors::default()
            };
            attitude.update(&sensors, 1e-3);
            if (step + 1).is_multiple_of(4) {
                attitude.travel((distance * 1e6) as i32, 4e-3);
            }
            for (worst, found) in worst.iter_mut().zip([attitude.pitch(), attitude.roll()]) {
                *worst = worst.max(f64::from(found.radians()).to_degrees().abs());
            }
        }
        worst
    }
}

/// The acceleration of the drives over g is up to 5.8 degrees. An estimate that subtracts it while
/// the tracks spin would be wrong by as much. The gyroscope is wrong by up to 0.1 degree/s: it
/// turns the estimate by 0.2 degree while the inclinometer corrects, and by 1.5 degrees in 15 s
/// while the drives explain its reading.
#[test]
fn spinning_tracks_turn_the_estimate_by_no_more_than_the_gyroscope_drifts() {
    let mut random = crate::random::Random(7);
    for number in 0..60 {
        let turn = Turn {
            speed: 0.5 * random.next(),
            yaw_rate: 2.0 * random.next(),
            grip: [0.0, 1.0, random.next().abs()][number % 3],
            drift: 0.1_f64.to_radians() * random.next(),
        };
        let [pitch, roll] = turn.errors();
        let explained = (turn.speed * turn.yaw_rate / 9.806_65).to_degrees().abs();
        let drift = turn.drift.to_degrees().abs();
        let bound = 0.3 + 2.0 * drift + explained.min(15.0 * drift);
        assert!(roll < bound, "{number}: roll {roll} of {bound}");
        assert!(pitch < 0.3 + 2.0 * drift, "{number}: pitch {pitch}");
    }
}

/// The slowest turn of the crawler's tracks with a friction of 0.05: 0.4 m/s and 57 degrees/s.
#[test]
fn tracks_that_spin_on_ice_turn_the_estimate_by_less_than_half_a_degree() {
    let turn = Turn {
        speed: 0.4,
        yaw_rate: 57_f64.to_radians(),
        grip: 0.05,
        drift: 0.01_f64.to_radians(),
    };
    let [pitch, roll] = turn.errors();
    assert!(pitch < 0.2 && roll < 0.5, "{pitch} {roll}");
}

/// The errors of three axes add up at a pitch, and more so at a roll.
#[test]
fn an_error_on_every_axis_of_the_gyroscope_turns_the_estimate_by_at_most_its_drift() {
    const RATE: f64 = 0.0175;
    for [roll, pitch] in [[0.0, 0.0], [0.0, 0.8], [0.6, 0.0], [-0.6, 0.8], [0.5, -1.0]] {
        let mut most = 0.0_f64;
        let mut bound = 0.0;
        for signs in 0..8_u32 {
            let mut attitude = attitude([0.0, roll, pitch]);
            let sign = |axis: u32| if signs >> axis & 1 == 0 { RATE } else { -RATE };
            for _ in 0..20_000 {
                let sensors = BodySensors {
                    inclination: [pitch as f32, roll as f32],
                    angular_rate: [sign(0) as f32, sign(1) as f32, sign(2) as f32],
                    ..BodySensors::default()
                };
                attitude.update(&sensors, 1e-3);
            }
            let found = [attitude.pitch(), attitude.roll()].map(|angle| f64::from(angle.radians()));
            most = most
                .max((found[0] - pitch).abs())
                .max((found[1] - roll).abs());
            bound = f64::max(bound, f64::from(attitude.drift(RATE as f32)));
        }
        let place = format!("{roll} {pitch}: {most} of {bound}");
        assert!(most <= 1.02 * bound && most > 0.8 * bound, "{place}");
    }
}

/// A steady turn with grip, a gyroscope without error, and 3 degrees of noise: what is above the
/// explained 2.3 degrees corrects the estimate, and what is below does not.
#[test]
fn noise_in_a_long_turn_stays_within_the_drift() {
    let (speed, yaw_rate) = (0.4_f64, 0.985_f64);
    let mut random = crate::random::Random(3);
    let (mut attitude, mut largest) = (Attitude::default(), 0.0_f64);
    for step in 0..60_000_u32 {
        let aside = (speed * yaw_rate).atan2(9.806_65);
        let noise: f64 = 0.052 * (0..4).map(|_| random.next()).sum::<f64>() * 0.866;
        let sensors = BodySensors {
            inclination: [0.0, if step < 100 { 0.0 } else { aside + noise } as f32],
            angular_rate: [0.0, 0.0, if step < 100 { 0.0 } else { yaw_rate } as f32],
            fresh: Fresh {
                inclinometer: step.is_multiple_of(10),
                ..Fresh::ALL
            },
            ..BodySensors::default()
        };
        attitude.update(&sensors, 1e-3);
        if (step + 1).is_multiple_of(4) {
            let turned = f64::from(step.saturating_sub(100)) * 1e-3;
            attitude.travel((speed * turned * 1e6) as i32, 4e-3);
        }
        if step > 20_000 {
            let roll = f64::from(attitude.roll().radians()).abs();
            largest = largest.max(roll);
            let bound = f64::from(attitude.drift(0.0)) + 1e-3;
            assert!(roll < bound, "{step}: {roll} of {bound}");
        }
    }
    assert!(largest > 2e-3, "{largest}");
}
