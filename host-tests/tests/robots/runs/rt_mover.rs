//! Tests of RT-Mover's nodes on its plant: it puts one wheel after the other onto the step,
//! standing on the other three, with a level seat.

use super::{ends_in_the_same_bits, outcome, scenario, tried, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::robots::Robot;
use tautrack_host_tests::simulator::record::Sample;

const WHEELS: [&str; 4] = ["front_left", "front_right", "rear_left", "rear_right"];
/// Minimum time off the ground that counts as a flight, s; shorter ones are vibration.
const HOP: f64 = 0.5;
/// Time after a wheel comes down that counts as its touch-down, s: the gait detects the ground, and
/// the load spreads.
const TOUCH_DOWN: f64 = 1.0;

/// Motion of a wheel in the air.
#[derive(Debug)]
struct Flight {
    wheel: usize,
    from_s: f64,
    to_s: f64,
    /// Maximum distance along the direction of travel from the point of lift-off while it rises,
    /// and from the point of touch-down while it falls, m.
    column: [f64; 2],
    /// Minimum support margin on the other three wheels, m.
    margin: f64,
    /// Number of samples with less than three wheels on the ground.
    fewer: usize,
}

fn channel(sample: &Sample, wheel: usize, what: &str) -> f64 {
    sample.truth.channels[format!("{}_{what}", WHEELS[wheel]).as_str()]
}

/// Returns all flights over a step of `height` (m), in order of time.
fn flights(samples: &[Sample], height: f64) -> Vec<Flight> {
    let mut flights = Vec::new();
    for wheel in 0..4 {
        let flying = |sample: &Sample| channel(sample, wheel, "load_n") < 0.1;
        for air in samples.chunk_by(|a, b| flying(a) == flying(b)) {
            let [from_s, to_s] = [&air[0], &air[air.len() - 1]].map(|sample| sample.time_s);
            if !flying(&air[0]) || to_s - from_s < HOP {
                continue;
            }
            let x = |sample: &Sample| channel(sample, wheel, "x_m");
            let over = |sample: &Sample| channel(sample, wheel, "height_m") > height + 0.02;
            let up = air.iter().position(over).unwrap_or(air.len());
            let down = air
                .iter()
                .rposition(over)
                .map_or(air.len(), |last| last + 1);
            let spread = |part: &[Sample], from: f64| {
                part.iter()
                    .map(|sample| (x(sample) - from).abs())
                    .fold(0.0, f64::max)
            };
            let three = |sample: &&Sample| sample.truth.contacts.len() == 3;
            flights.push(Flight {
                wheel,
                from_s,
                to_s,
                column: [
                    spread(&air[..up], x(&air[0])),
                    spread(&air[down..], x(&air[air.len() - 1])),
                ],
                margin: air
                    .iter()
                    .filter(three)
                    .map(|sample| sample.truth.channels["support_margin_m"])
                    .fold(f64::INFINITY, f64::min),
                fewer: air
                    .iter()
                    .filter(|sample| sample.truth.contacts.len() < 3)
                    .count(),
            });
        }
    }
    flights.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    flights
}

/// Maximum tilt of the seat outside and during touch-downs, degrees, after the guard has been
/// armed. Before that, the seat sags until its drive holds it, and moves to find its home switch.
fn tilts(samples: &[Sample], flights: &[Flight]) -> [f64; 2] {
    let armed = |sample: &Sample| sample.received.guard_state == "armed";
    let start = samples.iter().position(armed).expect("the guard is armed");
    let mut tilts = [0.0; 2];
    for sample in &samples[start..] {
        let touching = flights
            .iter()
            .any(|flight| (flight.to_s - 0.1..flight.to_s + TOUCH_DOWN).contains(&sample.time_s));
        let tilt = sample.truth.pitch.abs().max(sample.truth.roll.abs());
        let slot: &mut f64 = &mut tilts[usize::from(touching)];
        *slot = slot.max(tilt.to_degrees());
    }
    tilts
}

/// Minimum time that a lifted wheel is in the air, s; a wheel that rides up the face of a step
/// comes down sooner.
const LIFTED: f64 = 2.0;

/// Asserts the goals of the gait in a run with nodes, bus and sensors.
fn steps_up(name: &str, height: f64, hops: usize) {
    let (summary, samples) = outcome(&scenario(&format!("rt-mover/{name}"), |_| {}), Board::Host);
    let flights = flights(&samples, height);
    for flight in &flights {
        println!("{name} {flight:.4?}");
    }
    let [calm, touching] = tilts(&samples, &flights);
    println!("{name} seat within {calm:.2} degrees, {touching:.2} in touch-downs");
    let heights = [0, 1, 2, 3].map(|wheel| channel(samples.last().unwrap(), wheel, "height_m"));
    println!("{name} heights {heights:.4?}");
    assert!(summary.expectation_met, "{summary}");
    for found in heights {
        assert!((found - height).abs() < 0.005, "{heights:?}");
    }
    let (flights, others): (Vec<_>, Vec<_>) = flights
        .into_iter()
        .partition(|flight| flight.to_s - flight.from_s > LIFTED);
    assert!(others.len() <= hops, "{others:?}");
    let order: Vec<_> = flights.iter().map(|flight| flight.wheel).collect();
    assert_eq!(order, [0, 1, 2, 3], "one wheel after the other");
    for flight in &flights {
        assert!(flight.margin > 0.0, "{flight:?}");
        assert!(flight.column.iter().all(|off| *off <= 0.005), "{flight:?}");
        assert!(flight.fewer < 10, "{flight:?}");
    }
    assert!(calm < 2.0, "{calm}");
}

#[test]
fn the_nodes_step_up_ten_to_twenty_centimetres() {
    unless_unchanged("rt-mover-steps", Kind::RtMover, || {
        // A step twice as high as the wheels' radius has only a vertical face for them: while it
        // seeks the step, a rear wheel rides up a little.
        // Last, hall sensors show the rotors of the wheels.
        for &(name, height, hops) in tried(&[
            ("step-20", 0.20, 1),
            ("step-15", 0.15, 0),
            ("step-10", 0.10, 0),
            ("step-10-halls", 0.10, 0),
        ]) {
            steps_up(name, height, hops);
        }
    });
}

#[test]
fn emulated_nodes_and_those_in_this_process_end_in_the_same_bits() {
    unless_unchanged("rt-mover-bits", Kind::RtMover, || {
        ends_in_the_same_bits("rt-mover/step-10");
        ends_in_the_same_bits("rt-mover/step-10-halls");
    });
}

/// A levelled seat never topples. In these hazards the robot falls onto the wheel that it should
/// lift, and the diagonally opposite wheel rises.
#[test]
fn the_guard_keeps_on_its_wheels_a_robot_that_falls_over_a_diagonal_without_it() {
    unless_unchanged("rt-mover-hazards", Kind::RtMover, || {
        const REAR_LEFT: usize = 2;
        const REAR_RIGHT: usize = 3;
        for &(hazard, across) in tried(&[
            ("load-aside", REAR_RIGHT),
            ("heavy-load-left", REAR_RIGHT),
            ("far-load-left", REAR_RIGHT),
            ("load-right", REAR_LEFT),
            ("far-load-right", REAR_LEFT),
        ]) {
            let [with, without] = [true, false].map(|guard| {
                let changed = scenario(&format!("rt-mover/hazards/{hazard}"), |description| {
                    description.guard = guard;
                });
                let (summary, samples) = outcome(&changed, Board::Host);
                let highest = samples
                    .iter()
                    .map(|sample| channel(sample, across, "height_m"))
                    .fold(0.0, f64::max);
                (summary.guard.interventions, highest)
            });
            println!("{hazard}: {with:?} with, {without:?} without guard");
            assert!(without.1 > 0.2, "{hazard}: {without:?} is no hazard");
            assert!(with.0 > 0 && with.1 < 0.01, "{hazard}: {with:?}");
        }
    });
}

/// 14 kg on a mast make the seat sway, which repeatedly relieves the lifted arm for moments. The
/// wheel counts as on the step only when the step carries it.
#[test]
#[ignore = "runs for half a minute; docs/testing.md has the complete campaigns"]
fn an_arm_relieved_by_a_swaying_seat_does_not_pass_for_a_wheel_on_the_ground() {
    unless_unchanged("rt-mover-sway", Kind::RtMover, || {
        let swaying = scenario("rt-mover/hazards/load-aside", |description| {
            let Robot::RtMover(robot) = &mut description.robot else {
                panic!("another robot");
            };
            robot.payload.as_mut().expect("a load").place_m = [0.05, -0.35, 0.7];
            description.duration_s = 45.0;
        });
        let (_, samples) = outcome(&swaying, Board::Host);
        let lifted = samples
            .iter()
            .position(|sample| channel(sample, 0, "height_m") > 0.2);
        assert!(lifted.is_some(), "front left was never lifted");
        let end = samples.last().expect("samples");
        let [height, load] = ["height_m", "load_n"].map(|what| channel(end, 0, what));
        assert!(
            (height - 0.2).abs() < 0.005 && load > 5.0,
            "{height} m, {load} N"
        );
    });
}
