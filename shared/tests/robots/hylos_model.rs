//! Tests Hylos' model against finite differences and hand calculations.

use crate::random::Random;
use tautrack::math::vector::{Vector, add, cross, dot, scale};
use tautrack::robots::hylos::attitude::up_from_tilt;
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::parameters::{
    MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT,
};
use tautrack::robots::hylos::{
    Attitude, Form, LEGS, Legs, Parameters, Posture, Potential, Pull, Trajectory,
};
use tautrack::stability::tipover::margin;

const AT_REST: Trajectory<f64> = Trajectory {
    velocity: [0.0; 2],
    yaw_rate: 0.0,
};
const STILL: Legs<f64> = [[0.0; 2]; LEGS];

/// State from which a posture is made. Normals, force and moment are in the world's axes, because
/// they stay constant in the world.
#[derive(Clone, Copy)]
struct State {
    legs: Legs<f64>,
    steering: [f64; LEGS],
    angles: [f64; 3],
    normals: [Vector<f64>; LEGS],
    force: Vector<f64>,
    moment: Vector<f64>,
}

impl State {
    fn random(random: &mut Random) -> Self {
        let mut around = |middle: f64, width: f64| middle + width * random.next();
        let legs = [(); LEGS].map(|()| [around(0.5, 0.4), around(1.1, 0.4)]);
        let steering = [(); LEGS].map(|()| around(0.0, 0.4));
        let angles = [around(0.0, 0.5), around(0.0, 0.4), around(0.0, 3.0)];
        let normals = [(); LEGS].map(|()| {
            let normal = [around(0.0, 0.2), around(0.0, 0.2), 1.0];
            scale(1.0 / dot(normal, normal).sqrt(), normal)
        });
        let force = [around(0.0, 30.0), around(0.0, 30.0), around(-245.0, 30.0)];
        let moment = [(); 3].map(|()| around(0.0, 5.0));
        Self {
            legs,
            steering,
            angles,
            normals,
            force,
            moment,
        }
    }

    fn posture<'a>(&self, parameters: &'a Parameters<f64>) -> Posture<'a, f64> {
        let attitude = Attitude::from_angles(self.angles);
        let normals = self.normals.map(|normal| attitude.into_platform(normal));
        Posture::new(parameters, &self.legs, &self.steering, attitude, &normals)
    }

    fn pull(&self) -> Pull<f64> {
        let attitude = Attitude::from_angles(self.angles);
        Pull {
            force: attitude.into_platform(self.force),
            moment: attitude.into_platform(self.moment),
        }
    }

    fn tip_over(&self, parameters: &Parameters<f64>) -> [f64; LEGS] {
        self.posture(parameters).tip_over_angles(&self.pull())
    }

    /// State after a small motion of the legs, with the platform following on the ground.
    fn followed(&self, parameters: &Parameters<f64>, change: &Legs<f64>) -> Self {
        let [_, roll, pitch] = self
            .posture(parameters)
            .motion(&AT_REST, change, Form::Full)
            .posture;
        let mut next = *self;
        next.angles = add(self.angles, [roll, pitch, 0.0]);
        for (leg, change) in next.legs.iter_mut().zip(change) {
            leg[0] += change[0];
            leg[1] += change[1];
        }
        next
    }
}

fn one_joint(joint: usize, step: f64) -> Legs<f64> {
    let mut change = STILL;
    change.as_flattened_mut()[joint] = step;
    change
}

fn assert_near(what: &str, got: f64, want: f64, tolerance: f64) {
    let difference = (got - want).abs();
    assert!(difference <= tolerance, "{what}: {got} is not {want}");
}

