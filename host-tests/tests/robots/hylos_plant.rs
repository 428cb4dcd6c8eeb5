//! Tests of Hylos' plant, against hand calculation and on its hillside: the loop of Besseron et al.
//! (Fig. 7) with and without posture control. The motors are ideal.

use crate::random::Random;
use crate::stamp;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use tautrack::link::Shaft;
use tautrack::robots::hylos::parameters::{
    MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT,
};
use tautrack::robots::hylos::{
    Assessment, Controller, Desired, LEGS, Parameters, Potential, Sensed,
};
use tautrack_host_tests::robots::hylos::plant::{Hillside, Hylos, HylosParameters, MOTORS};
use tautrack_host_tests::world::Plant;

const DT: f64 = 1e-3;
const WEIGHT: f64 = 25.0 * 9.81;
/// Number of steps per control step: 125 Hz.
const PERIOD: u32 = 8;
/// Radius of the loop, m, and speed on it, m/s.
const RADIUS: f64 = 2.0;
const SPEED: f64 = 0.3;

/// Slope on which the robot, without posture control, topples when it drives across. The loop goes
/// up, across and down.
const HILLSIDE: Hillside = Hillside {
    slope: 41.0 * PI / 180.0,
    foot_y: 1.6,
    wave_height: 0.02,
    wave_length: [1.1, 1.3],
    extent: [[-4.0, 4.0], [-2.0, 6.0]],
};
/// The same waves on level ground.
const WAVES: Hillside = Hillside {
    slope: 0.0,
    ..HILLSIDE
};
const LEVEL: Hillside = Hillside {
    wave_height: 0.0,
    ..WAVES
};

const REST: Desired<f32> = Desired {
    forward: 0.0,
    yaw_rate: 0.0,
    clearance: None,
};

/// Quality of the sensors between plant and controller.
#[derive(Clone, Copy, PartialEq)]
enum Sensors {
    Ideal,
    /// The torques of the legs are not known.
    NoLoads,
    /// Readings one control step late; inclination with an error of a degree and noise; torques too
    /// small, with friction and noise.
    Coarse,
}

/// Plant and controller, connected by ideal motors.
struct Driven {
    plant: Hylos,
    controller: Controller<f32>,
    assessment: Option<Assessment<f32>>,
    sensors: Sensors,
    /// Readings of the previous control step.
    late: Sensed<f32>,
    random: Random,
    origin: [[f64; 2]; LEGS],
    /// Angles of the shafts since power-up, rad.
    places: [[f64; 4]; LEGS],
    steps: u32,
}

impl Driven {
    fn new(hillside: &Hillside, gain: f64) -> Self {
        let plant = Hylos::new(&HylosParameters::nominal([0.0; 3]), hillside, 1);
        let potential = Potential::new(gain, MARGIN_LIMIT, MARGIN_FLOOR).unwrap();
        let sensed = sensed(&plant);
        Self {
            controller: Controller::new(Parameters::nominal(), potential, &sensed),
            assessment: None,
            sensors: Sensors::Ideal,
            late: sensed,
            random: Random(7),
            origin: plant.detail().legs,
            places: [[0.0; 4]; LEGS],
            plant,
            steps: 0,
        }
    }

    /// Runs one millisecond.
    fn step(&mut self, desired: &Desired<f32>) {
        if self.steps.is_multiple_of(PERIOD) {
            let sensed = self.sense();
            let period = PERIOD as f32 * DT as f32;
            self.assessment = Some(self.controller.step(&sensed, desired, period));
        }
        let goal = self.controller.set_points();
        let mut shafts = [None; MOTORS];
        for leg in 0..LEGS {
            let [hip, knee, steering, wheel] = self.places[leg];
            // Drives interpolate between the position set-points.
            let towards = |now: f64, point: f32, origin: f64| {
                now + (f64::from(point) - origin - now) / f64::from(PERIOD)
            };
            let next = [
                towards(hip, goal.legs[leg][0], self.origin[leg][0]),
                towards(knee, goal.legs[leg][1], self.origin[leg][1]),
                towards(steering, goal.steering[leg], 0.0),
                wheel + f64::from(goal.wheel_rates[leg]) * DT,
            ];
            for (motor, (now, next)) in self.places[leg].iter_mut().zip(next).enumerate() {
                shafts[4 * leg + motor] = Some(Shaft {
                    position: (next / TAU * 4_294_967_296.0) as i64,
                    velocity: ((next - *now) / DT) as f32,
                });
                *now = next;
            }
        }
        self.plant.step(&shafts);
        self.steps += 1;
    }

