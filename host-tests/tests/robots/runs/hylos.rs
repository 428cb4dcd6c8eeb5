//! Tests of Hylos' seventeen nodes on its hillside: the loop of Besseron et al. (Fig. 7) with and
//! without posture control, and five hazards.

use super::{ends_in_the_same_bits, outcome, scenario, tried, unless_unchanged};
use std::f64::consts::{PI, TAU};
use tautrack::robots::hylos::parameters::MARGIN_LIMIT;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::robots::Robot;
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::world::terrain::Terrain;

/// Centre of the loop, m.
const CENTRE: [f64; 2] = [0.0, 2.0];

fn half_turn(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Minimum tip-over angle in the plant's ground truth, rad.
fn least_margin(samples: &[Sample]) -> f64 {
    samples.iter().fold(f64::INFINITY, |least, sample| {
        least.min(sample.truth.channels["tip_over_margin_rad"])
    })
}

/// Angle that the robot has travelled around the loop, rad.
fn turned(samples: &[Sample]) -> f64 {
    let around = |sample: &Sample| {
        let [x, y, _] = sample.truth.cog;
        (y - CENTRE[1]).atan2(x - CENTRE[0])
    };
    samples
        .windows(2)
        .map(|pair| half_turn(around(&pair[1]) - around(&pair[0])))
        .sum()
}

#[test]
fn posture_control_brings_the_nodes_around_the_loop() {
    unless_unchanged("hylos-loop", Kind::Hylos, || {
        let (summary, samples) = outcome(&scenario("hylos/loop", |_| {}), Board::Host);
        let (margin, turned) = (least_margin(&samples), turned(&samples));
        println!("margin at least {margin:.3} rad, {turned:.2} rad around");
        assert!(summary.expectation_met, "{summary}");
        assert!(margin > 0.1, "{margin}");
        let [steep, level] = [true, false].map(|near| {
            let channels = samples.iter().map(|sample| &sample.truth.channels);
            let found = channels.filter(|of| (of["tip_over_margin_rad"] <= MARGIN_LIMIT) == near);
            found
                .map(|of| of["stability_potential_1"])
                .collect::<Vec<_>>()
        });
        assert!(!steep.is_empty() && steep.iter().all(|potential| *potential > 0.0));
        assert!(!level.is_empty() && level.iter().all(|potential| *potential == 0.0));
        assert!((turned - TAU).abs() < 0.15, "{turned}");
        // Seventeen nodes leave a fifth of the bus time free.
        assert!(summary.bus.load_max < 0.8, "{summary}");
    });
}

/// The weight shifts from leg to leg while they are homed.
#[test]
fn legs_that_stand_are_homed_on_any_ground() {
    let grounds = [
        (39.8, 1.378, 0.016, 3.6),
        (31.5, 1.082, 0.005, 65.9),
        (41.2, 1.803, 0.003, 132.6),
    ];
    for (seed, (slope_deg, foot_m, wave_height_m, heading_deg)) in (1..).zip(grounds) {
        let standing = scenario("hylos/loop", |description| {
            description.seed = seed;
            description.duration_s = 3.0;
            description.terrain = Terrain::Hillside {
                slope_deg,
                foot_m,
                wave_height_m,
            };
            description.operator.events.clear();
            if let Robot::Hylos(robot) = &mut description.robot {
                robot.heading_deg = heading_deg;
            }
        });
        let (_, samples) = outcome(&standing, Board::Host);
        let last = &samples.last().expect("samples").received;
        assert_eq!(last.guard_state, "armed", "seed {seed}: {:?}", last.events);
    }
}

#[test]
fn without_posture_control_the_nodes_tip_over_on_the_loop() {
    unless_unchanged("hylos-without", Kind::Hylos, || {
        let (summary, samples) = outcome(&scenario("hylos/without", |_| {}), Board::Host);
        assert!(summary.toppled && summary.expectation_met, "{summary}");
        assert!(turned(&samples) < 0.75 * TAU);
    });
}

#[test]
fn emulated_nodes_and_those_in_this_process_of_hylos_end_in_the_same_bits() {
    unless_unchanged("hylos-bits", Kind::Hylos, || {
        ends_in_the_same_bits("hylos/loop");
    });
}

#[test]
fn the_guard_holds_what_tips_over_without_it() {
    unless_unchanged("hylos-hazards", Kind::Hylos, || {
        for name in tried(&[
            "across-without-posture-control",
            "hard-stop-backing-down",
            "quick-turn-uphill",
            "raised-too-high",
            "hard-start-uphill",
        ]) {
            let [with, without] = [true, false].map(|guard| {
                let changed = scenario(&format!("hylos/hazards/{name}"), |description| {
                    description.guard = guard;
                    description.expect = tautrack_host_tests::scenario::Expect::default();
                });
                outcome(&changed, Board::Host).0
            });
            assert!(without.toppled, "{name} is no hazard: {without}");
            assert!(
                !with.toppled && with.guard.interventions > 0,
                "{name}: {with}"
            );
        }
    });
}

#[test]
fn hylos_and_its_hillside_come_together_or_not_at_all() {
    let refusal = |name: &str, change: fn(&mut tautrack_host_tests::scenario::Description)| {
        let mut description = scenario(name, |_| {}).description();
        change(&mut description);
        description.check().unwrap_err().to_string()
    };
    assert!(
        refusal("hylos/loop", |d| d.robot = Robot::default()).starts_with("terrain is a hillside")
    );
    let stairs = |d: &mut tautrack_host_tests::scenario::Description| {
        d.terrain = scenario("staircase", |_| {}).terrain;
    };
    assert!(refusal("hylos/loop", stairs).starts_with("terrain is none of Hylos"));
    let high = |d: &mut tautrack_host_tests::scenario::Description| {
        if let Robot::Hylos(hylos) = &mut d.robot {
            hylos.clearance_m = 0.5;
        }
    };
    assert_eq!(
        refusal("hylos/loop", high),
        "robot.hylos.clearance_m is 0.5; it must be at most 0.4 m"
    );
}
