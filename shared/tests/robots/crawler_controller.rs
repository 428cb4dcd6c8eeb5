//! Tests of the crawler's body controller alone: its limits for any input, and its reaction to
//! slopes and measurements.

use proptest::prelude::*;
use tautrack::robots::crawler::parameters::{DIMENSIONS, GROUND, MASSES};
use tautrack::robots::crawler::path::{PathFollower, Pose};
use tautrack::robots::crawler::slip::{Slip, SlipModel};
use tautrack::robots::crawler::{BodyVelocity, Configuration, Controller, Observation, Shape};

const PERIOD: f32 = 0.004;
const LIMIT: f32 = 20.0;

fn controller(compensates_slip: bool) -> Controller {
    Controller::new(&Configuration {
        dimensions: DIMENSIONS,
        body: MASSES,
        ground: GROUND,
        compensates_slip,
        sprocket_limit: f64::from(LIMIT),
    })
    .unwrap()
}

fn model() -> SlipModel {
    SlipModel::new(&DIMENSIONS, &MASSES, &GROUND).unwrap()
}

/// Ordinary values, and less often any bits.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![3 => -2.0f32..2.0, 1 => any::<u32>().prop_map(f32::from_bits)]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_input_makes_a_sprocket_exceed_its_limit_or_spoils_what_follows(
        ticks in prop::collection::vec(prop::array::uniform8(any_number()), 1..20),
        compensates in any::<bool>(),
    ) {
        let mut controller = controller(compensates);
        for [left, right, heading, pitch, roll, measured, forward, yaw_rate] in ticks {
            let measured_speed = (roll > 0.0).then_some(measured);
            let observation = Observation { sprockets: [left, right], heading, pitch, roll, measured_speed };
            controller.observe(&observation, PERIOD);
            let command = controller.command(BodyVelocity { forward, yaw_rate }, PERIOD);
            for rate in command.sprockets {
                prop_assert!(rate.abs() <= LIMIT, "{command:?}");
            }
        }
        let stop = BodyVelocity { forward: 0.0, yaw_rate: 0.0 };
        prop_assert_eq!(controller.command(stop, PERIOD).sprockets, [0.0; 2]);
        controller.observe(&Observation::default(), PERIOD);
        let [left, right] = controller.command(BodyVelocity { forward: 0.1, yaw_rate: 0.0 }, PERIOD).sprockets;
        prop_assert!(left > 1.0 && right > 1.0, "{} {}", left, right);
    }

    #[test]
    fn a_measurement_misleads_the_slip_by_a_factor_of_three_at_most_and_slowly(
        speeds in prop::collection::vec(any_number(), 1..200),
        pitch in -0.5f32..0.5,
    ) {
        let (fresh, mut model) = (model().predict(pitch, 0.0, false).forward, model());
        for measured in speeds {
            let before = model.correction();
            model.learn(&model.predict(pitch, 0.0, false), [0.15; 2], measured, PERIOD);
            prop_assert!((model.correction() - before).abs() < 0.05);
            let slip = model.predict(pitch, 0.0, false).forward;
            for (slip, fresh) in slip.into_iter().zip(fresh) {
                prop_assert!(slip.abs() <= 3.001 * fresh.abs() && slip.abs() >= 0.332 * fresh.abs() && slip.abs() <= 0.6);
            }
        }
    }
}

#[test]
fn uphill_costs_path_and_downhill_gives_some_whichever_way_the_robot_drives() {
    for (pitch, forward) in [(0.3, 0.15), (0.3, -0.15), (-0.3, 0.15), (-0.3, -0.15)] {
        let [with, without] = [true, false].map(|compensates| {
            let mut controller = controller(compensates);
            controller.observe(
                &Observation {
                    pitch,
                    ..Observation::default()
                },
                PERIOD,
            );
            controller
                .command(
                    BodyVelocity {
                        forward,
                        yaw_rate: 0.0,
                    },
                    PERIOD,
                )
                .sprockets[0]
        });
        let climbs = pitch * forward > 0.0;
        assert_eq!(
            with.abs() > without.abs(),
            climbs,
            "{pitch} {forward}: {with} {without}"
        );
        assert!((without * 0.027_94 - forward).abs() < 1e-6);
    }
}

#[test]
fn a_slope_beyond_the_ground_s_strength_is_said_to_be_so() {
    let mut controller = controller(true);
    for (pitch, beyond) in [(0.45, false), (0.60, true), (-0.60, true), (0.0, false)] {
        controller.observe(
            &Observation {
                pitch,
                ..Observation::default()
            },
            PERIOD,
        );
        let asked = BodyVelocity {
            forward: 0.1,
            yaw_rate: 0.0,
        };
        assert_eq!(
            controller.command(asked, PERIOD).beyond_traction,
            beyond,
            "{pitch}"
        );
    }
}

#[test]
fn too_fast_a_curve_is_driven_slower_but_as_tight() {
    let mut controller = controller(false);
    let [left, right] = controller
        .command(
            BodyVelocity {
                forward: 2.0,
                yaw_rate: 4.0,
            },
            PERIOD,
        )
        .sprockets;
    let half = 0.5 * 0.145 * 4.0;
    assert!(
        (right - LIMIT).abs() < 1e-4 && (left / right - (2.0 - half) / (2.0 + half)).abs() < 1e-6,
        "{left} {right}"
    );
}