    fn sense(&mut self) -> Sensed<f32> {
        let mut now = sensed(&self.plant);
        match self.sensors {
            Sensors::Ideal => now,
            Sensors::NoLoads => {
                now.torques = Default::default();
                now
            }
            Sensors::Coarse => {
                let mut noise = |size: f64| (size * self.random.next()) as f32;
                let rates = self.controller.set_points().leg_rates;
                for (torque, rate) in now
                    .torques
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(rates.as_flattened())
                {
                    let friction = if rate.abs() > 0.01 {
                        rate.signum()
                    } else {
                        0.0
                    };
                    *torque = 0.85 * *torque + friction + noise(1.0);
                }
                let [x, y, z] = now.up;
                let off = 1f32.to_radians();
                let tilted = [x + off + noise(0.005), y - off + noise(0.005), z];
                let length = tilted.iter().map(|value| value * value).sum::<f32>().sqrt();
                now.up = tilted.map(|value| value / length);
                std::mem::replace(&mut self.late, now)
            }
        }
    }

    fn rest(&mut self, seconds: f64) {
        for _ in 0..(seconds / DT).round() as u32 {
            self.step(&REST);
        }
    }

    fn seconds(&self) -> f64 {
        f64::from(self.steps) * DT
    }
}

fn sensed(plant: &Hylos) -> Sensed<f32> {
    let truth = plant.detail();
    Sensed {
        legs: truth.legs.map(|leg| leg.map(|angle| angle as f32)),
        torques: truth.leg_torques.map(|leg| leg.map(|torque| torque as f32)),
        steering: truth.steering.map(|angle| angle as f32),
        up: truth.up.map(|value| value as f32),
        acceleration: [0.0; 3],
    }
}

/// Result of a drive around the loop.
#[derive(Debug, Default)]
struct Loop {
    toppled_at_s: Option<f64>,
    turned: f64,
    least_margin: f64,
    /// Maximum distance from the loop, m.
    astray: f64,
    /// Maximum distance of a wheel from the ground, m.
    gap: f64,
    /// Time during which the stability potential was not zero, s.
    corrected_s: f64,
    /// Minimum margin while it was zero, rad.
    least_margin_uncorrected: f64,
    /// Maximum difference between the controller's margin and the true one, rad.
    misjudged: f64,
}

