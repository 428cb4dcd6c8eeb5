//! Tests of runs in which a sensor chip of the guard's board has a fault.

use super::{programs, scenario, stamp};
use tautrack::link::ChipFault;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::scenario::{Expect, Fault, FaultKind, Scenario, SensorChip};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::{Options, Sink, Unwritten, record};

/// Time at which a fault begins while the robot drives, and at which it ends, s.
const BEGIN: f64 = 6.0;
const END: f64 = 7.5;

/// Samples of a run and the log of its nodes, with times in s.
#[derive(Default)]
struct Record {
    samples: Vec<Sample>,
    log: Vec<(f64, String)>,
}

impl Sink for Record {
    fn sample(&mut self, sample: Sample) -> Result<(), Unwritten> {
        self.samples.push(sample);
        Ok(())
    }

    fn log(&mut self, line: &str) -> Result<(), Unwritten> {
        let (time, text) = line.split_once(' ').expect("time and text");
        self.log
            .push((time.parse().expect("a time"), text.to_owned()));
        Ok(())
    }
}

impl Record {
    /// Asserts that the guard logs `text` between `from` and `within_ms` later.
    fn says(&self, text: &str, from: f64, within_ms: f64) {
        let found = self
            .log
            .iter()
            .find(|(time, line)| *time >= from && line.contains(text));
        let Some((time, _)) = found else {
            panic!("no {text:?} after {from} s in {:#?}", self.log)
        };
        let after = (time - from) * 1e3;
        assert!(after <= within_ms, "{text:?} after {after} ms");
    }

    /// Largest forward speed that the guard passes from `from` to `to`, m/s.
    fn passed(&self, from: f64, to: f64) -> f64 {
        let there = self
            .samples
            .iter()
            .filter(|sample| (from..to).contains(&sample.time_s));
        there.fold(0.0, |speed, sample| speed.max(sample.received.passed_speed))
    }
}

/// A shipped scenario in which a chip has a fault.
fn faulty(name: &str, chip: SensorChip, fault: ChipFault, at_s: f64, until_s: f64) -> Scenario {
    scenario(name, |description| {
        description.duration_s = until_s + 1.0;
        description.expect = Expect::default();
        description.faults = vec![Fault {
            what: FaultKind::Sensor { chip, fault },
            at_s,
            until_s: Some(until_s),
            notice_within_ms: None,
        }];
    })
}

fn run(chip: SensorChip, fault: ChipFault) -> Record {
    run_of("flat", chip, fault, BEGIN, END)
}

fn run_of(name: &str, chip: SensorChip, fault: ChipFault, begin: f64, end: f64) -> Record {
    let mut found = Record::default();
    let scenario = faulty(name, chip, fault, begin, end);
    let options = Options::default();
    let ending = record(&scenario, programs(Board::Host), options, &mut found);
    let ending = ending.unwrap_or_else(|error| panic!("{error}"));
    assert!(ending.error.is_none());
    found.says("inertial unit: running", 0.0, 100.0);
    found.says("magnetometer: running", 0.0, 100.0);
    found.says("inclinometer: running", 0.0, 100.0);
    assert!(found.passed(begin - 0.5, begin) > 0.08, "the robot drives");
    found
}

#[test]
fn an_inertial_unit_that_falls_silent_is_named_within_40_ms_and_stops_the_robot() {
    let Some(_stamp) =
        stamp("an_inertial_unit_that_falls_silent_is_named_within_40_ms_and_stops_the_robot")
    else {
        return;
    };
    for (fault, condition) in [
        (ChipFault::BusStuck, "inertial unit: bus stuck"),
        (ChipFault::NoAcknowledge, "inertial unit: no acknowledge"),
    ] {
        let found = run(SensorChip::InertialUnit, fault);
        found.says(condition, BEGIN, 40.0);
        found.says("gyroscope: sensors silent", BEGIN, 40.0);
        found.says("accelerometer: sensors silent", BEGIN, 40.0);
        assert_eq!(found.passed(BEGIN + 0.2, END), 0.0, "{fault:?}");
        found.says("tripped: cause", BEGIN, 250.0);
        // The chip is started again when the fault ends.
        found.says("inertial unit: running", END, 100.0);
        found.says("gyroscope: believed", END, 150.0);
    }
}

