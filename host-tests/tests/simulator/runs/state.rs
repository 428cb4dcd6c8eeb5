//! Tests the guard's position and heading, as published on the bus, against the plant's ground
//! truth.

use super::{climb, stamp};
use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::nmea::Place;
use tautrack::estimate::position::{Fix, Position};
use tautrack::sensors::BodySensors;
use tautrack::units::Angle;
use tautrack_host_tests::programs::Board;

#[test]
fn position_and_heading_on_the_bus_follow_the_truth_up_the_staircase() {
    let Some(_stamp) = stamp("position_and_heading_on_the_bus_follow_the_truth_up_the_staircase")
    else {
        return;
    };
    let (summary, samples) = climb(Board::Host);
    let fixed: Vec<_> = samples
        .iter()
        .filter(|sample| sample.received.position.is_some())
        .collect();
    let first = fixed.first().expect("a position on the bus");
    assert!(first.time_s < 3.0, "{} s", first.time_s);
    let (mut worst, mut worst_heading) = (0.0_f64, 0.0_f64);
    for sample in &fixed {
        let received = &sample.received;
        assert_eq!(received.validity, [3; 4], "at {} s", sample.time_s);
        assert!(received.fix_age < 0.5, "{} s", received.fix_age);
        let position = received.position.expect("filtered");
        let error: f64 = (0..2)
            .map(|axis| position[axis] - (sample.truth.axle_1[axis] - first.truth.axle_1[axis]))
            .map(|error| error * error)
            .sum();
        worst = worst.max(error.sqrt());
        worst_heading = worst_heading.max((received.heading - sample.truth.yaw).abs());
    }
    let worst_heading = worst_heading.to_degrees();
    println!("position within {worst:.2} m, heading within {worst_heading:.2} degrees");
    // The receiver's own error varies by 1.2 m (standard deviation) along each axis; more than two
    // of these are rare.
    assert!(worst < 3.0, "{worst} m\n{summary}");
    assert!(worst_heading < 3.0, "{worst_heading} degrees\n{summary}");
}

#[test]
fn dead_reckoning_up_the_staircase_keeps_its_error_per_metre() {
    let Some(_stamp) = stamp("dead_reckoning_up_the_staircase_keeps_its_error_per_metre") else {
        return;
    };
    let (_, samples) = climb(Board::Host);
    let mut position = Position::new(0.45);
    for number in 1..=3 {
        let fix = Fix {
            time_ms: number * 200,
            place: Place::default(),
            altitude_mm: Some(0),
        };
        position.fix(&fix, u64::from(number) * 200_000);
    }
    let mut before = &samples[0];
    for sample in &samples[1..] {
        let mut tilt = Attitude::default();
        tilt.update(
            &BodySensors {
                inclination: [sample.received.pitch as f32, sample.received.roll as f32],
                ..BodySensors::default()
            },
            1e-3,
        );
        let way = ((sample.received.odometry - before.received.odometry) * 1e6).round() as i32;
        let heading = Angle::from_radians(sample.received.heading as f32);
        position.advance(way, heading, &tilt.level_axes());
        before = sample;
    }
    let [north, east, up] = position.metres().map(f64::from);
    let (start, end) = (samples[0].truth.axle_1, before.truth.axle_1);
    let level = (north - (end[0] - start[0])).hypot(-east - (end[1] - start[1]));
    let height = (up - (end[2] - start[2])).abs();
    let way = before.received.odometry;
    let (level, height) = (level / way, height / way);
    println!(
        "dead reckoning up the staircase, {way:.2} m: {level:.3} m per m on the ground, {height:.3} in height"
    );
    assert!(level < 0.1 && height < 0.1, "{level} and {height} m per m");
}
