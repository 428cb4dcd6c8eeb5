//! Tests the margins that count against moments about the edges, in double precision.

use crate::random::Random;
use tautrack::constants::GRAVITY;
use tautrack::math::vector::{cross, dot, sub};
use tautrack::settings::Settings;
use tautrack::stability::criterion::Criterion;
use tautrack::stability::energy::stopping_speed;
use tautrack::stability::evaluation::Evaluation;
use tautrack::stability::parameters::{Parameters, Refusal, Uncertainty};
use tautrack::stability::support::{EDGES, Edge, NO_EDGE, Stance};
use tautrack::stability::tipover;
use tautrack::stability::tracker::Tracker;
use tautrack::stability::zmp::{Wrench, printed};

type Vector = [f64; 3];

/// Two corners of the support for each edge, in the order of [`EDGES`].
const CORNERS: [[usize; 2]; 4] = [[3, 0], [1, 2], [2, 3], [0, 1]];
const FLAT: [[f32; 3]; 4] = [
    [0.0, -0.2, 0.0],
    [0.8, -0.2, 0.0],
    [0.8, 0.2, 0.0],
    [0.0, 0.2, 0.0],
];
const SURE: Uncertainty = Uncertainty {
    cog: 0.0,
    mass: 0.0,
    reach: 0.0,
    robot_mass: 20.0,
    attitude: 0.0,
};

/// Parameters without the force-angle.
fn parameters(deduction: f32) -> Parameters {
    Parameters {
        stop_sine: 0.0,
        uncertainty: Uncertainty {
            cog: deduction,
            ..SURE
        },
        ..Parameters::new(&Settings::default())
    }
}

fn wide(vector: [f32; 3]) -> Vector {
    vector.map(f64::from)
}

/// A support whose corners are up to 5 cm higher or lower, a centre of gravity inside it, and a
/// force.
fn drawn(random: &mut Random) -> ([[f32; 3]; 4], [f32; 3], [f32; 3]) {
    let contacts = FLAT.map(|corner| corner.map(|x| x + 0.05 * random.next() as f32));
    let cog = [
        0.4 + 0.25 * random.next() as f32,
        0.1 * random.next() as f32,
        0.35 + 0.15 * random.next() as f32,
    ];
    let force = [
        3.0 * random.next() as f32,
        3.0 * random.next() as f32,
        GRAVITY + random.next() as f32,
    ];
    (contacts, cog, force)
}

/// Moment of the force about an edge, over its upward part and the horizontal length of the edge.
fn arm(contacts: [[f32; 3]; 4], edge: Edge, cog: [f32; 3], force: Vector) -> f64 {
    let [from, to] = CORNERS[edge as usize].map(|corner| wide(contacts[corner]));
    let direction = sub(to, from);
    let moment = dot(cross(sub(wide(cog), from), force), direction);
    moment / (force[2] * direction[0].hypot(direction[1]))
}

#[test]
fn margins_are_moments_about_the_edges_less_the_uncertainty() {
    let mut random = Random(3);
    for _ in 0..500 {
        let (contacts, cog, force) = drawn(&mut random);
        let deduction = 0.02;
        let found = Criterion::default().evaluate(
            &Stance::on(contacts, cog),
            force,
            9.0,
            &parameters(deduction),
        );
        assert!(found.force_counts && found.stop_would_tip);
        let [x, y, z] = wide(force);
        let uncertain = f64::from(deduction) * (1.0 + (x.abs() + y.abs()) / z);
        for edge in EDGES {
            let index = edge as usize;
            let gravity = arm(contacts, edge, cog, [0.0, 0.0, 1.0]) - f64::from(deduction);
            assert!((f64::from(found.gravity[index]) - gravity).abs() < 1e-5);
            let with_force = arm(contacts, edge, cog, wide(force)) - uncertain;
            let error = f64::from(found.margins[index]) - gravity.min(with_force);
            assert!(
                error.abs() < 1e-5,
                "{edge:?} {contacts:?} {cog:?} {force:?}: {error}"
            );
            // The margin with one more g of acceleration, forward and to the left.
            for (axis, lever) in found.levers[index].into_iter().enumerate() {
                let mut pushed = [0.0, 0.0, 1.0];
                pushed[axis] = 1.0;
                let change =
                    arm(contacts, edge, cog, pushed) - arm(contacts, edge, cog, [0.0, 0.0, 1.0]);
                assert!((f64::from(lever) - change).abs() < 1e-5, "{edge:?} {axis}");
            }
        }
    }
}

