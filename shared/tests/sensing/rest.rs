//! Tests of what the guard learns of its sensors while the robot rests.

use std::f64::consts::TAU;
use tautrack::constants::GRAVITY;
use tautrack::sensing::rest::Rest;
use tautrack::sensors::BodySensors;

/// Period of an evaluation, s, and ticks in it.
const PERIOD: f32 = 4e-3;
const TICKS: u32 = 4;

/// Motion of a robot with a time in s: pitch in rad, and yaw rate about its own axis in rad/s.
type Motion<'a> = &'a dyn Fn(f64) -> (f64, f64);

/// A robot and the constant errors of its sensors.
struct Robot {
    rest: Rest,
    time: f64,
    rate_error: [f32; 3],
    force_error: [f32; 3],
    /// Noise of the inclinometer, rad, as a multiple of 1.5 mrad.
    noise: f32,
    seed: u32,
}

impl Robot {
    fn new(rate_error: [f32; 3]) -> Self {
        Self {
            rest: Rest::default(),
            time: 0.0,
            rate_error: rate_error.map(f32::to_radians),
            force_error: [0.0; 3],
            noise: 1.0,
            seed: 1,
        }
    }

    /// Sum of four uniform numbers, with a standard deviation of 1.
    fn random(&mut self) -> f32 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.seed = self
                .seed
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            sum += (self.seed >> 8) as f32 / 16_777_216.0 - 0.5;
        }
        sum * 1.732
    }

    /// Moves for `seconds`. Readings follow from the attitude: the rate is its difference quotient.
    fn run(&mut self, seconds: f64, rests: bool, motion: Motion) -> Option<[f32; 2]> {
        let mut learned = None;
        for _ in 0..(seconds / f64::from(PERIOD)).round() as u32 {
            for _ in 0..TICKS {
                let before = motion(self.time).0;
                self.time += 1e-3;
                let (pitch, yaw_rate) = motion(self.time);
                let rate = [0.0, -(pitch - before) * 1e3, yaw_rate];
                let force = [libm::sin(pitch), 0.0, libm::cos(pitch)];
                let noise: [f32; 8] = core::array::from_fn(|_| self.random() * self.noise);
                let error = (self.rate_error, self.force_error);
                self.rest.receive(&BodySensors {
                    inclination: [pitch as f32 + 1.5e-3 * noise[0], 1.5e-3 * noise[1]],
                    specific_force: core::array::from_fn(|axis| {
                        force[axis] as f32 * GRAVITY + error.1[axis] + 0.03 * noise[2 + axis]
                    }),
                    angular_rate: core::array::from_fn(|axis| {
                        rate[axis] as f32 + error.0[axis] + 3e-3 * noise[5 + axis]
                    }),
                    ..BodySensors::default()
                });
            }
            learned = self.rest.advance(rests, PERIOD).or(learned);
        }
        learned
    }

    fn learned(&self) -> [f32; 3] {
        self.rest.rate().map(f32::to_degrees)
    }
}

const STANDING: Motion = &|_| (0.0, 0.0);

fn near(found: [f32; 3], expected: [f32; 3], bound: f32) -> bool {
    let mut pairs = found.iter().zip(expected);
    pairs.all(|(found, expected)| (found - expected).abs() <= bound)
}

#[test]
fn the_first_rest_shows_the_constant_errors_of_gyroscope_and_accelerometer() {
    for sign in [-1.0, 1.0] {
        for pitch in [0.0, 0.7, -0.3] {
            let rate_error = [4.0 * sign, -4.0 * sign, 4.0];
            let mut robot = Robot::new(rate_error);
            robot.force_error = [0.98 * sign, 0.98, -0.98 * sign];
            assert!(robot.run(0.38, true, &|_| (pitch, 0.0)).is_none());
            let level = robot.run(0.03, true, &|_| (pitch, 0.0)).expect("a rest");
            assert!((f64::from(level[0]) - pitch).abs() < 1e-3, "{level:?}");
            assert!(
                near(robot.learned(), rate_error, 0.05),
                "{:?}",
                robot.learned()
            );
            assert!(near(robot.rest.force(), robot.force_error, 0.02));
            let largest = robot.rest.largest_rate().to_degrees();
            assert!((largest - 4.0).abs() < 0.05, "{largest}");
        }
    }
}

