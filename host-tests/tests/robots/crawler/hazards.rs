//! Tests which manoeuvres topple the crawler.

use crate::crawler::driven::{DT, Driven, loaded, slope};
use tautrack_host_tests::robots::crawler::plant::{CrawlerParameters, Profile};
use tautrack_host_tests::world::Plant;

/// Belt speeds, m/s, the acceleration towards them, m/s^2, and the duration, s.
type Leg = ([f64; 2], f64, f64);
/// Robot, its ground, and its manoeuvre.
type Run = (CrawlerParameters, Profile, Vec<Leg>);

/// Time at which the robot topples during these legs, s.
fn turns_over(parameters: &CrawlerParameters, profile: &Profile, legs: &[Leg]) -> Option<f64> {
    let mut driven = Driven::new(parameters, profile);
    let mut steps = 0;
    for (belts, acceleration, seconds) in legs {
        driven.acceleration = *acceleration;
        for _ in 0..(seconds / DT).round() as usize {
            driven.step(*belts);
            steps += 1;
            if driven.plant.truth().toppled {
                return Some(f64::from(steps) * DT);
            }
        }
    }
    None
}

/// On rigid ground, a rigid robot topples where its centre of gravity passes the end of the ground
/// runs, or the centre line of a track. Here the ground yields under the lower edge, so the plant
/// topples some degrees earlier.
#[test]
fn a_parked_robot_turns_over_where_its_centre_of_gravity_passes_the_edge() {
    let parked = [([0.0; 2], 0.5, 3.0)];
    let (mass, load, up) = (5.0, 2.0, 0.25);
    let height = (mass * 0.045 + load * up) / (mass + load);
    let p = loaded(load, up);
    for sign in [1.0, -1.0] {
        let edge = (0.5 * p.contact_length / height).atan().to_degrees();
        assert_eq!(turns_over(&p, &slope(sign * (edge - 4.5)), &parked), None);
        assert!(turns_over(&p, &slope(sign * (edge + 0.5)), &parked).is_some());
        let edge = (0.5 * p.track_spacing / height).atan().to_degrees();
        let cross = |degrees: f64| Profile {
            cross: (sign * degrees).to_radians(),
            ..Profile::default()
        };
        assert_eq!(turns_over(&p, &cross(edge - 1.0), &parked), None);
        assert!(turns_over(&p, &cross(edge + 0.5), &parked).is_some());
    }
}

/// Each hazard topples the robot; the same manoeuvre done gently, slowly or without the load does
/// not.
#[test]
fn hazards_turn_the_robot_over_and_their_milder_kin_do_not() {
    let ramp = |degrees: f64| Profile {
        from_x: Some(0.5),
        ..slope(degrees)
    };
    let cross = |degrees: f64| Profile {
        cross: degrees.to_radians(),
        ..Profile::default()
    };
    let (bare, low, high) = (loaded(0.0, 0.0), loaded(2.0, 0.25), loaded(4.0, 0.25));
    let (rest, start) = (([0.0; 2], 0.5, 0.5), ([0.4; 2], 0.5, 1.5));
    let cases: [(&str, [Run; 2]); 5] = [
        (
            "a hard start uphill",
            [
                (low, slope(24.0), vec![rest, ([0.4; 2], 4.0, 2.0)]),
                (low, slope(24.0), vec![rest, ([0.4; 2], 0.2, 4.0)]),
            ],
        ),
        (
            "from the flat onto a slope",
            [
                (high, ramp(20.0), vec![rest, ([0.3; 2], 0.5, 6.0)]),
                (high, ramp(20.0), vec![rest, ([0.05; 2], 0.5, 25.0)]),
            ],
        ),
        (
            "turning uphill on a steep cross slope",
            [
                (low, cross(30.0), vec![rest, ([0.05, 0.15], 0.5, 8.0)]),
                (bare, cross(30.0), vec![rest, ([0.05, 0.15], 0.5, 8.0)]),
            ],
        ),
        (
            "a hard stop downhill",
            [
                (low, slope(-25.0), vec![rest, start, ([0.0; 2], 8.0, 2.0)]),
                (low, slope(-25.0), vec![rest, start, ([0.0; 2], 0.3, 3.0)]),
            ],
        ),
        (
            "a quick turn across a slope",
            [
                (
                    high,
                    cross(24.0),
                    vec![
                        rest,
                        ([0.6; 2], 0.5, 2.0),
                        ([0.4, 0.8], 4.0, 0.5),
                        ([0.6; 2], 4.0, 1.0),
                    ],
                ),
                (
                    high,
                    cross(24.0),
                    vec![
                        rest,
                        ([0.2; 2], 0.5, 2.0),
                        ([0.15, 0.25], 0.5, 0.5),
                        ([0.2; 2], 0.5, 1.0),
                    ],
                ),
            ],
        ),
    ];
    for (name, [hazard, mild]) in cases {
        let times = [hazard, mild].map(|(p, profile, legs)| turns_over(&p, &profile, &legs));
        println!("{name}: {times:?}");
        assert!(
            times[0].is_some() && times[1].is_none(),
            "{name}: {times:?}"
        );
    }
}