/// On edges and under forces of any direction, the margin is above the stop margin if and only if
/// the angle of Papadopoulos and Rey is above the stop angle.
#[test]
fn the_force_angle_counts_on_sloping_edges() {
    const ANGLE: f64 = 0.5;
    let mut random = Random(5);
    let parameters = Parameters {
        stop: 1e-3,
        stop_sine: ANGLE.sin() as f32,
        ..parameters(0.0)
    };
    let (mut above, mut below) = (0, 0);
    for _ in 0..2_000 {
        let (contacts, cog, force) = drawn(&mut random);
        let found =
            Criterion::default().evaluate(&Stance::on(contacts, cog), force, 9.0, &parameters);
        for edge in EDGES {
            let ends = CORNERS[edge as usize].map(|corner| wide(contacts[corner]));
            let [angle, _] = tipover::angles(&ends, wide(cog), wide(force).map(|x| -x), [0.0; 3]);
            let gravity = arm(contacts, edge, cog, [0.0, 0.0, 1.0]);
            if gravity < 2e-3 || (angle - ANGLE).abs() < 1e-3 {
                continue;
            }
            let margin = found.margins[edge as usize];
            assert_eq!(
                angle > ANGLE,
                margin > parameters.stop,
                "{edge:?} {angle} {margin}"
            );
            // Its arm about the edge, and the arm that the stop angle requires.
            let line = sub(ends[1], ends[0]);
            let normal = cross(sub(wide(cog), ends[0]), line);
            let length = (dot(normal, normal) / dot(line, line)).sqrt();
            let excess = length * (angle.sin() - ANGLE.sin()) + f64::from(parameters.stop);
            let with_force = arm(contacts, edge, cog, wide(force));
            let expected = gravity.min(with_force).min(excess);
            let error = f64::from(margin) - expected;
            assert!(
                error.abs() < 1e-5,
                "{edge:?} {contacts:?} {cog:?} {force:?}: {error}"
            );
            above += i32::from(angle > ANGLE);
            below += i32::from(angle < ANGLE);
        }
    }
    assert!(above > 500 && below > 500, "{above} {below}");
}

#[test]
fn a_robot_is_fast_from_the_speed_of_its_stop_on_and_slow_again_a_tenth_below() {
    for deduction in [0.0, 0.03] {
        let (parameters, height) = (parameters(deduction), 0.3);
        let stance = Stance::on(FLAT, [0.4, 0.0, height]);
        let critical = stopping_speed(parameters.stop, height + deduction);
        let mut criterion = Criterion::default();
        let mut stop_would_tip = |share: f32| {
            let force = [0.0, 0.0, GRAVITY];
            criterion
                .evaluate(&stance, force, share * critical, &parameters)
                .stop_would_tip
        };
        let seen = [0.99, -0.99, 1.01, 0.95, -0.91, 0.89, 0.99, -1.01].map(&mut stop_would_tip);
        assert_eq!(seen, [false, false, true, true, true, false, false, true]);
    }
}

#[test]
fn an_edge_that_is_not_there_has_no_margin_of_any_kind() {
    let mut contacts = FLAT.map(Some);
    contacts[2] = None;
    let stance = Stance::on_some(contacts, [0.3, -0.1, 0.2]);
    for speed in [0.0, 9.0] {
        let force = [0.0, 0.0, GRAVITY];
        let found = Criterion::default().evaluate(&stance, force, speed, &parameters(0.0));
        let left = Edge::Left as usize;
        assert_eq!([found.gravity[left], found.margins[left]], [NO_EDGE; 2]);
        assert_eq!(found.levers[left], [0.0; 2]);
    }
}

#[test]
fn a_small_support_is_measured_like_a_large_one_and_a_point_by_its_distance() {
    let evaluate = |contacts, cog| {
        let force = [0.0, 0.0, GRAVITY];
        let stance = Stance::on(contacts, cog);
        Criterion::default()
            .evaluate(&stance, force, 0.0, &parameters(0.0))
            .gravity
    };
    let side = 0.03;
    let small = [
        [0.0; 3],
        [side, 0.0, 0.0],
        [side, side, 0.0],
        [0.0, side, 0.0],
    ];
    for margin in evaluate(small, [0.015, 0.015, 0.01]) {
        assert!((margin - 0.015).abs() < 1e-6, "{margin}");
    }
    for (cog, distance) in [([0.3, 0.4, 0.2], 0.5), ([0.0, 0.0, 0.2], 0.0)] {
        for margin in evaluate([[0.0; 3]; 4], cog) {
            assert!((margin + distance).abs() < 1e-6, "{margin} {distance}");
        }
    }
}

fn seen(gravity: [f32; 4], levers: [[f32; 2]; 4]) -> Evaluation {
    Evaluation {
        margins: gravity,
        gravity,
        levers,
        ..Evaluation::default()
    }
}