/// Rocking by a degree, and the slow turn of a robot that is carried. What is learned is wrong by
/// no more than the uncertainty, which a noise of the readings adds to.
#[test]
fn a_robot_that_turns_or_rocks_slowly_teaches_no_more_than_the_uncertainty() {
    let rocking = |hertz: f64| move |time: f64| (0.0175 * libm::sin(TAU * hertz * time), 0.0);
    let trembling = |time: f64| (0.0052 * libm::sin(36.13 * time), 0.0);
    let motions: [Motion; 9] = [
        &trembling,
        &rocking(4.5),
        &rocking(5.0),
        &|time| (1.0_f64.to_radians() * time, 0.0),
        &|time| (-1.0_f64.to_radians() * time, 0.0),
        &|time| (0.4_f64.to_radians() * time, 0.0),
        &rocking(0.1),
        &rocking(0.3),
        &rocking(0.7),
    ];
    for (number, motion) in motions.into_iter().enumerate() {
        for noise in [0.1, 1.0, 3.0] {
            let mut robot = Robot::new([0.0; 3]);
            robot.noise = noise;
            for _ in 0..5_000 {
                robot.run(4e-3, true, motion);
                let taught = robot.learned();
                let bound = robot.rest.rate_uncertainty().to_degrees();
                assert!(
                    near(taught, [0.0; 3], bound),
                    "{number} {noise}: {taught:?} {bound}"
                );
            }
        }
    }
    let mut turning = Robot::new([0.0; 3]);
    assert!(turning.run(20.0, true, motions[3]).is_none());
    assert!(!turning.rest.wait(true, 3.0));
    let bound = turning.rest.rate_uncertainty().to_degrees();
    assert!((bound - 6.0).abs() < 0.1, "{bound}");
}

/// No inclinometer shows a turn about the vertical.
#[test]
fn a_rest_that_changes_the_error_by_more_than_it_can_drift_teaches_nothing() {
    let mut robot = Robot::new([1.0, -2.0, 3.0]);
    robot.run(3.0, true, STANDING);
    robot.run(60.0, false, STANDING);
    let bound = robot.rest.rate_uncertainty().to_degrees();
    assert!((0.1..0.25).contains(&bound), "{bound}");
    robot.run(10.0, true, &|_| (0.0, 0.0175));
    let taught = robot.learned();
    assert!(near(taught, [1.0, -2.0, 3.0], 0.02), "{taught:?}");
    robot.run(10.0, true, &|_| (0.0, 0.1_f64.to_radians()));
    let taught = robot.learned();
    assert!(near(taught, [1.0, -2.0, 3.1], 0.02), "{taught:?}");
}

/// The readings of the test have a noise of 1.5 mrad: 0.1 mrad in the mean of 200. Three to four
/// times that of two means is 0.03 degrees, in 0.2 s and in 0.8 s. The error grows by 0.1 degree/s
/// in a minute.
#[test]
fn the_uncertainty_falls_with_the_rest_and_grows_after_it() {
    let uncertainty = |robot: &Robot| robot.rest.rate_uncertainty().to_degrees();
    let mut robot = Robot::new([0.0; 3]);
    robot.run(0.41, true, STANDING);
    let first = uncertainty(&robot);
    assert!((0.1..0.3).contains(&first), "{first}");
    robot.run(0.63, true, STANDING);
    let second = uncertainty(&robot);
    assert!((0.02..0.1).contains(&second), "{second}");
    robot.run(60.0, false, STANDING);
    let grown = uncertainty(&robot) - second;
    assert!((grown - 0.1).abs() < 0.01, "{grown}");
    robot.run(6.0, true, STANDING);
    assert!(uncertainty(&robot) < 0.1, "{}", uncertainty(&robot));
}

