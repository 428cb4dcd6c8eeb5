//! Tests what trips the guard, what clears the trip, and how trips are counted.

use tautrack::sensing::trust::{Reason, Trust};
use tautrack::sensors::BodySensors;
use tautrack::settings::Settings;
use tautrack::stability::allowed::Command;
use tautrack::stability::bands::Band;
use tautrack::stability::parameters::Parameters;
use tautrack::stability::support::{EDGES, Edge};
use tautrack::stability::trip::{Cause, Inputs, Mode, Requests, Snapshot, Trip};
use tautrack::stability::verdict::Verdict;

const RESET: Requests = Requests {
    reset: true,
    override_trip: false,
    back_off: false,
    emergency_stop: false,
};
const NOTHING: Requests = Requests {
    reset: false,
    ..RESET
};
const EMERGENCY_STOP: Requests = Requests {
    emergency_stop: true,
    ..NOTHING
};
const BACK_OFF: Requests = Requests {
    back_off: true,
    ..NOTHING
};

/// An armed guard whose rear margin is in this band, while the operator commands this speed.
fn inputs(band: Band, forward: f32) -> Inputs {
    Inputs {
        armed: true,
        band,
        trust: Trust::Full,
        odometry_um: 0,
        snapshot: Snapshot {
            cause: Cause::EmergencyStop,
            time_us: 0,
            margins: [0.0, 0.3, 0.2, 0.2],
            edge: Edge::Back,
            command: Command::new(forward, 0.0),
            speed: forward,
            sensors: BodySensors::default(),
        },
    }
}

fn parameters() -> Parameters {
    Parameters {
        back_off: true,
        ..Parameters::new(&Settings::default())
    }
}

fn cause(trip: &Trip) -> Option<Cause> {
    trip.snapshot()
        .filter(|_| trip.latched())
        .map(|snapshot| snapshot.cause)
}

#[test]
fn a_trip_that_lasts_counts_once_and_the_next_one_again() {
    let (mut trip, parameters) = (Trip::default(), parameters());
    for _ in 0..50 {
        trip.update(&inputs(Band::Stop, -0.1), NOTHING, &parameters);
    }
    assert_eq!((trip.latched(), trip.count()), (true, 1));
    for _ in 0..50 {
        trip.update(&inputs(Band::Stop, -0.1), EMERGENCY_STOP, &parameters);
    }
    assert_eq!(
        (cause(&trip), trip.count()),
        (Some(Cause::EmergencyStop), 2)
    );
    trip.update(&inputs(Band::Free, 0.0), RESET, &parameters);
    assert_eq!((trip.latched(), trip.count()), (false, 2));
    trip.update(&inputs(Band::Stop, -0.1), NOTHING, &parameters);
    assert_eq!(
        (cause(&trip), trip.count()),
        (Some(Cause::Margin(Edge::Back)), 3)
    );
}

/// A reset clears the emergency stop alone while the margin is still too small.
#[test]
fn a_trip_that_an_emergency_stop_covered_comes_back_unless_its_cause_has_gone() {
    for (band, left) in [
        (Band::Limit, Some(Cause::Margin(Edge::Back))),
        (Band::Free, None),
    ] {
        let (mut trip, parameters) = (Trip::default(), parameters());
        trip.update(&inputs(Band::Stop, -0.1), NOTHING, &parameters);
        trip.update(&inputs(Band::Stop, -0.1), EMERGENCY_STOP, &parameters);
        trip.update(&inputs(band, 0.0), RESET, &parameters);
        assert_eq!(cause(&trip), left, "{band:?}");
    }
    let (mut trip, parameters) = (Trip::default(), parameters());
    trip.update(&inputs(Band::Limit, 0.0), EMERGENCY_STOP, &parameters);
    trip.update(&inputs(Band::Limit, 0.0), RESET, &parameters);
    assert_eq!(cause(&trip), None, "nothing was covered");
}

#[test]
fn backing_off_needs_a_command_that_led_to_the_trip() {
    for (forward, direction) in [(-0.1, Some(1.0)), (0.1, Some(-1.0)), (0.0, None)] {
        let (mut trip, parameters) = (Trip::default(), parameters());
        trip.update(&inputs(Band::Stop, forward), NOTHING, &parameters);
        let mode = trip.update(&inputs(Band::Stop, 0.0), BACK_OFF, &parameters);
        assert_eq!(mode, direction.map_or(Mode::Tripped, Mode::BackingOff));
    }
}

#[test]
fn every_cause_has_its_code() {
    for (number, edge) in (0..).zip(EDGES) {
        assert_eq!(Cause::Margin(edge).code(), 0x10 + number);
    }
    for number in 1..=8 {
        let reason = Reason::from_byte(number).expect("a reason");
        assert_eq!(Cause::Sensors(reason).code(), 0x20 + number);
    }
    assert_eq!(Cause::EmergencyStop.code(), 0x30);
}

/// Every pair: the worse one counts, and the first of two that are equally bad.
#[test]
fn the_worse_trust_counts() {
    let reasons = (1..=11).filter_map(Reason::from_byte);
    let all: Vec<(i32, Trust)> = reasons
        .flat_map(|reason| [(1, Trust::Degraded(reason)), (2, Trust::None(reason))])
        .chain([(0, Trust::Full)])
        .collect();
    for (rank, trust) in &all {
        for (other_rank, other) in &all {
            let worse = if other_rank > rank { other } else { trust };
            assert_eq!(trust.or(*other), *worse);
        }
    }
}

#[test]
fn every_reason_has_its_words() {
    let words: Vec<&str> = (1..=11)
        .filter_map(Reason::from_byte)
        .map(Reason::words)
        .collect();
    let expected = [
        "sensors silent",
        "sensors not finite",
        "sensors out of range",
        "sensor stuck",
        "force is not gravity",
        "sensors disagree",
        "sensor too slow",
        "sensor too noisy",
        "sensor reads zero",
        "sensor upside down",
        "free fall",
    ];
    assert_eq!(words, expected);
}

/// 0x10 to 0xA0 tell the verdict, the last digit the edge or the reason.
#[test]
fn every_verdict_has_its_code() {
    for (number, edge) in (0..).zip(EDGES) {
        let codes = [
            Verdict::Scaled(edge),
            Verdict::Refused(edge),
            Verdict::PostureRefused(edge),
            Verdict::Tripped(edge),
            Verdict::Overridden(edge),
            Verdict::BackingOff(edge),
            Verdict::PostureScaled(edge),
        ]
        .map(Verdict::code);
        let expected = [0x10, 0x20, 0x30, 0x60, 0x70, 0x80, 0xa0].map(|code| code + number);
        assert_eq!(codes, expected);
    }
}
