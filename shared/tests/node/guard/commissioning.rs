//! Tests of the commissioning of the sensors: a board with known errors on a body that is raised
//! and turned by hand. The board is modelled in double precision with rotation matrices.

use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::compass::Compass;
use tautrack::node::guard::commissioning::{Commissioning, Reason, progress, request};
use tautrack::sensing::mounting::Mounting;
use tautrack::sensors::{BodySensors, Fresh};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

pub(super) type Matrix = [[f64; 3]; 3];
pub(super) type Vector = [f64; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum())
    })
}

fn transposed(a: &Matrix) -> Matrix {
    core::array::from_fn(|row| core::array::from_fn(|column| a[column][row]))
}

pub(super) fn applied(a: &Matrix, v: Vector) -> Vector {
    core::array::from_fn(|row| (0..3).map(|k| a[row][k] * v[k]).sum())
}

/// Rotation by `angle` about the unit vector `axis` (Rodrigues).
pub(super) fn about(axis: Vector, angle: f64) -> Matrix {
    let (sine, cosine) = angle.sin_cos();
    let [x, y, z] = axis;
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    core::array::from_fn(|row| {
        core::array::from_fn(|column| {
            let one = f64::from(u8::from(row == column));
            cosine * one + sine * cross[row][column] + (1.0 - cosine) * axis[row] * axis[column]
        })
    })
}

/// Rotation from body axes to world axes (x north, y west, z up). The pitch raises the nose, the
/// roll the left side.
fn pose(heading: f64, roll: f64, pitch: f64) -> Matrix {
    let tilt = times(
        &about([1.0, 0.0, 0.0], roll),
        &about([0.0, 1.0, 0.0], -pitch),
    );
    times(&about([0.0, 0.0, 1.0], heading), &tilt)
}

/// Sensor board with known errors.
pub(super) struct Board {
    /// From the axes of the board to those of the body.
    pub mounting: Matrix,
    /// In the axes of the board, rad/s.
    pub rate_at_rest: Vector,
    pub hard_iron: Vector,
    pub soft_iron: Matrix,
    pub inclinometer_offset: [f64; 2],
    /// Factors of the axes of gyroscope, magnetometer and inclinometer.
    pub gyroscope: Vector,
    pub magnetometer: Vector,
    pub inclinometer: [f64; 2],
    /// The earth's field to the north, to the west and up, uT.
    pub earth: Vector,
    /// Factor of all noise; 0 is none.
    pub noisy: f64,
    /// Time between two readings, s, and readings of the other sensors per reading of the
    /// magnetometer.
    pub period: f64,
    pub readings_per_field: u64,
    pub before: Matrix,
    pub step: u64,
}

impl Board {
    /// A board that is mounted off by 10 degrees about an oblique axis. Its gyroscope reads 2
    /// degrees/s at rest, and the hard iron is 30 uT.
    pub fn new() -> Self {
        Self {
            mounting: about([1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], 10.0_f64.to_radians()),
            rate_at_rest: [4.0 / 3.0, -4.0 / 3.0, 2.0 / 3.0].map(f64::to_radians),
            hard_iron: [20.0, -10.0, 20.0],
            soft_iron: [[1.08, 0.03, 0.0], [0.03, 0.95, 0.0], [0.0, 0.0, 1.0]],
            inclinometer_offset: [0.02, -0.01],
            gyroscope: [1.0; 3],
            magnetometer: [1.0; 3],
            inclinometer: [1.0; 2],
            earth: [22.3, 0.0, -41.9],
            noisy: 1.0,
            period: 1e-3,
            readings_per_field: 100,
            before: pose(0.0, 0.0, 0.0),
            step: 0,
        }
    }

    /// Noise of this standard deviation: the sum of twelve uniform numbers.
    fn noise(&self, channel: u64, sigma: f64) -> f64 {
        let mut state = (self.step * 16 + channel).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let sum: f64 = (0..12)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum();
        self.noisy * sigma * (sum - 6.0)
    }

