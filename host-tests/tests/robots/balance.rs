//! Tests of the centre of gravity and the zero moment point along the heading, as in Fig. 8 of the
//! B2P2 paper.

use std::path::Path;
use tautrack_host_tests::results::zmp::Balance;
use tautrack_host_tests::robots::b2p2::plant::{B2p2, B2p2Parameters};
use tautrack_host_tests::robots::b2p2::results::length;
use tautrack_host_tests::robots::payload::Payload;
use tautrack_host_tests::scenario::{Description, Scenario};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::truth::Truth;

const MASS: f64 = 8.315_283;

fn staircase(change: impl FnOnce(&mut Description)) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/staircase.toml");
    let mut description = Scenario::load(&file).unwrap().description();
    change(&mut description);
    description.check().unwrap()
}

/// Samples of the robot without rotation, with axle 1 at `path(time)`.
fn samples(seconds: u32, path: impl Fn(f64) -> [f64; 3]) -> Vec<Sample> {
    (0..seconds * 100)
        .map(|index| {
            let time_s = f64::from(index + 1) / 100.0;
            let axle_1 = path(time_s);
            Sample {
                time_s,
                truth: Truth {
                    axle_1,
                    extension: 0.226,
                    contacts: vec![[axle_1[0], 0.1, 0.0], [axle_1[0] + 0.776, 0.1, 0.0]],
                    ..Truth::default()
                },
                ..Sample::default()
            }
        })
        .collect()
}

fn parameters(scenario: &Scenario) -> B2p2Parameters {
    let robot = scenario.robot.b2p2().expect("B2P2");
    robot.parameters(scenario.friction)
}

#[test]
fn the_centre_of_gravity_is_the_plants_with_and_without_payload() {
    for payload in [0.0, 2.0] {
        let scenario = staircase(|description| {
            description.robot.b2p2_mut().com_offset_m = 0.02;
            description.robot.b2p2_mut().payload = Some(Payload {
                mass_kg: payload,
                place_m: [0.1, 0.03, 0.25],
                from_s: 0.0,
                declared: false,
            });
        });
        let mut plant = B2p2::new(&parameters(&scenario), &scenario.terrain.ground(), 1);
        let samples: Vec<Sample> = (1..=50)
            .map(|index| {
                (0..10).for_each(|_| plant.step(&[None; 4]));
                Sample {
                    time_s: f64::from(index) / 100.0,
                    truth: plant.truth().clone(),
                    ..Sample::default()
                }
            })
            .collect();
        let balance = Balance::over(&scenario, &samples);
        for (sample, moment) in samples.iter().zip(&balance.moments).skip(1).take(48) {
            let truth = &sample.truth;
            let along = |point: [f64; 3]| {
                (point[0] - truth.axle_1[0]) * truth.yaw.cos()
                    + (point[1] - truth.axle_1[1]) * truth.yaw.sin()
            };
            let moment = moment.unwrap();
            assert!(
                (moment.cog - along(truth.cog)).abs() < 1e-6,
                "{} against {} m",
                moment.cog,
                along(truth.cog)
            );
        }
    }
}

#[test]
fn an_acceleration_moves_the_zero_moment_point_as_newton_says() {
    // With a forward acceleration a, the ground pushes forward at the height -h below the centre of
    // gravity, so its force must act h a / g further behind.
    let (acceleration, height) = (0.5, 0.08);
    let samples = samples(2, |time| [0.5 * acceleration * time * time, 0.0, height]);
    let balance = Balance::over(&staircase(|_| {}), &samples);
    let moment = balance.moments[100].unwrap();
    // The front's centres of mass are off its line by at most a millimetre in all.
    let expected = -acceleration * height / 9.81;
    let got = moment.difference().unwrap();
    assert!((got - expected).abs() < 1e-4, "{got} against {expected} m");
    assert!((moment.smoothed.unwrap() - expected).abs() < 1e-4);
    assert!(
        (moment.cog - (6.356_067 * 0.160_894 + 0.897_066 * 0.424_083 + 1.062_15 * 0.702_68) / MASS)
            .abs()
            < 1e-5
    );
    let [p1, p2, p3] = moment.axles;
    assert!(p1.abs() + (p2 - 0.32).abs() + (p3 - 0.776).abs() < 1e-12);
}

#[test]
fn figures_are_means_and_peaks_over_the_climb_in_percent_of_the_length() {
    let scenario = staircase(|_| {});
    // A jolt at 7 s, when the front stops rising; level again at 30 s.
    let mut samples = samples(40, |time| [0.13 * time, 0.0, 0.05]);
    for sample in &mut samples {
        let rise = (0.1 * (sample.time_s - 5.0)).clamp(0.0, 0.2);
        let fall = (0.1 * (sample.time_s - 28.0)).clamp(0.0, 0.2);
        sample.truth.pitch = rise - fall;
        sample.truth.cog = [sample.truth.axle_1[0] + 0.26, 0.0, 0.1];
    }
    let balance = Balance::over(&scenario, &samples);
    let figures = balance.figures.unwrap();
    let [first, middle, last] = balance.areas.map(|area| area.samples);
    assert_eq!((first.end, middle.end), (middle.start, last.start));
    let at = |index: usize| samples[index].truth.cog[0];
    assert!((at(first.end) - 1.6).abs() < 2e-3 && (at(middle.end) - 2.44).abs() < 2e-3);

    let climb: Vec<_> = (first.start..last.end)
        .map(|index| balance.moments[index].unwrap().difference().unwrap().abs())
        .collect();
    let percent = |metres: f64| 100.0 * metres / 0.876;
    assert!((length(&parameters(&scenario)) - 0.876).abs() < 1e-12);
    let mean = percent(climb.iter().sum::<f64>() / climb.len() as f64);
    let peak = percent(climb.iter().copied().fold(0.0, f64::max));
    assert!((figures.raw.mean - mean).abs() < 1e-9 && (figures.raw.peak - peak).abs() < 1e-9);
    // The jolt of one sample, spread over a Gaussian of 0.15 s: its middle weight is 0.01 / (0.15
    // sqrt(2 pi)).
    let middle = peak * 0.01 / (0.15 * std::f64::consts::TAU.sqrt());
    assert!(
        (figures.smoothed.peak - middle).abs() < 0.05 * middle,
        "{} against {middle} %",
        figures.smoothed.peak
    );
}

#[test]
fn level_ground_and_no_samples_have_no_figures() {
    let flat = staircase(|description| {
        description.terrain = tautrack_host_tests::world::terrain::Terrain::Flat;
        description.expect = tautrack_host_tests::scenario::Expect::default();
    });
    assert!(
        Balance::over(&flat, &samples(1, |time| [time, 0.0, 0.05]))
            .figures
            .is_none()
    );
    assert!(Balance::over(&staircase(|_| {}), &[]).figures.is_none());
}
