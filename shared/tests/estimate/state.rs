//! Tests the state q: validity, ages and which readings move it.

use crate::framed;
use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::position::GATE;
use tautrack::estimate::state::{Estimator, Joint, State, Validity};
use tautrack::sensors::{BodySensors, Fresh};
use tautrack::settings::Settings;
use tautrack::units::Angle;

proptest! {
    #[test]
    fn garbage_never_makes_a_position_valid(chunks in vec(vec(any::<u8>(), 0..40), 1..200)) {
        let mut estimator = Estimator::new(&Settings::default());
        for (step, bytes) in (0..).zip(&chunks) {
            estimator.listen(bytes, step * 1_000);
        }
        let end_us = chunks.len() as u64 * 1_000;
        let attitude = Attitude::default();
        estimator.advance(0, None, [Joint::default(); 2], &attitude, end_us);
        let state = estimator.state(&attitude, end_us);
        prop_assert!(state.iter().all(|reading| reading.validity == Validity::Invalid && reading.value == 0.0));
    }

    #[test]
    fn sentences_with_swapped_and_struck_bytes_never_move_a_believed_position_far(
        hits in vec((0..2_000_usize, any::<u8>()), 1..200),
    ) {
        let mut estimator = Estimator::new(&Settings::default());
        let line = |step: u64| framed(&format!("GPGGA,{:06}.{:02},4728.70400,N,00033.79200,W,1,08,1.1,40.0,M,48.0,M,,", 120_000 + step / 5, step % 5 * 20));
        for step in 0..20 {
            estimator.listen(&line(step), step * 200_000);
        }
        let mut bytes: Vec<u8> = (20..50).flat_map(line).collect();
        for (place, byte) in hits {
            let place = place % bytes.len();
            bytes[place] = byte;
        }
        estimator.listen(&bytes, 10_000_000);
        let attitude = Attitude::default();
        estimator.advance(0, None, [Joint::default(); 2], &attitude, 10_000_000);
        let state = estimator.state(&attitude, 10_000_000);
        prop_assert!(state[..3].iter().all(|reading| reading.value.abs() <= GATE), "{state:?}");
    }
}

/// A robot that faces north, with all sensors at 1 kHz and a compass at 100 Hz, and its clock.
struct Robot {
    estimator: Estimator,
    attitude: Attitude,
    now_us: u64,
    odometry_um: i32,
    belts_us: Option<u64>,
    /// Direction of magnetic north, rad, and whether the compass, the gyroscope and the belts send.
    north: f32,
    compass: bool,
    gyroscope: bool,
    belts: bool,
}

impl Robot {
    fn new() -> Self {
        Self {
            estimator: Estimator::new(&Settings::default()),
            attitude: Attitude::default(),
            now_us: 1_000_000,
            odometry_um: 0,
            belts_us: None,
            north: 0.0,
            compass: true,
            gyroscope: true,
            belts: true,
        }
    }

    /// Runs for some ms, in each of which the belts travel `way_um`.
    fn run(&mut self, milliseconds: u64, way_um: i32) {
        for _ in 0..milliseconds {
            self.now_us += 1_000;
            // The last digit of every reading changes.
            let noise = (self.now_us / 1_000 % 7) as f32 * 1e-3;
            let sensors = BodySensors {
                magnetic_field: [
                    20.0 * self.north.cos() + noise,
                    -20.0 * self.north.sin(),
                    -40.0,
                ],
                fresh: Fresh {
                    magnetometer: self.compass && self.now_us.is_multiple_of(10_000),
                    gyroscope: self.gyroscope,
                    ..Fresh::ALL
                },
                ..BodySensors::default()
            };
            self.attitude.update(&sensors, 1e-3);
            self.estimator
                .sense(&sensors, &mut self.attitude, self.now_us);
            self.odometry_um += way_um;
            if self.belts {
                self.belts_us = Some(self.now_us);
            }
            let joint = Joint {
                value: 0.5,
                received_us: self.belts_us,
            };
            let joints = [joint, Joint::default()];
            self.estimator.advance(
                self.odometry_um,
                self.belts_us,
                joints,
                &self.attitude,
                self.now_us,
            );
        }
    }