    /// Readings in this pose, a period after the one before.
    fn read(&mut self, pose: Matrix) -> BodySensors {
        self.step += 1;
        let into_body = transposed(&pose);
        let into_board = transposed(&self.mounting);
        let change = times(&transposed(&self.before), &pose);
        self.before = pose;
        // For a small rotation, the antisymmetric part holds the angles.
        let rate = [
            change[2][1] - change[1][2],
            change[0][2] - change[2][0],
            change[1][0] - change[0][1],
        ]
        .map(|twice| 0.5 * twice / self.period);
        let earth = applied(&into_body, self.earth);
        let iron = applied(&self.soft_iron, earth);
        let force = applied(&into_board, applied(&into_body, [0.0, 0.0, 9.806_65]));
        let rate = applied(&into_board, rate);
        let field = applied(
            &into_board,
            core::array::from_fn(|axis| iron[axis] + self.hard_iron[axis]),
        );
        let [x, y, z] = force;
        let inclination = [x.atan2(z), y.atan2(x.hypot(z))];
        let vector = |first: u64, values: Vector, sigma: f64| {
            core::array::from_fn(|axis| {
                (values[axis] + self.noise(first + axis as u64, sigma)) as f32
            })
        };
        BodySensors {
            inclination: core::array::from_fn(|axis| {
                let noise = self.noise(axis as u64, 0.001);
                let shown = self.inclinometer[axis] * inclination[axis];
                (shown + self.inclinometer_offset[axis] + noise) as f32
            }),
            specific_force: vector(2, force, 0.03),
            angular_rate: vector(
                5,
                core::array::from_fn(|axis| {
                    self.gyroscope[axis] * rate[axis] + self.rate_at_rest[axis]
                }),
                0.003,
            ),
            magnetic_field: vector(
                8,
                core::array::from_fn(|axis| self.magnetometer[axis] * field[axis]),
                0.15,
            ),
            fresh: Fresh {
                magnetometer: self.step.is_multiple_of(self.readings_per_field),
                ..Fresh::ALL
            },
        }
    }
}

/// Attitude of the body: heading, roll and pitch, rad.
type Angles = [f64; 3];

/// A person who commissions the sensors.
pub(super) struct Bench {
    board: Board,
    pub commissioning: Commissioning,
    angles: Angles,
}

impl Bench {
    pub fn new(board: Board) -> Self {
        let mut bench = Self {
            board,
            commissioning: Commissioning::default(),
            angles: [0.0; 3],
        };
        bench.turn([0.0; 3], 1.0);
        bench
    }

    /// Turns the body evenly to these angles.
    pub fn turn(&mut self, to: Angles, seconds: f64) {
        let (from, steps) = (self.angles, (seconds / self.board.period).round() as u32);
        for step in 1..=steps {
            let done = f64::from(step) / f64::from(steps);
            self.angles = core::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * done);
            let [heading, roll, pitch] = self.angles;
            let sensors = self.board.read(pose(heading, roll, pitch));
            self.commissioning.sense(&sensors, self.board.period as f32);
        }
    }

    /// Requests a resting step. Returns why it was refused.
    pub fn rest(&mut self, request: u8) -> Option<u8> {
        self.commissioning.request(request, true);
        self.turn(self.angles, 4.1);
        self.ended()
    }

    pub fn ended(&self) -> Option<u8> {
        let report = self.commissioning.report();
        match report.progress {
            progress::DONE => None,
            progress::REFUSED => Some(report.reason),
            other => panic!("step {other} goes on"),
        }
    }

    /// All steps in their order. Returns why the first one was refused.
    pub fn commission(&mut self) -> Option<u8> {
        let raised = 15.0_f64.to_radians();
        if let Some(reason) = self.rest(request::LEVEL) {
            return Some(reason);
        }
        self.turn([0.0, 0.0, raised], 3.0);
        if let Some(reason) = self.rest(request::NOSE_UP) {
            return Some(reason);
        }
        self.turn([0.0; 3], 3.0);
        self.turn([0.0, raised, 0.0], 3.0);
        if let Some(reason) = self.rest(request::LEFT_UP) {
            return Some(reason);
        }
        self.turn([0.0; 3], 3.0);
        self.commissioning.request(request::TURN, false);
        self.turn([7.0, 0.0, 0.0], 30.0);
        self.ended()
    }

    /// The settings that a client writes.
    fn settings(&self) -> Settings {
        let report = self.commissioning.report();
        let values = &report.values;
        let mut settings = Settings::default();
        for (setting, value) in [
            (Setting::MountingX, values.mounting[0]),
            (Setting::MountingY, values.mounting[1]),
            (Setting::MountingZ, values.mounting[2]),
            (Setting::RateAtRestX, values.rate_at_rest[0]),
            (Setting::RateAtRestY, values.rate_at_rest[1]),
            (Setting::RateAtRestZ, values.rate_at_rest[2]),
            (Setting::LevelPitch, values.level[0]),
            (Setting::LevelRoll, values.level[1]),
            (Setting::HardIronForward, values.hard_iron[0]),
            (Setting::HardIronLeft, values.hard_iron[1]),
            (Setting::HardIronUp, values.hard_iron[2]),
            (Setting::SoftIronForward, values.soft_iron[0]),
            (Setting::SoftIronLeft, values.soft_iron[1]),
            (Setting::SoftIronCross, values.soft_iron[2]),
            (Setting::SensorAxes, i32::from(report.axes)),
        ] {
            settings
                .set(setting.description().key, value)
                .expect("a value within its bounds");
        }
        settings
    }
}