/// The gyroscope warms up while the robot stands: each rest follows it.
#[test]
fn a_robot_that_stands_for_long_follows_the_drift() {
    let mut robot = Robot::new([4.0, 0.0, 0.0]);
    for second in 0_u16..600 {
        robot.rate_error[0] = (4.0 - 0.08 / 60.0 * f32::from(second)).to_radians();
        robot.run(1.0, true, STANDING);
    }
    let taught = robot.learned();
    assert!(near(taught, [3.2, 0.0, 0.0], 0.05), "{taught:?}");
}

/// Each of many robots with three and ten times the usual noise learns in its first second, and is
/// wrong by no more than its uncertainty.
#[test]
fn a_noisy_robot_at_rest_is_learned_less_precisely() {
    for noise in [3.0, 10.0] {
        for seed in 1..200 {
            let mut robot = Robot::new([4.0, -4.0, 4.0]);
            (robot.noise, robot.seed) = (noise, seed * 7_919);
            let learned = robot.run(1.01, true, STANDING);
            assert!(learned.is_some(), "{noise} {seed}");
            let bound = robot.rest.rate_uncertainty().to_degrees();
            assert!((0.1..6.0).contains(&bound), "{noise} {seed}: {bound}");
            let taught = robot.learned();
            assert!(near(taught, [4.0, -4.0, 4.0], bound), "{taught:?} {bound}");
        }
    }
}

/// An inclinometer that is wrong by 20 degrees is no error of the accelerometer.
#[test]
fn a_force_that_is_far_from_gravity_is_not_learned() {
    let mut robot = Robot::new([0.0; 3]);
    robot.force_error = [0.34 * GRAVITY, 0.0, 0.0];
    robot.run(3.0, true, STANDING);
    assert!(!robot.rest.wait(true, 0.1));
    assert!(near(robot.rest.force(), [0.0; 3], 0.0));
}

/// A ferry turns by 3 degrees/s while the robot stands on it. No inclinometer shows that.
#[test]
fn a_rest_that_contradicts_the_one_before_widens_the_uncertainty_until_it_has_lasted() {
    let mut robot = Robot::new([0.0; 3]);
    robot.run(5.0, true, &|_| (0.0, 3.0_f64.to_radians()));
    assert!(near(robot.learned(), [0.0, 0.0, 3.0], 0.05));
    robot.run(1.0, true, STANDING);
    let bound = robot.rest.rate_uncertainty().to_degrees();
    assert!((2.9..3.5).contains(&bound), "{bound}");
    robot.run(12.0, true, STANDING);
    assert!(near(robot.learned(), [0.0; 3], 0.05));
    let bound = robot.rest.rate_uncertainty().to_degrees();
    assert!(bound < 0.2, "{bound}");
}

#[test]
fn a_robot_without_noise_is_known_within_the_resolution() {
    let mut robot = Robot::new([1.0, 0.0, 0.0]);
    robot.noise = 0.0;
    robot.run(1.0, true, STANDING);
    let bound = robot.rest.rate_uncertainty().to_degrees();
    assert!(
        robot.rest.known() && (0.04..0.1).contains(&bound),
        "{bound}"
    );
    robot.run(60.0, false, STANDING);
    let grown = robot.rest.rate_uncertainty().to_degrees() - bound;
    assert!((grown - 0.1).abs() < 0.01, "{grown}");
}

/// A gyroscope that warms up fast, by 0.45 degree/s in the first minute.
#[test]
fn a_drift_that_is_faster_than_expected_stays_within_the_uncertainty() {
    let mut robot = Robot::new([4.0, 0.0, 0.0]);
    for second in 0_u16..900 {
        let error = 4.0 - 2.25 * (1.0 - (-f32::from(second) / 300.0).exp());
        robot.rate_error[0] = error.to_radians();
        robot.run(1.0, true, STANDING);
        let bound = robot.rest.rate_uncertainty().to_degrees() + 0.02;
        let taught = robot.learned();
        assert!(
            near(taught, [error, 0.0, 0.0], bound),
            "{second}: {taught:?} {bound}"
        );
    }
}