fn half_turn(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Drives around the loop once, counter-clockwise from its lowest point, or until the robot
/// topples.
fn drive_loop(gain: f64, sensors: Sensors) -> Loop {
    let mut driven = Driven::new(&HILLSIDE, gain);
    driven.sensors = sensors;
    let mut result = Loop {
        least_margin: f64::INFINITY,
        least_margin_uncorrected: f64::INFINITY,
        ..Loop::default()
    };
    driven.rest(1.0);
    let mut angle = -FRAC_PI_2;
    while result.turned < TAU && driven.seconds() < 90.0 {
        let truth = driven.plant.detail();
        let (x, y) = (truth.place[0], truth.place[1] - RADIUS);
        let (astray, now) = (x.hypot(y) - RADIUS, y.atan2(x));
        result.turned += half_turn(now - angle);
        angle = now;
        let off_heading = half_turn(driven.plant.truth().yaw - now - FRAC_PI_2);
        let yaw_rate = SPEED / RADIUS - 1.2 * (off_heading - 0.8 * astray);
        driven.step(&Desired {
            forward: SPEED as f32,
            yaw_rate: yaw_rate.clamp(-0.4, 0.4) as f32,
            clearance: (gain > 0.0).then_some(STANCE_HEIGHT as f32),
        });

        let truth = driven.plant.detail();
        let assessment = driven.assessment.unwrap();
        result.astray = result.astray.max(astray.abs());
        if driven.plant.truth().toppled {
            result.toppled_at_s = Some(driven.seconds());
            break;
        }
        let judged = f64::from(assessment.margin);
        result.least_margin = result.least_margin.min(truth.margin);
        result.misjudged = result.misjudged.max((judged - truth.margin).abs());
        if assessment.potential > 0.0 {
            result.corrected_s += DT;
        } else {
            result.least_margin_uncorrected = result.least_margin_uncorrected.min(judged);
        }
        for contact in truth.contacts {
            let below = HILLSIDE.height([contact[0], contact[1]]);
            let normal = HILLSIDE.normal([contact[0], contact[1]]);
            result.gap = result.gap.max((contact[2] - below) * normal[2]);
        }
    }
    println!("{gain}: {result:?}");
    result
}

#[test]
fn without_posture_control_the_robot_tips_over_on_the_loop() {
    let Some(_stamp) = stamp("without_posture_control_the_robot_tips_over_on_the_loop") else {
        return;
    };
    let result = drive_loop(0.0, Sensors::Ideal);
    assert!(result.toppled_at_s.is_some() && result.turned < 0.75 * TAU);
    assert!(result.least_margin < 0.0);
}

#[test]
fn posture_control_brings_the_robot_around_the_loop() {
    let Some(_stamp) = stamp("posture_control_brings_the_robot_around_the_loop") else {
        return;
    };
    let result = drive_loop(POTENTIAL_GAIN, Sensors::Ideal);
    assert!(result.toppled_at_s.is_none() && result.turned >= TAU);
    assert!(result.least_margin > 0.05 && result.astray < 0.25);
    assert!(result.gap < 0.02);
    // The posture is corrected only where it is necessary.
    assert!(result.corrected_s > 3.0 && result.corrected_s < 25.0);
    assert!(result.least_margin_uncorrected >= MARGIN_LIMIT - 1e-6);
    assert!(result.misjudged < 0.08);
}

#[test]
fn coarse_sensors_suffice_for_the_loop() {
    let Some(_stamp) = stamp("coarse_sensors_suffice_for_the_loop") else {
        return;
    };
    let result = drive_loop(POTENTIAL_GAIN, Sensors::Coarse);
    assert!(result.toppled_at_s.is_none() && result.turned >= TAU);
    assert!(result.least_margin > 0.05 && result.astray < 0.25 && result.gap < 0.03);
}

#[test]
fn at_rest_the_wheels_carry_the_weight_and_the_legs_hold_it() {
    let mut driven = Driven::new(&LEVEL, POTENTIAL_GAIN);
    driven.rest(1.5);
    let truth = driven.plant.detail();
    let carried: f64 = truth.wheel_forces.iter().sum();
    assert!((carried - WEIGHT).abs() < 0.5, "{carried}");
    let parameters = HylosParameters::nominal([0.0; 3]);
    for (leg, (angles, torques)) in truth.legs.iter().zip(truth.leg_torques).enumerate() {
        // The centre of mass is in the middle, so each leg holds a quarter of the weight, minus the
        // weight of its wheel and carrier.
        let load = WEIGHT / 4.0 - 2.0 * 9.81;
        assert!((truth.wheel_forces[leg] - WEIGHT / 4.0).abs() < 0.5);
        for joint in 0..2 {
            let mut moved = *angles;
            moved[joint] += 1e-6;
            let sinking = (parameters.reach(moved)[1] - parameters.reach(*angles)[1]) / 1e-6;
            let want = load * sinking;
            let got = torques[joint];
            assert!(
                (got - want).abs() < 0.3,
                "leg {leg} joint {joint}: {got} {want}"
            );
            let felt = f64::from(driven.plant.sensors(4 * leg + joint).shaft_torque);
            assert!((felt - got).abs() < 1e-4);
        }
    }
    assert!((truth.margin - 0.685).abs() < 0.02, "{}", truth.margin);
}

#[test]
fn the_sketch_goes_through_the_wheels_on_the_ground() {
    let mut driven = Driven::new(&WAVES, POTENTIAL_GAIN);
    driven.rest(1.0);
    let (sketch, truth) = (driven.plant.sketch(), driven.plant.truth());
    assert_eq!((sketch.circles.len(), truth.points.len()), (LEGS, 3 * LEGS));
    for (leg, (centre, radius)) in sketch.circles.iter().enumerate() {
        let [x, y, z] = truth.points[*centre];
        let height = WAVES.height([x, y]);
        assert!(
            (z - radius - height).abs() < 5e-3,
            "leg {leg}: {z} {height}"
        );
    }
    for line in &sketch.lines {
        assert!(line.iter().all(|point| *point < truth.points.len()));
    }
    assert_eq!(
        truth.channels["front_right_hip_rad"],
        driven.plant.detail().legs[1][0]
    );
    assert!(truth.channels["tip_over_margin_rad"] > MARGIN_LIMIT);
}

#[test]
fn loads_from_the_leg_motors_keep_the_wheels_on_waves() {
    let Some(_stamp) = stamp("loads_from_the_leg_motors_keep_the_wheels_on_waves") else {
        return;
    };
    let mean_imbalance = |sensors| {
        let mut driven = Driven::new(&WAVES, POTENTIAL_GAIN);
        driven.sensors = sensors;
        driven.rest(1.0);
        let desired = Desired {
            forward: 0.2,
            ..REST
        };
        let mut warp = 0.0;
        for _ in 0..10_000 {
            driven.step(&desired);
            let [a, b, c, d] = driven.plant.detail().wheel_forces;
            warp += (a - b - c + d).abs() / WEIGHT / 10_000.0;
        }
        warp
    };
    let (known, unknown) = (
        mean_imbalance(Sensors::Ideal),
        mean_imbalance(Sensors::NoLoads),
    );
    println!("share of the weight on one diagonal: {known:.3} with loads, {unknown:.3} without");
    assert!(known < 0.3 && known < 0.5 * unknown);
}

#[test]
fn a_robot_without_any_node_stands_on_its_locked_legs() {
    let mut driven = Driven::new(&LEVEL, POTENTIAL_GAIN);
    driven.rest(1.0);
    let before = driven.plant.detail().clone();
    for _ in 0..2000 {
        driven.plant.step(&[None; MOTORS]);
    }
    let after = driven.plant.detail().clone();
    assert!((after.place[2] - before.place[2]).abs() < 2e-3);
    assert_eq!(driven.plant.sensors(0).shaft_torque, 0.0);
    // Nodes that restart count from zero; the robot must not jump.
    let shaft = Some(Shaft::default());
    for _ in 0..500 {
        driven.plant.step(&[shaft; MOTORS]);
    }
    let again = driven.plant.detail();
    assert!((again.place[2] - after.place[2]).abs() < 2e-3);
}

#[test]
fn the_same_run_has_the_same_bits() {
    let bits = || {
        let mut driven = Driven::new(&HILLSIDE, POTENTIAL_GAIN);
        let desired = Desired {
            forward: 0.3,
            yaw_rate: 0.15,
            clearance: Some(0.25),
        };
        let mut bits = Vec::new();
        for _ in 0..3000 {
            driven.step(&desired);
        }
        driven
            .plant
            .truth_bits(&mut |bytes| bits.extend_from_slice(bytes));
        bits
    };
    assert_eq!(bits(), bits());
}
