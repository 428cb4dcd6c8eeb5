//! Tests of the belts of B2P2's plant against computations of another kind: a shortest path by
//! search, the friction on a corner by integration, and the balance of forces.

use super::b2p2_plant::{DT, Driven, WEIGHT};
use core::f64::consts::{PI, TAU};
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use rapier3d_f64::glamx::DVec2;
use tautrack_host_tests::robots::b2p2::plant::B2p2Parameters;
use tautrack_host_tests::robots::b2p2::plant::belt::inside::Inside;
use tautrack_host_tests::robots::b2p2::plant::belt::path::{Corner, Path, Pulleys};
use tautrack_host_tests::robots::b2p2::plant::belt::tension::{Elasticity, Material};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::ground::Ground;

const RADIUS: f64 = 0.05;

fn pulleys(l1: f64, front: f64, theta: f64) -> Pulleys {
    let second = DVec2::new(l1, 0.0);
    let third = second + DVec2::new(theta.cos(), theta.sin()) * front;
    Pulleys {
        axles: [DVec2::ZERO, second, third],
        radius: RADIUS,
    }
}

fn length(path: &Path) -> f64 {
    path.length(RADIUS)
}

fn random(rng: &mut TestRng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Length of the shortest run from the lowest point of pulley 1 to the foremost point of pulley 3
/// over `corners`, by a search over `count` places on the lower half of each pulley: from any place
/// to any other one, along every line that enters neither pulley and passes above every corner.
fn searched(pulleys: &Pulleys, corners: &[DVec2], count: usize) -> f64 {
    let [first, _, third] = pulleys.axles;
    let rim = |centre: DVec2, angle: f64| centre + DVec2::new(angle.sin(), -angle.cos()) * RADIUS;
    let angles: Vec<f64> = (0..=count)
        .map(|i| PI * (1.5 * i as f64 / count as f64 - 0.75))
        .collect();
    let along = third - first;
    let clear = |from: DVec2, to: DVec2| {
        let line = to - from;
        let outside = [first, third].into_iter().all(|centre| {
            let part = ((centre - from).dot(line) / line.length_squared()).clamp(0.0, 1.0);
            (from + line * part).distance(centre) > RADIUS * 0.999_97
        });
        outside
            && corners.iter().all(|corner| {
                let [start, end, at] = [from, to, *corner].map(|place| along.dot(place));
                at <= start + 1e-9 || at >= end - 1e-9 || line.perp_dot(*corner - from) <= 1e-9
            })
    };
    // Cheapest way to each corner from pulley 1, in the order of the corners.
    let mut costs: Vec<f64> = Vec::new();
    // The belt runs forward where it leaves a pulley, and where it arrives.
    let forward = |angle: f64, way: DVec2| way.dot(DVec2::new(angle.cos(), angle.sin())) > 0.0;
    let leave = |to: DVec2| {
        angles
            .iter()
            .filter(|angle| forward(**angle, to - rim(first, **angle)))
            .filter(|angle| clear(rim(first, **angle), to))
            .map(|angle| angle * RADIUS + rim(first, *angle).distance(to))
            .fold(f64::INFINITY, f64::min)
    };
    for (index, corner) in corners.iter().enumerate() {
        let mut best = leave(*corner);
        for before in 0..index {
            if clear(corners[before], *corner) {
                best = best.min(costs[before] + corners[before].distance(*corner));
            }
        }
        costs.push(best);
    }
    let mut best = f64::INFINITY;
    for angle in &angles {
        let (place, rest) = (rim(third, *angle), (0.5 * PI - angle) * RADIUS);
        if forward(*angle, third - first) {
            best = best.min(leave(place) + rest);
        }
        for (corner, cost) in corners.iter().zip(&costs) {
            if forward(*angle, place - *corner) && clear(*corner, place) {
                best = best.min(cost + corner.distance(place) + rest);
            }
        }
    }
    best
}

#[test]
fn the_belt_takes_the_shortest_way_over_the_corners() {
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let (mut worst, mut pressed) = (0.0_f64, 0);
    for _ in 0..1_000 {
        let front = random(&mut rng, [0.3, 0.6]);
        let theta = random(&mut rng, [-1.0, -0.1]);
        let pulleys = pulleys(0.32, front, theta);
        let [first, second, third] = pulleys.axles;
        let chord = (third - first).normalize();
        let height = chord.perp_dot(second - first);
        let mut corners: Vec<DVec2> = (0..rng.next_u32() % 5)
            .map(|_| {
                let place = random(&mut rng, [0.1, 0.9]) * first.distance(third);
                let up = random(&mut rng, [-0.1, 0.8 * height]) - RADIUS;
                first + chord * place + chord.perp() * up
            })
            .collect();
        corners.retain(|corner| {
            [first, third]
                .into_iter()
                .all(|centre| corner.distance(centre) > 1.05 * RADIUS)
        });
        corners.sort_by(|a, b| chord.dot(*a).total_cmp(&chord.dot(*b)));
        let numbered: Vec<Corner> = corners
            .iter()
            .enumerate()
            .map(|(edge, place)| Corner {
                edge,
                place: *place,
            })
            .collect();
        let path = Path::around(&pulleys, &numbered, true);
        pressed += path.sections().len() - 1;
        // What the corners add to the path that has none.
        let added = length(&path) - length(&Path::around(&pulleys, &[], true));
        let expected = searched(&pulleys, &corners, 720) - searched(&pulleys, &[], 720);
        worst = worst.max((added - expected).abs());
        if (added - expected).abs() > 1e-5 {
            println!("{theta} {front} {corners:?} {added} {expected}");
        }
    }
    println!("{pressed} corners pressed; worst difference {worst:e} m");
    assert!(pressed > 500 && worst < 2e-6, "{pressed}, {worst}");
}

#[test]
fn without_corners_the_belt_is_as_long_as_the_law_says() {
    let p = B2p2Parameters::nominal();
    for step in -60..=100 {
        let theta = f64::from(step).to_radians();
        let pulleys = pulleys(p.l1, p.taut_length(theta), theta);
        let found = length(&Path::around(&pulleys, &[], true));
        let law = p.k + p.l1 + PI * RADIUS;
        assert!(
            (found - law).abs() < 1e-12,
            "{step} degrees: {found}, {law}"
        );
    }
}

/// Moves a corner into the loop and out again, from below or from the side, and returns how much it
/// lengthens the path in each step, m.
fn lengthened(inside: &mut Inside, heights: impl Iterator<Item = f64>) -> Vec<f64> {
    let pulleys = pulleys(0.32, 0.5, -0.8);
    let bare = length(&Path::around(&pulleys, &[], true));
    heights
        .map(|up| {
            let place = DVec2::new(0.36, up);
            let corner = Corner { edge: 3, place };
            length(&inside.path(&pulleys, &[corner], true)) - bare
        })
        .collect()
}

#[test]
fn a_belt_feels_a_corner_from_below_and_not_one_that_came_in_from_the_side() {
    let steps = |from: i32, to: i32| (from..=to).map(|step| f64::from(step) * 1e-3 - 0.1);
    let mut inside = Inside::default();
    let below = lengthened(&mut inside, steps(-200, 0));
    assert_eq!(below[0], 0.0);
    assert!(below[200] > 2e-3, "{}", below[200]);
    // From the side it is at its place at once. It is felt again after it has left the loop.
    let mut inside = Inside::default();
    assert_eq!(lengthened(&mut inside, steps(-200, -199)), [0.0; 2]);
    assert_eq!(lengthened(&mut inside, steps(0, 10)), [0.0; 11]);
    assert_eq!(lengthened(&mut inside, steps(-200, 0).rev()), [0.0; 201]);
    assert_eq!(lengthened(&mut inside, steps(-200, 0)), below);
}

/// Turns pulley 1 while the belt lies over one corner. The friction of the corner is integrated
/// over the bend in small steps.
#[test]
fn a_corner_holds_the_belt_up_to_the_friction_of_its_bend() {
    let pulleys = pulleys(0.32, 0.5, -0.8);
    let corner = Corner {
        edge: 3,
        place: DVec2::new(0.36, -0.10),
    };
    let path = Path::around(&pulleys, &[corner], true);
    let sections = path.sections();
    let bend = sections[0].ends_at.expect("a corner").1;
    let belt = Elasticity {
        stiffness: 1e5,
        length: length(&path) - 2e-3,
    };
    for (friction, direction) in [(0.5, 1.0), (0.5, -1.0), (1.0, 1.0)] {
        let mut material = Material::default();
        let mut ratio = 1.0;
        for _ in 0..2_000 {
            let fed = direction * 1e-6;
            let (tensions, touches) =
                material.tensions(&belt, &sections, &[0.0; 2], RADIUS, fed, friction);
            ratio = tensions[0] / tensions[1];
            assert!(
                direction * touches[0].sliding >= -1e-12,
                "slides against the motion"
            );
        }
        let mut integrated = 1.0;
        for _ in 0..100_000 {
            integrated += integrated * friction * bend / 100_000.0;
        }
        let found = if direction > 0.0 { ratio } else { 1.0 / ratio };
        assert!(
            (found / integrated - 1.0).abs() < 1e-4,
            "{found}, {integrated}"
        );
    }
}

#[test]
fn a_slack_belt_pulls_on_nothing() {
    let pulleys = pulleys(0.32, 0.456, -0.8);
    let path = Path::around(&pulleys, &[], true);
    let belt = Elasticity {
        stiffness: 1e5,
        length: length(&path) + 1e-3,
    };
    let mut material = Material::default();
    let (tensions, _) = material.tensions(&belt, &path.sections(), &[0.0], RADIUS, 0.01, 1.0);
    assert_eq!(tensions, [0.0]);
}

/// The robot stands still, folded over a low curb. The belts carry a part of the weight.
#[test]
fn ground_and_corners_carry_the_weight_of_a_robot_on_its_belts() {
    let ground = Ground::Curb {
        height: 0.10,
        front_x: 1.0,
        depth: 3.0,
    };
    let mut robot = Driven::new(&B2p2Parameters::nominal(), ground, 1);
    let theta = (-30.0_f64).to_radians();
    let mut on_corner = false;
    for _ in 0..14_000 {
        let lower = robot.plant.truth().pitch > 0.14;
        robot.step(robot.straight(0.1), if lower { theta } else { 0.35 });
        let corners = |robot: &Driven| robot.plant.belt_corners().count();
        if lower && robot.plant.truth().theta < 0.98 * theta && corners(&robot) == 2 {
            on_corner = true;
            break;
        }
    }
    assert!(on_corner, "{:?}", robot.plant.truth());
    robot.drive(0.0, 2.0);
    let carried: f64 = robot.plant.belt_corners().map(|force| force[2]).sum();
    assert!(carried > 0.1 * WEIGHT, "the corners carry {carried} N");
    // The robot bounces on its belts for some time; this is a whole number of periods.
    let lift = robot.mean(0.0, 3.0, |robot| robot.plant.lift());
    assert!(
        (lift - WEIGHT).abs() < 2e-3 * WEIGHT,
        "{lift} N for {WEIGHT} N"
    );
}

#[test]
fn belts_give_no_energy_to_a_robot_that_settles_on_flat_ground() {
    for (theta, tension) in [(0.0, 50.0), (-0.5, 400.0), (0.8, 400.0)] {
        let parameters = B2p2Parameters {
            initial_theta: theta,
            initial_clearance: 0.02,
            belt_tension: tension,
            ..B2p2Parameters::nominal()
        };
        let mut robot = Driven::new(&parameters, Ground::Flat, 1);
        robot.drive(0.0, 0.3);
        // The most energy of each second, which contains several bounces, is at most that of the
        // second before.
        let mut before = f64::INFINITY;
        for _ in 0..5 {
            let mut most = f64::NEG_INFINITY;
            for _ in 0..1_000 {
                robot.drive(0.0, DT);
                most = most.max(robot.plant.energy());
            }
            assert!(
                most < before + 1e-3,
                "{theta} rad: {before} J, then {most} J"
            );
            before = most;
        }
    }
}

/// The screw holds the tension of the law: by the principle of virtual work, each belt loads it
/// with the tension times the rate at which the loop grows with the extension.
#[test]
fn the_screw_carries_the_tension_of_both_belts() {
    let parameters = B2p2Parameters {
        belt_tension: 300.0,
        ..B2p2Parameters::nominal()
    };
    let slack = B2p2Parameters {
        belt_tension: 0.0,
        ..parameters
    };
    let force = |parameters: &B2p2Parameters| {
        let mut robot = Driven::new(parameters, Ground::Flat, 1);
        robot.drive(0.0, 1.0);
        let newton = TAU / parameters.screw_lead;
        let force = robot.mean(0.0, 0.2, |robot| robot.torque(3) * newton);
        let tension = robot.plant.truth().channels["left_belt_tension_n"];
        (force, tension)
    };
    let ((tense, tension), (loose, rest)) = (force(&parameters), force(&slack));
    // Straight, the loop grows by 2 m for each metre of the screw.
    let expected = 2.0 * 2.0 * (tension - rest);
    assert!(tension > 100.0, "{tension} N");
    assert!(
        (tense - loose - expected).abs() < 0.02 * expected,
        "{tense} N, {loose} N, expected {expected} N"
    );
}

#[test]
fn a_track_comes_off_if_its_belt_is_far_too_slack_and_a_released_one_stays_on() {
    // Belts that are 5 and 25 % longer than the law says.
    for (belt_tension, came_off) in [(-5.0e3, None), (-2.0e4, Some("left track"))] {
        let parameters = B2p2Parameters {
            belt_tension,
            ..B2p2Parameters::nominal()
        };
        let mut robot = Driven::new(&parameters, Ground::Flat, 1);
        robot.drive(0.0, 0.2);
        assert_eq!(robot.plant.truth().came_off, came_off, "{belt_tension} N");
    }
}

#[test]
fn corners_push_the_belts_in_between_pulleys_only_as_far_as_the_guide_plates_let_them() {
    let ground = Ground::Curb {
        height: 0.04,
        front_x: 0.9,
        depth: 3.0,
    };
    for (guide_clearance, pushes) in [(0.0, false), (0.02, true)] {
        let parameters = B2p2Parameters {
            guide_clearance,
            ..B2p2Parameters::nominal()
        };
        let mut robot = Driven::new(&parameters, ground, 1);
        let mut pushed = false;
        for _ in 0..8_000 {
            robot.drive(0.1, DT);
            pushed |= robot.plant.belt_corners().any(|force| force[2] > 1.0);
        }
        assert_eq!(pushed, pushes, "{guide_clearance} m");
    }
}