/// An ideal point robot stays on the circle that the commanded speeds describe, even at half the
/// speed.
#[test]
fn the_path_is_geometry_whatever_share_of_the_speed_is_left() {
    let asked = BodyVelocity {
        forward: 0.2,
        yaw_rate: 0.4,
    };
    for share in [1.0, 0.5] {
        let (mut follower, mut pose) = (PathFollower::default(), Pose::default());
        for _ in 0..8_000 {
            let motion = follower.follow(asked, &pose, 0.0, PERIOD);
            pose = pose.moved(
                share * motion.forward * PERIOD,
                0.0,
                share * motion.yaw_rate * PERIOD,
            );
            let radius = pose.x.hypot(pose.y - 0.5);
            assert!(
                (radius - 0.5).abs() < 2e-3,
                "share {share}: {radius} at {pose:?}"
            );
        }
    }
}

#[test]
fn on_a_cross_slope_the_robot_is_known_to_drift_downhill() {
    for (forward, roll) in [(0.15, 0.3), (0.15, -0.3), (-0.15, 0.3)] {
        let mut controller = controller(true);
        let radius = 0.027_94;
        for _ in 0..1_000 {
            controller.observe(
                &Observation {
                    sprockets: [forward / radius; 2],
                    roll,
                    ..Observation::default()
                },
                PERIOD,
            );
        }
        let pose = controller.pose();
        assert!((pose.x - forward * 4.0).abs() < 1e-3, "{pose:?}");
        // The left side is up, so downhill is to the right.
        assert!(pose.y * roll < 0.0 && pose.y.abs() > 0.02, "{pose:?}");
    }
}

#[test]
fn a_load_moves_the_centre_of_gravity_and_the_edges_stay() {
    let body = MASSES.loaded(2.0, [0.03, -0.02, 0.25]);
    let shape = Shape::new(&DIMENSIONS, &body).unwrap();
    let want = [0.06 / 7.0, -0.04 / 7.0, (5.0 * 0.045 + 0.5) / 7.0];
    for (got, want) in shape.cog.into_iter().zip(want) {
        assert!((f64::from(got) - want).abs() < 1e-7, "{shape:?}");
    }
    let [rear_right, front_right, front_left, rear_left] = shape.contacts;
    assert_eq!(rear_right, [-0.0635, -0.0725, 0.0]);
    assert_eq!(front_left, [0.0635, 0.0725, 0.0]);
    assert_eq!([front_right[0], rear_left[1]], [0.0635, 0.0725]);
    let raised = shape.turned(|[x, y, z]| [x, y, z + 1.0]);
    assert_eq!(
        (raised.cog[2], raised.contacts[2][2]),
        (shape.cog[2] + 1.0, 1.0)
    );
}

/// A track under more load can transmit the same force with less slip.
#[test]
fn the_track_that_carries_less_slips_more() {
    let body = MASSES.loaded(2.0, [0.0, 0.05, 0.05]);
    let model = SlipModel::new(&DIMENSIONS, &body, &GROUND).unwrap();
    let [left, right] = model.predict(0.3, 0.0, false).forward;
    assert!(right > 1.05 * left, "{left} {right}");
    let [left, right] = self::model().predict(0.3, 0.3, false).forward;
    assert!(left > 1.05 * right, "the side that is up: {left} {right}");
}

/// Twice the slip that the model of the soil expects, uphill and downhill, forward and backward.
#[test]
fn a_speed_that_is_measured_for_two_minutes_corrects_the_slip() {
    for (pitch, speed) in [(0.3, 0.15), (-0.3, 0.15), (0.3, -0.15), (-0.3, -0.15_f32)] {
        let mut model = model();
        let expected = |model: &SlipModel| model.predict(pitch, 0.0, speed < 0.0);
        let [soil, _] = expected(&model).along([speed; 2]);
        for _ in 0..1_200 {
            let slip = expected(&model);
            model.learn(&slip, [speed; 2], speed * (1.0 - 2.0 * soil), 0.1);
        }
        let correction = model.correction();
        assert!(
            (correction - 2.0).abs() < 0.1,
            "{pitch} {speed}: {correction}"
        );
    }
}

#[test]
fn belts_that_stand_or_turn_the_robot_on_the_spot_teach_nothing() {
    for belts in [[0.0; 2], [0.15, -0.15], [-0.2, 0.2]] {
        let mut model = model();
        let slip = model.predict(0.3, 0.0, false);
        for _ in 0..1_000 {
            model.learn(&slip, belts, 0.05, PERIOD);
        }
        assert_eq!(model.correction(), 1.0, "{belts:?}");
    }
}

/// A robot that loses 0.2 and 0.1 of its belts' travel moves on by 0.85 of it, backward by 1.15.
#[test]
fn the_drift_is_the_direction_in_which_the_robot_travels() {
    let slip = Slip {
        forward: [0.2, 0.1],
        rightward: 0.05,
        beyond_traction: false,
    };
    let exact = |ahead: f64| f64::atan2(0.05, ahead) as f32;
    assert!((slip.drift(1.0) + exact(0.85)).abs() < 1e-5);
    assert!((slip.drift(-1.0) - exact(1.15)).abs() < 1e-5);
}