#[test]
fn the_gradient_is_that_of_finite_differences() {
    let parameters = Parameters::nominal();
    // The limit is so high that all four angles count.
    let potential = Potential::new(0.004, 1.6, 0.02).unwrap();
    let mut random = Random(1);
    let step = 1e-6;
    for case in 0..200 {
        let state = State::random(&mut random);
        let total = |state: &State| potential.total(&state.tip_over(&parameters));
        let difference =
            |ahead: State, behind: State| (total(&ahead) - total(&behind)) / (2.0 * step);
        let tip_over = state.tip_over(&parameters);
        let gradient = state
            .posture(&parameters)
            .gradient(&potential, &state.pull(), &tip_over);
        let scale = 1.0
            + gradient
                .partial
                .as_flattened()
                .iter()
                .chain(&gradient.attitude)
                .fold(0.0f64, |all, value| all.max(value.abs()));
        let tolerance = 1e-6 * scale;
        for joint in 0..2 * LEGS {
            let moved = |step| {
                let mut moved = state;
                moved.legs.as_flattened_mut()[joint] += step;
                moved
            };
            let name = format!("case {case} joint {joint}");
            let partial = difference(moved(step), moved(-step));
            let got = gradient.partial.as_flattened()[joint];
            assert_near(&name, got, partial, tolerance);
            let followed = |step| state.followed(&parameters, &one_joint(joint, step));
            let following = difference(followed(step), followed(-step));
            let got = gradient.total.as_flattened()[joint];
            assert_near(&name, got, following, tolerance);
        }
        for angle in 0..2 {
            let turned = |step| {
                let mut turned = state;
                turned.angles[angle] += step;
                turned
            };
            let want = difference(turned(step), turned(-step));
            let name = format!("case {case} angle {angle}");
            assert_near(&name, gradient.attitude[1 + angle], want, tolerance);
        }
    }
}

#[test]
fn minus_the_total_gradient_raises_the_margin_and_plus_lowers_it() {
    let parameters = Parameters::nominal();
    let potential = Potential::new(POTENTIAL_GAIN, MARGIN_LIMIT, MARGIN_FLOOR).unwrap();
    let mut random = Random(2);
    let mut cases = 0;
    while cases < 200 {
        let state = State::random(&mut random);
        let before = state.tip_over(&parameters);
        if !(margin(&before) < MARGIN_LIMIT) {
            continue;
        }
        cases += 1;
        let gradient = state
            .posture(&parameters)
            .gradient(&potential, &state.pull(), &before);
        let largest = gradient
            .total
            .as_flattened()
            .iter()
            .fold(0.0f64, |all, value| all.max(value.abs()));
        let after = |sign: f64| {
            let change = gradient
                .total
                .map(|leg| leg.map(|value| sign * 1e-5 * value / largest));
            let followed = state.followed(&parameters, &change);
            let tip_over = followed.tip_over(&parameters);
            (margin(&tip_over), potential.total(&tip_over))
        };
        let (down, up) = (after(-1.0), after(1.0));
        assert!(down.1 < potential.total(&before), "case {cases}");
        assert!(up.1 > potential.total(&before), "case {cases}");
        assert!(
            down.0 > margin(&before) && up.0 < margin(&before),
            "case {cases}: {before:?}"
        );
    }
}

#[test]
fn above_the_limit_the_gradient_is_zero() {
    let parameters = Parameters::nominal();
    let potential = Potential::new(POTENTIAL_GAIN, MARGIN_LIMIT, MARGIN_FLOOR).unwrap();
    let mut random = Random(3);
    let mut cases = 0;
    while cases < 50 {
        let state = State::random(&mut random);
        let tip_over = state.tip_over(&parameters);
        if margin(&tip_over) > MARGIN_LIMIT {
            cases += 1;
            let posture = state.posture(&parameters);
            let gradient = posture.gradient(&potential, &state.pull(), &tip_over);
            assert_eq!((gradient.total, gradient.attitude), (STILL, [0.0; 3]));
        }
    }
}

/// Robot in its nominal stance with this attitude, on a plane parallel to its platform.
fn standing(parameters: &Parameters<f64>, attitude: Attitude<f64>) -> Posture<'_, f64> {
    let legs = [stance(parameters, STANCE_HEIGHT); LEGS];
    let normals = [[0.0, 0.0, 1.0]; LEGS];
    Posture::new(parameters, &legs, &[0.0; LEGS], attitude, &normals)
}

#[test]
fn wheels_turn_and_steer_around_one_centre() {
    let parameters = Parameters::nominal();
    let posture = standing(&parameters, Attitude::from_angles([0.0; 3]));
    let (speed, yaw_rate) = (0.3, 0.2);
    let trajectory = Trajectory {
        velocity: [speed, 0.0],
        yaw_rate,
    };
    let motion = posture.motion(&trajectory, &STILL, Form::Full);
    assert!(motion.posture.iter().all(|rate| rate.abs() < 1e-12));
    for (leg, wheel) in posture.wheels().iter().enumerate() {
        let [x, y, _] = wheel.contact;
        let (forward, left) = (speed - yaw_rate * y, yaw_rate * x);
        let angle = motion.steering[leg].unwrap();
        assert_near("steering", angle, left.atan2(forward), 1e-12);
        // The rolling speeds are those of wheels that still point ahead.
        assert_near("rolling", motion.wheels[leg], forward / 0.075, 1e-10);
    }
    let backwards = Trajectory {
        velocity: [-speed, 0.0],
        yaw_rate: -yaw_rate,
    };
    let back = posture.motion(&backwards, &STILL, Form::Full);
    assert_eq!(
        back.steering.map(|angle| (angle.unwrap() * 1e9).round()),
        motion.steering.map(|angle| (angle.unwrap() * 1e9).round())
    );
}