/// After a time constant of 0.1 s, 1 - 1/e of a step is there.
#[test]
fn rates_and_speed_follow_a_step_within_a_tenth_of_a_second() {
    let (mut tracker, stance) = (Tracker::default(), Stance::default());
    let mut update = |margin: f32, speed: f32| {
        let found = seen([margin; 4], [[0.0; 2]; 4]);
        tracker.update(&stance, &found, &found.gravity, speed, 1e-3)
    };
    update(0.5, 0.0);
    let mut last = update(0.5, 0.0);
    for step in 1..=100_u16 {
        last = update(0.5 - 1e-3 * f32::from(step), 1.0);
    }
    assert!((last.speed - 0.632).abs() < 4e-3, "{last:?}");
    assert!((last.rate[0] + 0.632).abs() < 4e-3, "{last:?}");
}

#[test]
fn a_robot_whose_numbers_do_not_fit_is_not_armed() {
    let cog = [0.4, 0.0, 0.2];
    let check = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = parameters(0.0);
        change(&mut parameters);
        parameters.check(&Stance::on(FLAT, cog))
    };
    assert_eq!(check(&|_| ()), Ok(()));
    for change in [
        |parameters: &mut Parameters| parameters.trip = parameters.stop,
        |parameters: &mut Parameters| parameters.stop = parameters.caution,
        |parameters: &mut Parameters| parameters.trip = -1e-3,
    ] {
        assert!(matches!(check(&change), Err(Refusal::Levels { .. })));
    }
    // 0.2 m from the sides, less the uncertainty.
    let refused = check(&|parameters| {
        parameters.uncertainty.cog = 0.21;
    });
    let Err(Refusal::CogOutside { margin, .. }) = refused else {
        panic!("{refused:?}")
    };
    assert!((margin + 0.01).abs() < 1e-6, "{margin}");
}

/// Only the height over the support counts, not the height of the origin.
#[test]
fn the_deceleration_that_a_robot_bears_does_not_depend_on_its_origin() {
    let bearable = |lifted: f32| {
        let parameters = Parameters {
            acceleration: 1e6,
            ..parameters(0.0)
        };
        let contacts = FLAT.map(|[x, y, z]| [x, y, z + lifted]);
        match parameters.check(&Stance::on(contacts, [0.3, 0.0, 0.25 + lifted])) {
            Err(Refusal::Deceleration { bearable, .. }) => (bearable, parameters.trip),
            other => panic!("{other:?}"),
        }
    };
    for lifted in [-0.5, 0.0, 1.0] {
        let (got, trip) = bearable(lifted);
        let expected = f64::from(GRAVITY) * (0.3 - f64::from(trip)) / 0.25;
        assert!(
            (f64::from(got) - expected).abs() < 1e-3,
            "{lifted}: {got} {expected}"
        );
    }
}

#[test]
fn every_refusal_has_its_code() {
    let edge = Edge::Back;
    let refusals = [
        Refusal::Levels {
            trip: 0.0,
            stop: 0.0,
            caution: 0.0,
        },
        Refusal::NotFinite,
        Refusal::NoEdge { edge, length: 0.0 },
        Refusal::NotConvex { edge, outside: 0.0 },
        Refusal::CogOutside { edge, margin: 0.0 },
        Refusal::Deceleration {
            configured: 0.0,
            bearable: 0.0,
        },
        Refusal::NoSupport,
        Refusal::SensorAxes { checked: 0 },
    ];
    let codes = refusals.map(Refusal::code);
    assert_eq!(codes, [1, 2, 3, 4, 5, 6, 7, 8]);
}

/// Worked by hand: 100 N of weight, a centre of gravity at (0.1, 0.2, 0.3), a change of angular
/// momentum of (2, 3) N m about it, and a sideways force of 5 N.
#[test]
fn the_printed_zero_moment_point_is_that_of_the_worked_example() {
    let (cog, force): (Vector, Vector) = ([0.1, 0.2, 0.3], [0.0, 5.0, 100.0]);
    let about_origin = cross(cog, force);
    let moment = [about_origin[0] + 2.0, about_origin[1] + 3.0, 0.0];
    let found = printed(&Wrench { force, moment }, 10.0, 10.0, cog);
    let [x, y] = found.expect("a point");
    // x: (0.1 * 100 - 3) / 100; y: (2 + 0.2 * 100 - 0.3 * 5) / 100.
    assert!(
        (x - 0.07).abs() < 1e-12 && (y - 0.205).abs() < 1e-12,
        "{x} {y}"
    );
}
