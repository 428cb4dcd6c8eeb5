//! Hylos on its hillside: the loop of Besseron et al. (Fig. 7), with and without posture control. The motors here are ideal.

use core::f64::consts::{FRAC_PI_2, TAU};
use tautrack::link::Shaft;
use tautrack::robots::hylos::parameters::{
    MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN, STANCE_HEIGHT,
};
use tautrack::robots::hylos::{Controller, LEGS, Parameters, Sensed, Wish};
use tautrack::stability::tipover::Potential;
use tautrack_host_tests::plant::hylos::{Hillside, Hylos, HylosParameters, MOTORS};

const DT: f64 = 1e-3;
/// Steps from one control step to the next: 125 Hz.
const PERIOD: u32 = 8;
/// Radius of the loop, m, and the speed on it, m/s.
const RADIUS: f64 = 2.0;
const SPEED: f64 = 0.3;

/// A slope that the robot, as it stands, could just hold; the waves are too much.
const HILLSIDE: Hillside = Hillside {
    slope: 38.0 * TAU / 360.0,
    foot_y: 1.6,
    wave_height: 0.02,
    wave_length: [1.1, 1.3],
    extent: [[-4.0, 4.0], [-2.0, 6.0]],
};

/// Plant and controller, joined by ideal motors.
struct Driven {
    plant: Hylos,
    controller: Controller<f32>,
    origin: [[f64; 2]; LEGS],
    points: [[f64; 4]; LEGS],
    wheels: [f64; LEGS],
    steps: u32,
    potential: f32,
    margin: f32,
}

fn sensed(plant: &Hylos) -> Sensed<f32> {
    let truth = plant.truth();
    Sensed {
        legs: truth.legs.map(|leg| leg.map(|angle| angle as f32)),
        torques: truth.leg_torques.map(|leg| leg.map(|torque| torque as f32)),
        steering: truth.steering.map(|angle| angle as f32),
        up: truth.up.map(|value| value as f32),
        acceleration: [0.0; 3],
    }
}

impl Driven {
    fn new(hillside: &Hillside, start: [f64; 3], gain: f64) -> Self {
        let plant = Hylos::new(&HylosParameters::nominal(start), hillside, 1);
        let potential = Potential::new(gain, MARGIN_LIMIT, MARGIN_FLOOR).unwrap();
        let controller = Controller::new(Parameters::nominal(), potential, &sensed(&plant));
        let origin = plant.truth().legs;
        Self {
            points: [[0.0; 4]; LEGS],
            wheels: [0.0; LEGS],
            origin,
            controller,
            plant,
            steps: 0,
            potential: 0.0,
            margin: 0.0,
        }
    }

    /// One millisecond.
    fn step(&mut self, wish: &Wish<f32>) {
        if self.steps.is_multiple_of(PERIOD) {
            let sensed = sensed(&self.plant);
            let assessment = self.controller.step(&sensed, wish, PERIOD as f32 * 1e-3);
            (self.potential, self.margin) = (assessment.potential, assessment.margin);
        }
        let goal = self.controller.set_points();
        let mut shafts = [None; MOTORS];
        for leg in 0..LEGS {
            let places = [
                f64::from(goal.legs[leg][0]) - self.origin[leg][0],
                f64::from(goal.legs[leg][1]) - self.origin[leg][1],
                f64::from(goal.steering[leg]),
                self.wheels[leg] + f64::from(goal.wheel_rates[leg]) * DT,
            ];
            self.wheels[leg] = places[3];
            for (motor, place) in places.into_iter().enumerate() {
                // A drive interpolates between the set-points.
                let now = &mut self.points[leg][motor];
                let next = if motor == 3 {
                    place
                } else {
                    *now + (place - *now) / f64::from(PERIOD)
                };
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

    fn seconds(&self) -> f64 {
        f64::from(self.steps) * DT
    }
}

/// What a drive around the loop showed.
#[derive(Debug, Default)]
struct Loop {
    toppled_at: Option<f64>,
    turned: f64,
    least_margin: f64,
    worst_distance: f64,
    in_air: f64,
    idle_motion: f64,
}

fn drive_loop(gain: f64, log: bool) -> Loop {
    let mut driven = Driven::new(&HILLSIDE, [0.0, 0.0, 0.0], gain);
    let mut result = Loop {
        least_margin: f64::INFINITY,
        ..Loop::default()
    };
    let rest = Wish {
        forward: 0.0,
        yaw_rate: 0.0,
        clearance: None,
    };
    for _ in 0..1000 {
        driven.step(&rest);
    }
    let mut angle = -FRAC_PI_2;
    while result.turned < TAU && driven.seconds() < 90.0 {
        let truth = driven.plant.truth();
        let (x, y) = (truth.place[0], truth.place[1] - RADIUS);
        let (distance, now) = (x.hypot(y) - RADIUS, y.atan2(x));
        let moved = (now - angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        angle = now;
        result.turned += moved;
        let heading = (truth.yaw - (now + FRAC_PI_2) + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        let yaw_rate = SPEED / RADIUS - 1.2 * (heading - 0.8 * distance);
        let wish = Wish {
            forward: SPEED as f32,
            yaw_rate: yaw_rate.clamp(-0.4, 0.4) as f32,
            clearance: (gain > 0.0).then_some(STANCE_HEIGHT as f32),
        };
        driven.step(&wish);
        let truth = driven.plant.truth();
        result.least_margin = result.least_margin.min(truth.margin);
        result.worst_distance = result.worst_distance.max(distance.abs());
        result.in_air += truth.standing.iter().filter(|standing| !**standing).count() as f64 * DT;
        if log && driven.steps.is_multiple_of(1000) {
            println!(
                "{:5.1} s {:6.1} deg place {:5.2} {:5.2} off {:+.3} head {:+.2} margin {:+.3} est {:+.3} U {:.4} up {:+.2?} forces {:.0?} legs {:.2?} steer {:.2?}",
                driven.seconds(),
                result.turned.to_degrees(),
                truth.place[0],
                truth.place[1],
                distance,
                heading,
                truth.margin,
                driven.margin,
                driven.potential,
                truth.up,
                truth.wheel_forces,
                truth.legs,
                truth.steering,
            );
        }
        if truth.toppled {
            result.toppled_at = Some(driven.seconds());
            break;
        }
    }
    result
}

#[test]
fn the_loop_ends_on_the_side_without_posture_control() {
    let result = drive_loop(0.0, true);
    println!("{result:?}");
    assert!(result.toppled_at.is_some(), "{result:?}");
}

#[test]
fn posture_control_brings_it_around_the_loop() {
    let result = drive_loop(POTENTIAL_GAIN, true);
    println!("{result:?}");
    assert!(
        result.toppled_at.is_none() && result.turned >= TAU,
        "{result:?}"
    );
    assert!(result.least_margin > 0.0, "{result:?}");
}
