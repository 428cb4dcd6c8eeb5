//! Tests of a robot whose operator releases its belts.

use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::scenario::{Belts, Event, Expect, OperatorRequest, When};
use tautrack_host_tests::world::terrain::Terrain;
use tautrack_host_tests::world::truth::Truth;

/// Slack of the belts by the plant's angle and extension, m: `K - r - L`.
fn slack(truth: &Truth) -> f64 {
    let r = 0.23 + truth.extension;
    let (sine, cosine) = truth.theta.sin_cos();
    1.232 - r - (0.32 + r * cosine).hypot(r * sine)
}

/// The robot raises its front by 45 degrees. Then it releases its belts and stops while it does so.
/// It goes on, and tightens them.
#[test]
fn belts_are_released_kept_in_a_stop_and_tightened() {
    unless_unchanged("released-belts", || {
        let scenario = scenario("flat", |description| {
            description.duration_s = 26.0;
            description.expect = Expect::default();
            let event = |time_s: f64| Event {
                when: When {
                    time_s: Some(time_s),
                    ..When::default()
                },
                ..Event::default()
            };
            description.operator.speed_mps = 0.0;
            description.operator.chassis_deg = 45.0;
            description.operator.events = vec![
                Event {
                    belts: Some(Belts::Released),
                    ..event(9.0)
                },
                Event {
                    request: Some(OperatorRequest::Stop),
                    ..event(10.0)
                },
                Event {
                    request: Some(OperatorRequest::Arm),
                    ..event(12.0)
                },
                Event {
                    belts: Some(Belts::Taut),
                    ..event(17.0)
                },
            ];
        });
        let samples = outcome(&scenario, Board::Host).1;
        let at = |time_s: f64| {
            let place = samples.partition_point(|sample| sample.time_s < time_s);
            slack(&samples[place].truth)
        };
        for (time_s, low, high) in [
            // The belts press the screw and the joint by their tension.
            (8.9, -4e-4, 4e-4),
            (10.5, 0.017, 0.022),
            // All that the screw can give at this angle.
            (16.9, 0.0571, 0.0573),
            (25.9, -4e-4, 4e-4),
        ] {
            let found = at(time_s);
            assert!((low..high).contains(&found), "{time_s} s: {found} m");
        }
        assert!((at(11.9) - at(10.5)).abs() < 2e-4, "a stop keeps the slack");
        // No sample shows a faster change than 20 mm/s and what the joint's motion adds.
        for pair in samples.windows(2).filter(|pair| pair[0].time_s > 8.0) {
            let rate =
                (slack(&pair[1].truth) - slack(&pair[0].truth)) / (pair[1].time_s - pair[0].time_s);
            assert!(rate.abs() < 0.03, "{} s: {rate} m/s", pair[0].time_s);
        }
    });
}

/// The same curb stops a robot whose belts stay taut.
#[test]
fn released_belts_haul_the_robot_over_a_curb_that_taut_ones_do_not_climb() {
    unless_unchanged("released-belts-curb", || {
        for height_m in [0.20, 0.25, 0.30] {
            for released in [true, false] {
                let scenario = scenario("curb-30-cm-released", |description| {
                    if let Terrain::Curb {
                        height_m: height, ..
                    } = &mut description.terrain
                    {
                        *height = height_m;
                    }
                    for event in &mut description.operator.events {
                        if event.belts.is_some() && !released {
                            event.belts = Some(Belts::Taut);
                        }
                    }
                });
                let (summary, samples) = outcome(&scenario, Board::Host);
                let case = format!("{height_m} m, released: {released}");
                println!("{case}: landed {}", summary.landed);
                assert_eq!(summary.landed, released, "{case}");
                assert!(!samples.iter().any(|sample| sample.truth.toppled), "{case}");
            }
        }
    });
}

/// Takes some minutes.
#[test]
#[ignore = "prints the table of docs/robots/b2p2.md"]
fn released_belts_clear_the_curb_in_twenty_draws_and_taut_ones_in_none() {
    for (released, guard) in [(true, true), (false, true), (false, false)] {
        let (mut landed, mut toppled) = (0, 0);
        for draw in 0..20_u32 {
            let scenario = scenario("curb-30-cm-released", |description| {
                description.seed = 101 + u64::from(draw);
                // From 0.9 to 1.2, in an order that is not that of the seeds.
                description.friction = 0.9 + 0.3 * f64::from(draw * 7 % 20) / 19.0;
                description.guard = guard;
                description.operator.events[0].belts = released.then_some(Belts::Released);
            });
            let (summary, _) = outcome(&scenario, Board::Host);
            landed += u32::from(summary.landed);
            toppled += u32::from(summary.toppled);
        }
        println!("released: {released}, guard: {guard}: {landed} landed, {toppled} toppled");
        assert!(if released { landed >= 18 } else { landed == 0 });
        assert!(toppled == 0 || !guard);
    }
}