#[test]
fn a_stuck_bus_silences_both_chips_and_is_freed_when_the_fault_ends() {
    let Some(_stamp) = stamp("a_stuck_bus_silences_both_chips_and_is_freed_when_the_fault_ends")
    else {
        return;
    };
    let found = run(SensorChip::Magnetometer, ChipFault::BusStuck);
    found.says("inertial unit: bus stuck", BEGIN, 40.0);
    found.says("magnetometer: bus stuck", BEGIN, 600.0);
    found.says("inertial unit: running", END, 100.0);
    found.says("magnetometer: running", END, 200.0);
}

#[test]
fn frozen_outputs_of_the_inertial_unit_are_named_within_250_ms_and_stop_the_robot() {
    let Some(_stamp) =
        stamp("frozen_outputs_of_the_inertial_unit_are_named_within_250_ms_and_stop_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::InertialUnit, ChipFault::Frozen);
    found.says("gyroscope: sensor stuck", BEGIN, 250.0);
    found.says("accelerometer: sensor stuck", BEGIN, 250.0);
    assert_eq!(found.passed(BEGIN + 0.6, END), 0.0);
}

#[test]
fn an_inertial_unit_at_half_its_rate_is_named_within_600_ms_and_slows_the_robot() {
    let Some(_stamp) =
        stamp("an_inertial_unit_at_half_its_rate_is_named_within_600_ms_and_slows_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::InertialUnit, ChipFault::HalfRate);
    found.says("gyroscope: sensor too slow", BEGIN, 600.0);
    found.says("accelerometer: sensor too slow", BEGIN, 600.0);
    let crawl = found.passed(BEGIN + 1.2, END);
    assert!(crawl > 0.0 && crawl <= 0.051, "{crawl} m/s");
}

#[test]
fn noise_of_the_inertial_unit_is_named_within_300_ms_and_stops_the_robot() {
    let Some(_stamp) =
        stamp("noise_of_the_inertial_unit_is_named_within_300_ms_and_stops_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::InertialUnit, ChipFault::Noise);
    found.says("gyroscope: sensor too noisy", BEGIN, 300.0);
    found.says("accelerometer: sensor too noisy", BEGIN, 300.0);
    assert_eq!(found.passed(BEGIN + 0.6, END), 0.0);
    found.says("tripped: cause", BEGIN, 800.0);
    found.says("gyroscope: believed", END, 1_000.0);
}

#[test]
fn noise_of_the_magnetometer_is_named_within_1500_ms_and_the_robot_drives_on() {
    let Some(_stamp) =
        stamp("noise_of_the_magnetometer_is_named_within_1500_ms_and_the_robot_drives_on")
    else {
        return;
    };
    let found = run(SensorChip::Magnetometer, ChipFault::Noise);
    found.says("magnetometer: sensor too noisy", BEGIN, 1_500.0);
    assert!(found.passed(BEGIN + 0.6, END) > 0.08);
}

#[test]
fn a_frozen_magnetometer_is_named_within_900_ms_of_a_turn_and_the_robot_drives_on() {
    let Some(_stamp) =
        stamp("a_frozen_magnetometer_is_named_within_900_ms_of_a_turn_and_the_robot_drives_on")
    else {
        return;
    };
    // The robot turns by 20 degrees/s, so it has turned by 10 degrees after 500 ms.
    let (chip, begin, end) = (SensorChip::Magnetometer, 8.0, 9.5);
    let found = run_of("legitimate/turning", chip, ChipFault::Frozen, begin, end);
    found.says("magnetometer: sensor stuck", begin, 900.0);
    assert!(found.passed(begin + 0.9, end) > 0.08);
    found.says("magnetometer: believed", end, 400.0);
    // While it drives straight on, nothing shows the fault, and nothing needs the magnetometer.
    let straight = run(chip, ChipFault::Frozen);
    assert!(!straight.log.iter().any(|(_, line)| line.contains("stuck")));
    assert!(straight.passed(BEGIN + 0.9, END) > 0.08);
}

#[test]
fn a_magnetometer_that_falls_silent_is_named_within_600_ms_and_the_robot_drives_on() {
    let Some(_stamp) =
        stamp("a_magnetometer_that_falls_silent_is_named_within_600_ms_and_the_robot_drives_on")
    else {
        return;
    };
    let found = run(SensorChip::Magnetometer, ChipFault::NoAcknowledge);
    found.says("magnetometer: no acknowledge", BEGIN, 600.0);
    found.says("magnetometer: sensors silent", BEGIN, 600.0);
    assert!(found.passed(BEGIN + 0.6, END) > 0.08);
    found.says("magnetometer: running", END, 200.0);
}

#[test]
fn an_inclinometer_that_falls_silent_is_named_within_100_ms_and_stops_the_robot() {
    let Some(_stamp) =
        stamp("an_inclinometer_that_falls_silent_is_named_within_100_ms_and_stops_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::Inclinometer, ChipFault::NoAcknowledge);
    found.says("inclinometer: no acknowledge", BEGIN, 100.0);
    found.says("inclinometer: sensors silent", BEGIN, 100.0);
    assert_eq!(found.passed(BEGIN + 0.2, END), 0.0);
    found.says("tripped: cause", BEGIN, 250.0);
    found.says("inclinometer: running", END, 150.0);
    found.says("inclinometer: believed", END, 200.0);
}

#[test]
fn a_noisy_inclinometer_is_named_within_600_ms_and_stops_the_robot() {
    let Some(_stamp) = stamp("a_noisy_inclinometer_is_named_within_600_ms_and_stops_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::Inclinometer, ChipFault::Noise);
    found.says("inclinometer: sensor too noisy", BEGIN, 600.0);
    assert_eq!(found.passed(BEGIN + 1.0, END), 0.0);
}

#[test]
fn an_inclinometer_at_half_its_rate_is_named_within_600_ms_and_slows_the_robot() {
    let Some(_stamp) =
        stamp("an_inclinometer_at_half_its_rate_is_named_within_600_ms_and_slows_the_robot")
    else {
        return;
    };
    let found = run(SensorChip::Inclinometer, ChipFault::HalfRate);
    found.says("inclinometer: sensor too slow", BEGIN, 600.0);
    let crawl = found.passed(BEGIN + 1.2, END);
    assert!(crawl > 0.0 && crawl <= 0.051, "{crawl} m/s");
}

#[test]
fn a_frozen_inclinometer_is_named_within_600_ms_of_a_rotation_and_stops_the_robot() {
    let Some(_stamp) =
        stamp("a_frozen_inclinometer_is_named_within_600_ms_of_a_rotation_and_stops_the_robot")
    else {
        return;
    };
    let (begin, end) = (8.0, 20.0);
    let chip = SensorChip::Inclinometer;
    let found = run_of("staircase", chip, ChipFault::Frozen, begin, end);
    let pitch = |sample: &Sample| sample.truth.pitch.to_degrees();
    let mut later = found.samples.iter().filter(|sample| sample.time_s >= begin);
    let before = later.next().map_or(f64::NAN, pitch);
    let tilted = later.find(|sample| (pitch(sample) - before).abs() > 3.0);
    let time = tilted.expect("the robot climbs").time_s;
    found.says("inclinometer: sensor stuck", time, 600.0);
    assert_eq!(found.passed(time + 1.0, end), 0.0);
}

#[test]
fn a_chip_with_another_identity_is_named_within_100_ms_and_the_robot_does_not_drive() {
    let Some(_stamp) =
        stamp("a_chip_with_another_identity_is_named_within_100_ms_and_the_robot_does_not_drive")
    else {
        return;
    };
    for (chip, identity) in [
        (SensorChip::InertialUnit, "inertial unit: identity 0x6c"),
        (SensorChip::Inclinometer, "inclinometer: identity 0x44"),
    ] {
        let mut found = Record::default();
        let scenario = faulty("flat", chip, ChipFault::WrongIdentity, 0.0, 8.0);
        let options = Options::default();
        let ending = record(&scenario, programs(Board::Host), options, &mut found);
        assert!(ending.is_ok_and(|ending| ending.error.is_none()));
        found.says(identity, 0.0, 100.0);
        found.says(": wrong identity", 0.0, 100.0);
        // The operator commands from the first second on; the fault ends after 8 s.
        assert_eq!(found.passed(0.0, 8.0), 0.0);
    }
}