    /// Receives a fix, `minutes` of 1e-5 arc minute (18.5 mm) north of the place in Angers.
    fn fix(&mut self, number: u64, minutes: u64) -> bool {
        let line = format!(
            "GPGGA,{:06}.{:02},4728.{:05},N,00033.79200,W,1,08,1.1,40.0,M,48.0,M,,",
            120_000 + number / 5,
            number % 5 * 20,
            70_400 + minutes,
        );
        self.estimator.listen(&framed(&line), self.now_us)
    }

    /// A robot that knows its place.
    fn placed() -> Self {
        let mut robot = Self::new();
        robot.run(300, 0);
        for number in 0..10 {
            assert!(robot.fix(number, 0));
            robot.run(200, 0);
        }
        robot
    }

    fn state(&self) -> State {
        self.estimator.state(&self.attitude, self.now_us)
    }

    fn validities(&self) -> [Validity; 8] {
        self.state().map(|reading| reading.validity)
    }
}

const MEASURED: Validity = Validity::Measured;

#[test]
fn what_was_measured_within_its_timeout_counts_as_measured() {
    let robot = Robot::placed();
    let mut expected = [MEASURED; 8];
    expected[7] = Validity::Invalid;
    assert_eq!(robot.validities(), expected);
    let ages = robot.state().map(|reading| reading.age_ms);
    assert_eq!(ages[..3], [200; 3]);
    assert!(ages[3] < 10 && ages[4..] == [0; 4], "{ages:?}");
    assert_eq!(robot.state()[6].value, 0.5);
}

/// The belts and the attitude carry the position on; the gyroscope carries the heading on.
#[test]
fn a_position_without_fixes_is_reckoned_along_the_heading() {
    let mut robot = Robot::placed();
    robot.compass = false;
    robot.run(2_000, 500);
    let state = robot.state();
    assert_eq!(robot.validities()[..4], [Validity::Reckoned; 4]);
    assert!((state[0].value - 1.0).abs() < 1e-3, "{:?}", state[0]);
    assert!(state[1].value.abs() < 0.02, "{:?}", state[1]);
    assert_eq!(state[0].age_ms, 2_200);
    assert!(state[3].age_ms.abs_diff(2_000) <= 10, "{:?}", state[3]);
}

#[test]
fn a_position_is_not_reckoned_with_belts_or_attitude_of_60_ms_ago() {
    for (belts, gyroscope) in [(false, true), (true, false)] {
        let mut robot = Robot::placed();
        (robot.belts, robot.gyroscope) = (belts, gyroscope);
        robot.run(50, 0);
        let last = if gyroscope { 6 } else { 4 };
        assert_eq!(robot.validities()[last], MEASURED);
        robot.run(2_000, 500);
        assert_eq!(robot.validities()[..3], [Validity::Stale; 3]);
        assert_eq!(robot.validities()[last], Validity::Stale);
        // Readings of up to 60 ms ago still count for a gyroscope.
        assert!(robot.state()[0].value.abs() < 0.05);
    }
}

/// Without a heading nobody knows where the belts go to.
#[test]
fn a_position_is_not_reckoned_before_the_first_heading() {
    let mut robot = Robot::new();
    robot.compass = false;
    for number in 0..10 {
        robot.fix(number, 0);
        robot.run(200, 0);
    }
    robot.run(1_500, 500);
    assert_eq!(robot.validities()[..3], [Validity::Stale; 3]);
    assert!(robot.state()[0].value.abs() < 1e-3);
    assert_eq!(robot.validities()[3], Validity::Invalid);
}

#[test]
fn a_heading_counts_as_measured_while_the_compass_agrees_with_it_within_ten_degrees() {
    let mut robot = Robot::placed();
    robot.north = 0.15;
    robot.run(100, 0);
    assert!(robot.state()[3].age_ms < 10);
    let mut robot = Robot::placed();
    robot.north = 0.5;
    robot.run(600, 0);
    let state = robot.state();
    assert_eq!(state[3].validity, Validity::Reckoned);
    // It turns by 0.25 rad/s toward the compass, which shows -0.5 rad.
    let heading = robot.attitude.heading().radians();
    assert!((heading.abs() - 0.13).abs() < 0.02, "{heading}");
}

