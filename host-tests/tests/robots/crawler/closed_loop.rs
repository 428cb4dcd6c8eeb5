//! Tests of the crawler's body controller on the plant: speed on a slope, arcs, lines and stops.

use crate::crawler::driven::{DT, Driven, slope};
use crate::stamp;
use core::f64::consts::{PI, TAU};
use tautrack::estimate::attitude::pitch_and_roll;
use tautrack::robots::crawler::{
    BodyVelocity, Configuration, Controller, Observation, parameters as model,
};
use tautrack_host_tests::robots::crawler::plant::{CrawlerParameters, Profile, Soil};
use tautrack_host_tests::world::Plant;

/// Period of SYNC and of the body controller, ms.
const SYNC: usize = 4;

/// Controller on the plant, called at every SYNC. It gets the attitude from the plant's noisy
/// sensors and the true heading.
struct Controlled {
    driven: Driven,
    controller: Controller,
    sprockets: [f32; 2],
    measures_speed: bool,
    milliseconds: usize,
}

impl Controlled {
    fn new(soil: Soil, profile: &Profile, compensates_slip: bool, measures_speed: bool) -> Self {
        let p = CrawlerParameters {
            soil,
            ..CrawlerParameters::nominal()
        };
        let configuration = Configuration {
            dimensions: model::DIMENSIONS,
            body: model::MASSES,
            ground: model::GROUND,
            compensates_slip,
            sprocket_limit: 20.0,
        };
        Self {
            driven: Driven::new(&p, profile),
            controller: Controller::new(&configuration).unwrap(),
            sprockets: [0.0; 2],
            measures_speed,
            milliseconds: 0,
        }
    }

    /// Runs one millisecond with this commanded motion.
    fn step(&mut self, forward: f32, yaw_rate: f32) {
        if self.milliseconds.is_multiple_of(SYNC) {
            let plant = &self.driven.plant;
            let [pitch, roll] = pitch_and_roll(plant.body_sensors().tilt_force);
            let observation = Observation {
                sprockets: self.driven.speeds.map(|speed| speed as f32),
                heading: plant.truth().yaw as f32,
                pitch,
                roll,
                measured_speed: self
                    .measures_speed
                    .then_some(plant.speed_over_ground() as f32),
            };
            let period = SYNC as f32 * 1e-3;
            self.controller.observe(&observation, period);
            let asked = BodyVelocity { forward, yaw_rate };
            self.sprockets = self.controller.command(asked, period).sprockets;
        }
        self.milliseconds += 1;
        let radius = self.driven.radius;
        self.driven
            .step(self.sprockets.map(|rate| f64::from(rate) * radius));
    }

    /// Mean error of the speed over the last 5 of 25 s at 0.15 m/s, as a fraction of this speed.
    fn speed_error(mut self) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for millisecond in 0..25_000 {
            self.step(0.15, 0.0);
            if millisecond >= 20_000 {
                sum += self.driven.plant.speed_over_ground();
                count += 1;
            }
        }
        sum / f64::from(count) / 0.15 - 1.0
    }
}

#[test]
fn compensation_keeps_the_speed_on_the_paper_s_slope() {
    let Some(_stamp) = stamp("compensation_keeps_the_speed_on_the_paper_s_slope") else {
        return;
    };
    let error = |factor: f64, compensates, measures| {
        let soil = Soil::nominal().scaled(factor);
        let error = Controlled::new(soil, &slope(20.0), compensates, measures).speed_error();
        println!(
            "ground times {factor}, compensation {compensates}, speed measured {measures}: {:+.2} %",
            100.0 * error
        );
        error.abs()
    };
    assert!(error(1.0, false, false) > 0.08);
    assert!(error(1.0, true, false) < 0.005);
    assert!(error(1.0, true, true) < 0.005);
    // Cohesion and friction of the ground differ from the configured ones.
    for factor in [0.7, 1.3] {
        let without = error(factor, false, false);
        assert!(error(factor, true, false) < without);
        assert!(error(factor, true, true) < 0.02);
    }
}

#[test]
fn an_arc_of_one_metre_closes() {
    let Some(_stamp) = stamp("an_arc_of_one_metre_closes") else {
        return;
    };
    let level = Profile::default();
    // Bounds of the distance between start and end of the circle, m.
    for (profile, compensates, [least, most]) in [
        (level, true, [0.0, 0.005]),
        (level, false, [0.0, 0.005]),
        (slope(10.0), true, [0.0, 0.05]),
        (slope(10.0), false, [0.2, 0.4]),
        (slope(15.0), true, [0.0, 0.15]),
    ] {
        let mut robot = Controlled::new(Soil::nominal(), &profile, compensates, false);
        robot.driven.drive([0.0; 2], 0.5);
        let start = robot.driven.plant.truth().cog;
        let (mut turned, mut heading, mut farthest) = (0.0, robot.driven.plant.truth().yaw, 0.0f64);
        while turned < TAU {
            robot.step(0.15, 0.15);
            let truth = robot.driven.plant.truth();
            turned += (truth.yaw - heading + PI).rem_euclid(TAU) - PI;
            heading = truth.yaw;
            let radius = (truth.cog[0] - start[0]).hypot(truth.cog[1] - start[1] - 1.0);
            farthest = farthest.max((radius - 1.0).abs());
        }
        let end = robot.driven.plant.truth().cog;
        let closing = (end[0] - start[0]).hypot(end[1] - start[1]);
        let pose = robot.controller.pose();
        println!(
            "slope {:.0} degrees, compensation {compensates}: closes within {:.1} mm after {:.2} s, radius within {:.1} mm, odometry {:.1} {:.1} mm",
            profile.slope.to_degrees(),
            1e3 * closing,
            robot.milliseconds as f64 * DT,
            1e3 * farthest,
            1e3 * pose.x,
            1e3 * pose.y
        );
        assert!(closing >= least && closing < most);
        // The resistance of the ground to turning is not known at the start.
        assert!(profile != level || farthest < 0.03, "{farthest}");
    }
}

#[test]
fn a_stop_is_a_stop_and_a_straight_line_after_a_push_is_found_again() {
    let mut robot = Controlled::new(Soil::nominal(), &Profile::default(), true, false);
    for _ in 0..3_000 {
        robot.step(0.15, 0.0);
    }
    // An external force turns the robot by 0.3 rad while it drives.
    let heading = robot.driven.plant.truth().yaw;
    while robot.driven.plant.truth().yaw < heading + 0.3 {
        robot.driven.step([-0.05, 0.05]);
        robot.milliseconds += 1;
        if robot.milliseconds.is_multiple_of(SYNC) {
            let observation = Observation {
                sprockets: robot.driven.speeds.map(|speed| speed as f32),
                heading: robot.driven.plant.truth().yaw as f32,
                ..Observation::default()
            };
            robot.controller.observe(&observation, SYNC as f32 * 1e-3);
        }
    }
    for _ in 0..20_000 {
        robot.step(0.15, 0.0);
    }
    let truth = robot.driven.plant.truth();
    println!(
        "after the push: {:.1} mm beside the line, {:.4} rad",
        1e3 * truth.cog[1],
        truth.yaw
    );
    assert!(
        truth.cog[1].abs() < 0.02 && truth.yaw.abs() < 0.01,
        "{truth:?}"
    );
    for _ in 0..2_000 {
        robot.step(0.0, 0.0);
    }
    assert_eq!(robot.sprockets, [0.0; 2]);
    assert!(robot.driven.plant.truth().ground_speed.abs() < 1e-4);
}
