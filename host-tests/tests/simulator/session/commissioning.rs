//! Test of the commissioning of a guard's sensors, as a user does it: a hand moves the robot, the
//! example program runs the steps and saves the values, and the nodes start again.

use crate::session::{demo, python};
use std::path::Path;
use std::time::Duration;
use std::{fs, thread};
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::{
    Description, Event, Motion, Operator, OperatorRequest, Scenario, When,
};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::{Options, run};
use tautrack_host_tests::simulator::slcan::SlcanPort;

/// Limit of the time until the client joins. The first one installs its packages.
const LONGEST_INSTALLATION: Duration = Duration::from_mins(10);
/// Virtual seconds per second. The client has about 4 s of delay before it misses a posture.
const SPEED: f64 = 2.5;
/// Time from one posture to the next, and duration of the motion, s.
const PERIOD: f64 = 7.0;
const MOTION: f64 = 2.0;
/// Pitch, roll and heading of the postures, degrees. The first one is at rest on the ground.
const POSTURES: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 100.0],
    [12.0, 0.0, 200.0],
    [-8.0, 10.0, 330.0],
    [0.0, -12.0, 420.0],
];

fn description() -> Description {
    let path = demo::scenario("commissioning");
    Scenario::load(Path::new(&path))
        .unwrap_or_else(|error| panic!("{error}"))
        .description()
}

fn samples(scenario: Description, programs: &Programs, options: Options) -> Vec<Sample> {
    let scenario = scenario.check().unwrap_or_else(|error| panic!("{error}"));
    let outcome = run(&scenario, programs, options);
    outcome.unwrap_or_else(|error| panic!("{error}")).samples
}

/// A client commissions the sensors of the guard, whose flash is in this folder. Returns what the
/// example program printed.
fn commission(programs: &Programs, flash: String) -> String {
    let port = SlcanPort::bind("127.0.0.1:0").expect("a free port");
    let address = port.address().expect("bound").to_string();
    let client = thread::spawn(move || {
        let program = "examples/python/commission.py";
        python::run(&[program, &address, "--hands-free", "--save"])
    });
    let options = Options {
        slcan: Some(port),
        slcan_wait: Some(LONGEST_INSTALLATION),
        speed: Some(SPEED),
        flash: Some(flash),
        ..Options::default()
    };
    samples(description(), programs, options);
    let output = client.join().expect("the client is done");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).expect("text")
}

/// The same robot, which an operator arms and disarms before a hand takes it to [`POSTURES`].
fn armed_and_moved(programs: &Programs, flash: Option<String>) -> Vec<Sample> {
    let motion = |(index, [pitch_deg, roll_deg, turn_deg]): (usize, [f64; 3])| Motion {
        at_s: PERIOD * index as f64,
        within_s: MOTION,
        lift_m: 0.4,
        pitch_deg,
        roll_deg,
        turn_deg,
    };
    let mut hand: Vec<Motion> = POSTURES.into_iter().enumerate().map(motion).collect();
    hand.remove(0);
    let duration_s = PERIOD * POSTURES.len() as f64;
    // Until the end the hand holds the last posture.
    hand.extend(hand.last().map(|last| Motion {
        at_s: duration_s,
        ..*last
    }));
    let disarm = Event {
        request: Some(OperatorRequest::Disarm),
        when: When {
            after_s: Some(0.5),
            ..When::default()
        },
        ..Event::default()
    };
    let operator = Operator {
        client: false,
        events: vec![disarm],
        ..Operator::client()
    };
    let scenario = Description {
        duration_s,
        operator,
        faults: Vec::new(),
        hand,
        ..description()
    };
    let options = Options {
        flash,
        ..Options::default()
    };
    samples(scenario, programs, options)
}

fn arms(samples: &[Sample]) -> bool {
    let mut states = samples.iter().map(|sample| &sample.received.guard_state);
    states.any(|state| state == "armed")
}

/// Largest errors of pitch or roll and of the heading that the guard publishes, in the last second
/// of each rest, degrees.
fn errors(samples: &[Sample]) -> [f64; 2] {
    let off = |found: f64, expected: f64| {
        let off = (found - expected).to_degrees() + 180.0;
        (off.rem_euclid(360.0) - 180.0).abs()
    };
    let mut worst = [0.0_f64; 2];
    for (posture, end) in POSTURES.iter().zip(1..) {
        let end = PERIOD * f64::from(end);
        let [pitch, roll, heading] = posture.map(f64::to_radians);
        for sample in samples {
            if !(end - 1.0..end).contains(&sample.time_s) {
                continue;
            }
            let (truth, found) = (&sample.truth, &sample.received);
            let held = [
                off(truth.pitch, pitch),
                off(truth.roll, roll),
                off(truth.yaw, heading),
            ];
            assert!(held.iter().all(|off| *off < 0.5), "not held: {held:?}");
            let tilt = off(found.pitch, truth.pitch).max(off(found.roll, truth.roll));
            worst[0] = worst[0].max(tilt);
            worst[1] = worst[1].max(off(found.heading, truth.yaw));
        }
    }
    worst
}

#[test]
fn a_guard_with_a_wrongly_mounted_board_is_armed_and_right_only_after_its_commissioning() {
    let programs = Kind::B2p2.programs(Board::Host);
    let programs = programs.unwrap_or_else(|error| panic!("{error}"));
    let before = armed_and_moved(&programs, None);
    let wrong = errors(&before);
    assert!(wrong[0] > 5.0 && wrong[1] > 20.0, "{wrong:?}");
    assert!(!arms(&before));

    let flash = Path::new(env!("CARGO_TARGET_TMPDIR")).join("commissioned-flash");
    let _ = fs::remove_dir_all(&flash);
    fs::create_dir_all(&flash).expect("a folder");
    let flash = flash.display().to_string();
    let printed = commission(&programs, flash.clone());
    assert!(printed.ends_with("next start\n"), "{printed}");
    let after = armed_and_moved(&programs, Some(flash));
    assert!(arms(&after), "{printed}");
    let [tilt, heading] = errors(&after);
    println!("before {wrong:?}, after {tilt} {heading}");
    assert!(tilt < 0.5 && heading < 3.0, "{tilt} {heading} {printed}");
}