/// Largest errors of pitch or roll and of the heading at rest in several attitudes, degrees.
fn errors(settings: &Settings) -> [f64; 2] {
    let (mounting, compass) = (
        Mounting::with_settings(settings),
        Compass::with_settings(settings),
    );
    let mut worst = [0.0_f64; 2];
    for (index, (roll, pitch)) in (0..8).zip([(0.0, 0.0), (0.0, 0.2), (-0.15, 0.1)].iter().cycle())
    {
        let heading = f64::from(index) * std::f64::consts::FRAC_PI_4;
        let (mut board, mut attitude) = (Board::new(), Attitude::default());
        let still = pose(heading, *roll, *pitch);
        board.before = still;
        let mut shown = None;
        for _ in 0..20_000 {
            let sensors = mounting.apply(&board.read(still));
            attitude.update(&sensors, 1e-3);
            if sensors.fresh.magnetometer {
                shown = compass
                    .heading(sensors.magnetic_field, &attitude.level_axes())
                    .ok();
            }
        }
        let off = |angle: Angle, truth: f64| {
            let off = (angle - Angle::from_radians(truth as f32)).radians();
            f64::from(off.abs().to_degrees())
        };
        let tilt = off(attitude.pitch(), *pitch).max(off(attitude.roll(), *roll));
        let heading = shown.map_or(180.0, |shown| off(shown, heading));
        worst = [worst[0].max(tilt), worst[1].max(heading)];
    }
    worst
}

#[test]
fn after_commissioning_attitude_and_heading_are_right_though_the_board_is_wrong() {
    let before = errors(&Settings::default());
    assert!(before[0] > 5.0 && before[1] > 20.0, "{before:?}");
    let mut bench = Bench::new(Board::new());
    assert_eq!(bench.commission(), None);
    let report = *bench.commissioning.report();
    assert_eq!(report.axes, 7);
    let [tilt, heading] = errors(&bench.settings());
    assert!(tilt < 0.5 && heading < 3.0, "{tilt} {heading} {report:?}");
}

#[test]
fn a_wrong_sign_of_any_axis_is_found() {
    for axis in 0..3 {
        let mut board = Board::new();
        board.gyroscope[axis] = -1.0;
        let mut bench = Bench::new(board);
        let refused = bench.commission();
        let expected = if axis == 2 {
            // The gyroscope turns the other way than the field.
            Reason::MagnetometerSign
        } else {
            Reason::GyroscopeSign
        };
        assert_eq!(refused, Some(expected as u8), "gyroscope, axis {axis}");
        assert_ne!(bench.commissioning.report().axes, 7);
    }
    for axis in 0..2 {
        let mut board = Board::new();
        board.magnetometer[axis] = -1.0;
        let refused = Bench::new(board).commission();
        let expected = Some(Reason::MagnetometerSign as u8);
        assert_eq!(refused, expected, "magnetometer, axis {axis}");
    }
}

#[test]
fn the_steps_need_their_order_rest_and_the_right_side_up() {
    let mut bench = Bench::new(Board::new());
    assert_eq!(bench.rest(request::NOSE_UP), Some(Reason::Order as u8));
    bench.commissioning.request(request::LEVEL, false);
    assert_eq!(bench.ended(), Some(Reason::NotDisarmed as u8));
    assert_eq!(bench.rest(9), Some(Reason::Unknown as u8));
    bench.commissioning.request(request::LEVEL, true);
    bench.turn([0.2, 0.0, 0.0], 1.0);
    bench.turn([0.2, 0.0, 0.0], 3.1);
    assert_eq!(bench.ended(), Some(Reason::Moved as u8));
    assert_eq!(bench.rest(request::LEVEL), None);
    assert_eq!(bench.rest(request::NOSE_UP), Some(Reason::NotRaised as u8));
    // The tail is raised instead of the nose. The left side then is found on the right.
    bench.turn([0.2, 0.0, -0.25], 3.0);
    assert_eq!(bench.rest(request::NOSE_UP), None);
    bench.turn([0.2, 0.0, 0.0], 3.0);
    bench.turn([0.2, 0.25, 0.0], 3.0);
    assert_eq!(bench.rest(request::LEFT_UP), Some(Reason::NotRaised as u8));
}