#[test]
fn a_heading_is_measured_in_whichever_direction_the_robot_begins() {
    for north in [1.0, -2.5, 3.0] {
        let mut robot = Robot::new();
        robot.north = north;
        robot.run(300, 0);
        let heading = robot.state()[3];
        assert_eq!(heading.validity, MEASURED);
        assert!(
            (heading.value.abs() - f32::abs(north)).abs() < 0.01,
            "{heading:?}"
        );
    }
}

/// A compass that comes back after a pause counts for 0.2 s, not for the pause.
#[test]
fn a_compass_after_a_pause_turns_the_heading_no_farther_than_after_a_fifth_of_a_second() {
    for (pause, turned) in [(100, 0.025), (150, 0.0375), (1_000, 0.05)] {
        let mut robot = Robot::placed();
        robot.compass = false;
        robot.run(pause - 10, 0);
        (robot.compass, robot.north) = (true, 1.5);
        robot.run(10, 0);
        let heading = robot.attitude.heading().radians().abs();
        assert!((heading - turned).abs() < 2e-3, "{pause}: {heading}");
    }
}

/// Bit by bit the same readings are those of a defective magnetometer.
#[test]
fn a_reading_that_repeats_is_no_new_heading() {
    let mut robot = Robot::placed();
    for _ in 0..600 {
        robot.now_us += 1_000;
        let sensors = BodySensors {
            magnetic_field: [20.0, 0.0, -40.0],
            ..BodySensors::default()
        };
        robot.attitude.update(&sensors, 1e-3);
        robot
            .estimator
            .sense(&sensors, &mut robot.attitude, robot.now_us);
    }
    assert_eq!(robot.validities()[3], Validity::Reckoned);
}

#[test]
fn a_speed_over_ground_is_signed_by_course_and_heading_and_counts_once() {
    let mut robot = Robot::placed();
    // 2 knots are 1.0289 m/s.
    for (course, share) in [(0.0, 1.0), (180.0, -1.0), (90.0, 0.0), (60.0, 0.5)] {
        for heading in [0.0, 40.0_f32] {
            let mut attitude = Attitude::default();
            attitude.update(&BodySensors::default(), 1e-3);
            attitude.correct_heading(Angle::from_degrees(heading), 1e-3);
            let course: f32 = (course - heading + 360.0) % 360.0;
            let line = format!("GPRMC,120000,A,4728.704,N,00033.792,W,2.0,{course:.1},010626,,");
            robot.estimator.listen(&framed(&line), robot.now_us);
            let speed = robot.estimator.take_speed(&attitude).expect("a speed");
            assert!((speed - 1.0289 * share).abs() < 2e-3, "{course}: {speed}");
            assert_eq!(robot.estimator.take_speed(&attitude), None);
        }
    }
}

/// The receiver extrapolates in mode E; mode A is a measurement.
#[test]
fn an_extrapolated_place_is_no_fix_and_its_speed_does_not_count() {
    let mut robot = Robot::placed();
    for (mode, measured) in [("E", false), ("A", true)] {
        let line = format!("GPRMC,120000,A,4728.704,N,00033.792,W,2.0,0.0,010626,,,{mode}");
        let fix = robot.estimator.listen(&framed(&line), robot.now_us);
        let speed = robot.estimator.take_speed(&robot.attitude);
        assert_eq!((fix, speed.is_some()), (measured, measured), "{mode}");
    }
}

#[test]
fn a_sentence_without_a_fix_is_none() {
    let mut robot = Robot::new();
    let none = framed("GPGGA,120000.00,,,,,0,00,99.99,,,,,,");
    assert!(!robot.estimator.listen(&none, 0));
    assert!(robot.fix(1, 0));
    assert_eq!(robot.estimator.sentences().taken, 2);
}

/// A fix waits for the next tick with time for it, or for the next fix.
#[test]
fn every_fix_is_counted_even_if_two_come_in_one_tick() {
    let mut robot = Robot::placed();
    robot.fix(10, 0);
    robot.fix(11, 0);
    robot.run(1, 0);
    assert_eq!(robot.estimator.position().counts(), [10, 2]);
}