#[test]
fn uphill_the_full_form_climbs_and_the_printed_one_does_not() {
    let parameters = Parameters::nominal();
    let slope = 0.6f64;
    let posture = standing(&parameters, Attitude::from_angles([0.0, -slope, 0.0]));
    let trajectory = Trajectory {
        velocity: [0.2, 0.0],
        yaw_rate: 0.0,
    };
    let full = posture.motion(&trajectory, &STILL, Form::Full);
    assert_near("climb", full.posture[0], 0.2 * slope.tan(), 1e-12);
    for speed in full.wheels {
        assert_near("wheel", speed, 0.2 / slope.cos() / 0.075, 1e-10);
    }
    let printed = posture.motion(&trajectory, &STILL, Form::Printed);
    assert_near("printed", printed.posture[0], 0.0, 1e-12);
}

#[test]
fn attitude_from_up_is_that_of_the_angles_along_the_heading() {
    let mut random = Random(4);
    for _ in 0..1000 {
        let [roll, pitch] = [1.5 * random.next(), 1.5 * random.next()];
        let up = Attitude::from_angles([roll, pitch, 3.0 * random.next()]).up();
        let [x, y, z] = Attitude::from_up(up).rotation();
        for (got, want) in z.iter().zip(&up) {
            assert_near("up", *got, *want, 1e-12);
        }
        // The platform's left has no component along the heading, and it points to the left of the
        // heading.
        assert_near("left", x[1], 0.0, 1e-12);
        assert!(y[1] > 0.0);
        assert_near("handed", dot(cross(x, y), z), 1.0, 1e-12);
    }
    // With the nose straight up there is no heading, but the result is still a rotation.
    let upright = Attitude::from_up([1.0, 0.0, 0.0]).rotation();
    let [x, y, z] = upright;
    assert_near("handed", dot(cross(x, y), z), 1.0, 1e-12);
}

#[test]
fn singular_postures_leave_the_motion_bounded() {
    let parameters = Parameters::<f64>::nominal();
    let trajectory = Trajectory {
        velocity: [0.3, 0.1],
        yaw_rate: 0.2,
    };
    let rates = [[0.5, -0.3], [-0.5, 0.2], [0.1, 0.4], [0.3, 0.3]];
    for up in [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, -1.0],
    ] {
        for normal in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
            for leg in [[0.0, 0.0], [0.5, 1.1], [0.3, core::f64::consts::PI]] {
                let posture = Posture::new(
                    &parameters,
                    &[leg; LEGS],
                    &[0.0; LEGS],
                    Attitude::from_up(up),
                    &[normal; LEGS],
                );
                let motion = posture.motion(&trajectory, &rates, Form::Full);
                for value in motion.posture.iter().chain(&motion.wheels) {
                    assert!(value.abs() < 1e3, "{up:?} {normal:?} {leg:?}: {motion:?}");
                }
            }
        }
    }
}

#[test]
fn up_by_the_guards_attitude_is_up() {
    use tautrack::math::sin_cos;
    for inclination in [[0.0, 0.0], [0.5, 0.0], [0.0, 0.4], [-0.6, 0.3], [0.3, -0.7]] {
        let mut attitude = tautrack::estimate::attitude::Attitude::default();
        let sensors = tautrack::sensors::BodySensors {
            inclination,
            ..Default::default()
        };
        assert!(attitude.update(&sensors, 0.008));
        let up = up_from_tilt(sin_cos(attitude.pitch()), sin_cos(attitude.roll()));
        for (got, want) in attitude.level(up).iter().zip([0.0, 0.0, 1.0]) {
            assert!((got - want).abs() < 1e-6, "{inclination:?}: {up:?}");
        }
        // The level axes of both attitudes are the same.
        let frame = Attitude::from_up(up);
        for place in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            for (row, want) in frame.rotation().iter().zip(attitude.level(place)) {
                assert!((dot(*row, place) - want).abs() < 1e-6, "{inclination:?}");
            }
        }
    }
}
