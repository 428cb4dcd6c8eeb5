//! Hylos' model and body controller against finite differences, hand calculation and the quasi-static slope.

#[path = "support/counted.rs"]
mod counted;
#[path = "support/random.rs"]
#[allow(dead_code)] // its states are those of B2P2
mod random;

use counted::{Counted, operations};
use proptest::prelude::*;
use random::Random;
use tautrack::math::Scalar;
use tautrack::math::vector::{Vector, add, cross, dot, scale, sub};
use tautrack::robots::hylos::body::{LEG_RATE, STEERING_RATE, WHEEL_RATE, stance};
use tautrack::robots::hylos::parameters::{
    HIP_RANGE, KNEE_RANGE, MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT,
    STEERING_RANGE,
};
use tautrack::robots::hylos::{
    Attitude, Controller, Form, LEGS, Legs, Parameters, Posture, Pull, Sensed, Trajectory, Wish,
};
use tautrack::stability::tipover::{Potential, margin};

const AT_REST: Trajectory<f64> = Trajectory {
    velocity: [0.0; 2],
    yaw_rate: 0.0,
};
const STILL: Legs<f64> = [[0.0; 2]; LEGS];

/// What a posture is made of, with everything that the world keeps in the world's axes.
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

    /// The state after a small motion of the legs, the platform following on the ground.
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
    // So high a limit that all four angles count.
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

/// The robot standing on a plane that rises to its left by `slope`, the legs in their stance.
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
        // The wheels still point ahead.
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
        // Its left has no part along the heading, and the heading is ahead.
        assert_near("left", x[1], 0.0, 1e-12);
        assert!(y[1] > 0.0);
        assert_near("handed", dot(cross(x, y), z), 1.0, 1e-12);
    }
    // Nose straight up: no heading, but a rotation.
    let upright = Attitude::from_up([1.0, 0.0, 0.0]).rotation();
    let [x, y, z] = upright;
    assert_near("handed", dot(cross(x, y), z), 1.0, 1e-12);
}

/// The controller on a plane, its legs ideal: the platform stands where the mean plane of its wheels puts it.
struct OnPlane<S> {
    parameters: Parameters<S>,
    controller: Controller<S>,
    sensed: Sensed<S>,
}

fn wheel_centres<S: Scalar>(parameters: &Parameters<S>, legs: &Legs<S>) -> [Vector<f64>; LEGS] {
    let level = Attitude::from_up([S::ZERO, S::ZERO, S::ONE]);
    let normals = [[S::ZERO, S::ZERO, S::ONE]; LEGS];
    let posture = Posture::new(parameters, legs, &[S::ZERO; LEGS], level, &normals);
    posture.wheels().map(|wheel| wheel.hub.map(Scalar::to_f64))
}

impl<S: Scalar> OnPlane<S> {
    fn new(gain: f64) -> Self {
        let parameters = Parameters::nominal();
        let sensed = Sensed {
            legs: [stance(&parameters, S::from_f64(STANCE_HEIGHT)); LEGS],
            torques: [[S::ZERO; 2]; LEGS],
            steering: [S::ZERO; LEGS],
            up: [S::ZERO, S::ZERO, S::ONE],
            acceleration: [S::ZERO; 3],
        };
        let potential = Potential::new(gain, MARGIN_LIMIT, MARGIN_FLOOR).unwrap();
        let controller = Controller::new(parameters, potential, &sensed);
        Self {
            parameters,
            controller,
            sensed,
        }
    }

    /// One control step on a plane that rises by `slope` to the left; the margin, and how far a wheel is off the mean plane, m.
    fn step(&mut self, slope: f64, wish: &Wish<S>) -> [f64; 2] {
        let [a, b, c, d] = wheel_centres(&self.parameters, &self.sensed.legs);
        let across = cross(sub(a, d), sub(c, b));
        let normal = scale(1.0 / dot(across, across).sqrt(), across);
        let left = cross(normal, [1.0, 0.0, 0.0]);
        let left = scale(1.0 / dot(left, left).sqrt(), left);
        let up = add(scale(slope.sin(), left), scale(slope.cos(), normal));
        self.sensed.up = up.map(S::from_f64);
        let assessment = self.controller.step(&self.sensed, wish, S::from_f64(0.008));
        self.sensed.legs = self.controller.set_points().legs;
        self.sensed.steering = self.controller.set_points().steering;
        let off = 0.25 * dot(normal, sub(add(a, d), add(b, c)));
        [assessment.margin.to_f64(), off.abs()]
    }

    /// A slope that rises from level to 41 degrees in 20 s and stays for 10 s: least margin and worst distance.
    fn tilt(&mut self, wish: &Wish<S>) -> [f64; 2] {
        (0..3750).fold([f64::INFINITY, 0.0], |[least, worst], step| {
            let slope = 41f64.to_radians() * (f64::from(step) / 2500.0).min(1.0);
            let [margin, off] = self.step(slope, wish);
            [least.min(margin), worst.max(off)]
        })
    }
}

fn no_wish<S: Scalar>() -> Wish<S> {
    Wish {
        forward: S::ZERO,
        yaw_rate: S::ZERO,
        clearance: None,
    }
}

fn posture_control_holds_on<S: Scalar>() {
    let [without, _] = OnPlane::<S>::new(0.0).tilt(&no_wish());
    assert!(without < 0.0, "{without}");
    let [with, off] = OnPlane::<S>::new(POTENTIAL_GAIN).tilt(&no_wish());
    println!(
        "41 degrees: margin {without:.3} without, {with:.3} with; wheels {off:.5} m off their plane"
    );
    assert!(with > 0.1 && off < 1e-3, "{with} {off}");
}

