//! Tests Hylos' body controller without physics: on a plane that tilts, with uneven loads, and with
//! any input.

use crate::counted::{Counted, operations};
use proptest::prelude::*;
use tautrack::math::Scalar;
use tautrack::math::vector::{Vector, add, cross, dot, scale, sub};
use tautrack::robots::hylos::controller::{LEG_RATE, STEERING_RATE, WHEEL_RATE, stance};
use tautrack::robots::hylos::parameters::{
    HIP_RANGE, KNEE_RANGE, MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT,
    STEERING_RANGE,
};
use tautrack::robots::hylos::{
    Attitude, Controller, Desired, LEGS, Legs, Parameters, Posture, Potential, Sensed,
};

/// Controller on a plane with ideal legs: the mean plane of the wheels determines the platform's
/// attitude.
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

    /// Runs one control step on a plane that rises by `slope` to the left. Returns the margin, rad,
    /// and the distance of a wheel from the mean plane, m.
    fn step(&mut self, slope: f64, desired: &Desired<S>) -> [f64; 2] {
        let [a, b, c, d] = wheel_centres(&self.parameters, &self.sensed.legs);
        let across = cross(sub(a, d), sub(c, b));
        let normal = scale(1.0 / dot(across, across).sqrt(), across);
        let left = cross(normal, [1.0, 0.0, 0.0]);
        let left = scale(1.0 / dot(left, left).sqrt(), left);
        let up = add(scale(slope.sin(), left), scale(slope.cos(), normal));
        self.sensed.up = up.map(S::from_f64);
        let assessment = self
            .controller
            .step(&self.sensed, desired, S::from_f64(0.008));
        self.sensed.legs = self.controller.set_points().legs;
        self.sensed.steering = self.controller.set_points().steering;
        let off = 0.25 * dot(normal, sub(add(a, d), add(b, c)));
        [assessment.margin.to_f64(), off.abs()]
    }

    /// Runs a slope that rises from level to 41 degrees in 20 s and stays for 10 s. Returns the
    /// smallest margin and the largest distance.
    fn tilt(&mut self, desired: &Desired<S>) -> [f64; 2] {
        (0..3750).fold([f64::INFINITY, 0.0], |[least, worst], step| {
            let slope = 41f64.to_radians() * (f64::from(step) / 2500.0).min(1.0);
            let [margin, off] = self.step(slope, desired);
            [least.min(margin), worst.max(off)]
        })
    }
}

fn nothing_desired<S: Scalar>() -> Desired<S> {
    Desired {
        forward: S::ZERO,
        yaw_rate: S::ZERO,
        clearance: None,
    }
}

fn posture_control_holds_on<S: Scalar>() {
    let [without, _] = OnPlane::<S>::new(0.0).tilt(&nothing_desired());
    assert!(without < 0.0, "{without}");
    let [with, off] = OnPlane::<S>::new(POTENTIAL_GAIN).tilt(&nothing_desired());
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
    robot.step(0.6, &nothing_desired());
    robot.step(0.6, &nothing_desired());
    let before = robot.sensed;
    robot.step(0.6, &nothing_desired());
    let ahead = robot.controller.ahead(&before, 0.2);
    for _ in 0..24 {
        robot.step(0.6, &nothing_desired());
    }
    robot.step(0.6, &nothing_desired());
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
    let desired = Desired {
        forward: 0.3,
        yaw_rate: 0.1,
        clearance: None,
    };
    for step in 0..500 {
        let [margin, _] = robot.step(0.2 * f64::from(step) / 500.0, &desired);
        assert!(margin > MARGIN_LIMIT);
        assert_eq!(robot.sensed.legs, before);
    }
}

#[test]
fn the_commanded_clearance_is_taken_when_there_is_margin_to_spare() {
    let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
    let desired = Desired {
        clearance: Some(0.2),
        ..nothing_desired()
    };
    for _ in 0..1500 {
        robot.step(0.0, &desired);
    }
    for centre in wheel_centres(&robot.parameters, &robot.sensed.legs) {
        assert!((centre[2] + 0.2).abs() < 1e-3, "{centre:?}");
    }
    // On a slope the legs leave a commanded posture that would not hold.
    let [least, _] = robot.tilt(&Desired {
        clearance: Some(0.32),
        ..nothing_desired()
    });
    assert!(least > 0.05, "{least}");
}

#[test]
fn a_wheel_without_load_is_lowered_and_its_neighbours_raised() {
    let mut robot = OnPlane::<f32>::new(POTENTIAL_GAIN);
    let legs = robot.sensed.legs;
    // The diagonal from front right to rear left carries the weight, given as knee and hip torques:
    // tau = -J^T F.
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
        robot.step(0.0, &nothing_desired());
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
            let desired = Desired { forward: second[10], yaw_rate: second[11], clearance: Some(second[12]) };
            robot.controller.step(&sensed, &desired, 0.008);
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
fn a_control_step_stays_below_its_documented_cost() {
    let mut robot = OnPlane::<Counted>::new(POTENTIAL_GAIN);
    let desired = Desired {
        forward: Counted::from_f64(0.3),
        yaw_rate: Counted::from_f64(0.1),
        clearance: Some(Counted::from_f64(STANCE_HEIGHT)),
    };
    for (slope, limit) in [(0.0f64, 2200), (0.7, 2600)] {
        robot.sensed.up = [0.0, slope.sin(), slope.cos()].map(Counted::from_f64);
        let period = Counted::from_f64(0.008);
        let count = operations(|| robot.controller.step(&robot.sensed, &desired, period));
        println!("side slope {slope}: {count} operations");
        assert!(count <= limit, "{count}");
    }
}