#[test]
fn posture_control_holds_the_robot_on_a_slope_that_tips_its_stance() {
    posture_control_holds_on::<f64>();
    posture_control_holds_on::<f32>();
}

#[test]
fn the_posture_ahead_is_the_one_that_is_reached() {
    let mut robot = OnPlane::<f64>::new(POTENTIAL_GAIN);
    robot.step(0.6, &no_wish());
    robot.step(0.6, &no_wish());
    let before = robot.sensed;
    robot.step(0.6, &no_wish());
    let ahead = robot.controller.ahead(&before, 0.2);
    for _ in 0..24 {
        robot.step(0.6, &no_wish());
    }
    robot.step(0.6, &no_wish());
    let change = sub(robot.sensed.up, before.up);
    let missed = sub(robot.sensed.up, ahead.up);
    println!("up turned by {change:?}, foreseen but for {missed:?}");
    assert!(dot(change, change) > 1e-4);
    assert!(dot(missed, missed) < 0.25 * dot(change, change));
}

#[test]
fn no_leg_moves_while_the_margin_is_above_its_limit() {
    let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
    let before = robot.sensed.legs;
    let wish = Wish {
        forward: 0.3,
        yaw_rate: 0.1,
        clearance: None,
    };
    for step in 0..500 {
        let [margin, _] = robot.step(0.2 * f64::from(step) / 500.0, &wish);
        assert!(margin > MARGIN_LIMIT);
        assert_eq!(robot.sensed.legs, before);
    }
}

#[test]
fn the_wished_clearance_is_taken_when_there_is_margin_to_spare() {
    let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
    let wish = Wish {
        clearance: Some(0.2),
        ..no_wish()
    };
    for _ in 0..1500 {
        robot.step(0.0, &wish);
    }
    for centre in wheel_centres(&robot.parameters, &robot.sensed.legs) {
        assert_near("clearance", -centre[2], 0.2, 1e-3);
    }
    // And left again where it does not hold.
    let [least, _] = robot.tilt(&Wish {
        clearance: Some(0.32),
        ..no_wish()
    });
    assert!(least > 0.05, "{least}");
}

#[test]
fn a_wheel_without_load_is_lowered_and_its_neighbours_raised() {
    let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
    let legs = robot.sensed.legs;
    // Weight on the diagonal from front right to rear left, as knee and hip torques: tau = -J^T F.
    let centres = wheel_centres(&robot.parameters, &legs);
    for leg in 0..LEGS {
        let load = if leg == 1 || leg == 2 { 122.0 } else { 0.0 };
        for joint in 0..2 {
            let mut moved = legs;
            moved[leg][joint] += 1e-3;
            let lift = wheel_centres(&robot.parameters, &moved)[leg][2] - centres[leg][2];
            robot.sensed.torques[leg][joint] = (-load * lift / 1e-3) as f32;
        }
    }
    for _ in 0..50 {
        robot.step(0.0, &no_wish());
    }
    let after = wheel_centres(&robot.parameters, &robot.sensed.legs);
    for (leg, (after, before)) in after.iter().zip(&centres).enumerate() {
        let lift = after[2] - before[2];
        if leg == 1 || leg == 2 {
            assert!(lift > 1e-3, "{leg}: {lift}");
        } else {
            assert!(lift < -1e-3, "{leg}: {lift}");
        }
    }
}

fn anything() -> impl Strategy<Value = f32> {
    prop_oneof![
        -3.0f32..3.0,
        any::<f32>(),
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(0.0f32)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn set_points_stay_within_their_limits_whatever_comes_in(
        steps in prop::collection::vec((prop::array::uniform16(anything()), prop::array::uniform16(anything())), 1..6)
    ) {
        let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
        for (first, second) in steps {
            let pairs = |values: &[f32]| core::array::from_fn(|leg| [values[2 * leg], values[2 * leg + 1]]);
            let sensed = Sensed {
                legs: pairs(&first[..8]),
                torques: pairs(&first[8..]),
                steering: core::array::from_fn(|leg| second[leg]),
                up: [second[4], second[5], second[6]],
                acceleration: [second[7], second[8], second[9]],
            };
            let wish = Wish { forward: second[10], yaw_rate: second[11], clearance: Some(second[12]) };
            robot.controller.step(&sensed, &wish, 0.008);
            let points = robot.controller.set_points();
            for leg in 0..LEGS {
                for (joint, [low, high]) in [HIP_RANGE, KNEE_RANGE].into_iter().enumerate() {
                    prop_assert!((low as f32..=high as f32).contains(&points.legs[leg][joint]));
                    prop_assert!(points.leg_rates[leg][joint].abs() <= LEG_RATE as f32);
                }
                prop_assert!((STEERING_RANGE[0] as f32..=STEERING_RANGE[1] as f32).contains(&points.steering[leg]));
                prop_assert!(points.steering_rates[leg].abs() <= STEERING_RATE as f32);
                prop_assert!(points.wheel_rates[leg].abs() <= WHEEL_RATE as f32);
            }
        }
    }
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
fn a_control_step_stays_below_its_documented_cost() {
    let mut robot = OnPlane::<Counted>::new(POTENTIAL_GAIN);
    let wish = Wish {
        forward: Counted::from_f64(0.3),
        yaw_rate: Counted::from_f64(0.1),
        clearance: Some(Counted::from_f64(STANCE_HEIGHT)),
    };
    for (slope, limit) in [(0.0f64, 2200), (0.7, 2600)] {
        robot.sensed.up = [0.0, slope.sin(), slope.cos()].map(Counted::from_f64);
        let period = Counted::from_f64(0.008);
        let count = operations(|| robot.controller.step(&robot.sensed, &wish, period));
        println!("side slope {slope}: {count} operations");
        assert!(count <= limit, "{count}");
    }
}
