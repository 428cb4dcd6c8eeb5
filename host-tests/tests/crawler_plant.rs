//! The crawler's plant against equilibrium and hand calculation, and the body controller that drives it.
//!
//! The motors here are ideal: the sprockets turn as they are told.

use core::f64::consts::{PI, TAU};
use tautrack::link::Shaft;
use tautrack::robots::crawler::{
    BodyVelocity, Configuration, Controller, Observation, parameters as model,
};
use tautrack_host_tests::plant::Plant;
use tautrack_host_tests::plant::b2p2::Payload;
use tautrack_host_tests::plant::crawler::{Crawler, CrawlerParameters, Profile, Soil};

const DT: f64 = 1e-3;
const GRAVITY: f64 = 9.81;
/// Period of SYNC, and so of the body controller, in milliseconds.
const SYNC: usize = 4;

/// Sprockets that turn as they are told, with a limit to their acceleration.
struct Driven {
    plant: Crawler,
    radius: f64,
    speeds: [f64; 2],
    angles: [f64; 2],
    /// Acceleration of the belts, m/s^2.
    acceleration: f64,
}

impl Driven {
    fn new(parameters: &CrawlerParameters, profile: &Profile) -> Self {
        Self {
            plant: Crawler::new(parameters, profile, 1),
            radius: parameters.sprocket_radius,
            speeds: [0.0; 2],
            angles: [0.0; 2],
            acceleration: 0.5,
        }
    }

    /// One millisecond towards these belt speeds, m/s.
    fn step(&mut self, belts: [f64; 2]) {
        let most = self.acceleration / self.radius * DT;
        let shafts = [0, 1].map(|side: usize| {
            let change = belts[side] / self.radius - self.speeds[side];
            self.speeds[side] += change.clamp(-most, most);
            self.angles[side] += self.speeds[side] * DT;
            Shaft {
                position: (self.angles[side] / TAU * 4_294_967_296.0) as i64,
                velocity: self.speeds[side] as f32,
            }
        });
        self.plant.advance([Some(&shafts[0]), Some(&shafts[1])]);
    }

    /// Drives for `seconds` or until it has turned over.
    fn drive(&mut self, belts: [f64; 2], seconds: f64) {
        for _ in 0..(seconds / DT).round() as usize {
            if !self.plant.truth().toppled {
                self.step(belts);
            }
        }
    }
}

fn slope(degrees: f64) -> Profile {
    Profile {
        slope: degrees.to_radians(),
        ..Profile::default()
    }
}

/// Slip at which a track bears half of the weight's part along a slope: pressure grows linearly towards the lower end, as the moments
/// about the middle ask for; the force is summed over 20000 strips and the slip found by halving.
fn equilibrium(p: &CrawlerParameters, slope: f64) -> f64 {
    let (length, width) = (p.contact_length, p.track_width);
    let weight = p.mass * GRAVITY;
    let mean = 0.5 * weight * slope.cos() / (length * width);
    let centre = p.cog[0] - p.cog[2] * slope.tan();
    let strips = 20_000;
    let force = |slip: f64| -> f64 {
        (0..strips)
            .map(|strip| {
                let from_front = (f64::from(strip) + 0.5) / f64::from(strips) * length;
                let forward = 0.5 * length - from_front;
                let pressure = mean * (1.0 + 12.0 * centre * forward / (length * length));
                let strength = p.soil.cohesion + pressure * p.soil.friction_angle.tan();
                let u = p.soil.k1 * slip * from_front;
                strength * u * (1.0 - u).exp() * width * length / f64::from(strips)
            })
            .sum()
    };
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if force(middle) < 0.5 * weight * slope.sin() {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[test]
fn on_level_ground_without_load_the_robot_goes_as_fast_as_its_belts() {
    for speed in [0.15, -0.3] {
        let mut driven = Driven::new(&CrawlerParameters::nominal(), &Profile::default());
        driven.drive([speed; 2], 4.0);
        let truth = driven.plant.truth();
        assert!(
            (truth.ground_speed - speed).abs() < 1e-5,
            "{}",
            truth.ground_speed
        );
        assert!(
            truth.pitch.abs() < 1e-4 && truth.roll.abs() < 1e-4,
            "{truth:?}"
        );
    }
}

#[test]
fn slip_on_a_slope_solves_the_equilibrium_of_the_track() {
    for (degrees, speed) in [
        (20.0, 0.15),
        (20.0, 0.05),
        (10.0, 0.3),
        (25.0, 0.1),
        (-15.0, 0.15),
    ] {
        let p = CrawlerParameters::nominal();
        let mut driven = Driven::new(&p, &slope(degrees));
        driven.drive([speed; 2], 12.0);
        let slip = driven.plant.slip();
        // Downhill the ground holds back, and the rear of the track is the lower end no more.
        let want = if degrees > 0.0 {
            equilibrium(&p, degrees.to_radians())
        } else {
            let mirrored = equilibrium_downhill(&p, -degrees.to_radians());
            -mirrored
        };
        println!("{degrees} degrees at {speed} m/s: slip {slip:.5?}, equilibrium {want:.5}");
        for slip in slip {
            assert!(
                (slip - want).abs() < 0.002,
                "{degrees} {speed}: {slip} {want}"
            );
        }
    }
}

/// As [`equilibrium`], the lower end in front.
fn equilibrium_downhill(p: &CrawlerParameters, slope: f64) -> f64 {
    let mut mirrored = *p;
    mirrored.cog[0] = p.cog[0] + 2.0 * p.cog[2] * slope.tan();
    equilibrium(&mirrored, slope)
}

#[test]
fn a_parked_robot_stays_on_the_slope() {
    let mut driven = Driven::new(&CrawlerParameters::nominal(), &slope(20.0));
    driven.drive([0.0; 2], 3.0);
    let start = driven.plant.truth().cog;
    driven.drive([0.0; 2], 20.0);
    let end = driven.plant.truth().cog;
    let crept = (end[0] - start[0]).hypot(end[2] - start[2]);
    assert!(crept < 1e-4, "{crept}");
}

#[test]
fn a_dead_robot_holds_by_the_friction_of_its_gears() {
    let mut driven = Driven::new(&CrawlerParameters::nominal(), &slope(20.0));
    driven.drive([0.15; 2], 2.0);
    for _ in 0..3_000 {
        driven.plant.advance([None, None]);
    }
    assert!(driven.plant.truth().ground_speed.abs() < 1e-4);
    assert_eq!(driven.plant.truth().belt_speed, [0.0; 2]);
}

#[test]
fn shafts_carry_the_weight_s_part_along_the_slope() {
    let p = CrawlerParameters::nominal();
    let mut driven = Driven::new(&p, &slope(20.0));
    driven.drive([0.15; 2], 8.0);
    let torque: f64 = [0, 1]
        .map(|side| f64::from(driven.plant.sensors(side).shaft_torque))
        .iter()
        .sum();
    let want = p.mass * GRAVITY * 20f64.to_radians().sin() * p.sprocket_radius;
    assert!((torque - want).abs() < 2e-3 * want, "{torque} {want}");
}

#[test]
fn tracks_against_each_other_turn_the_robot_on_the_spot_slower_than_without_slip() {
    let p = CrawlerParameters::nominal();
    let mut driven = Driven::new(&p, &Profile::default());
    driven.drive([-0.05, 0.05], 3.0);
    let before = driven.plant.truth().yaw;
    driven.drive([-0.05, 0.05], 1.0);
    let rate = (driven.plant.truth().yaw - before + PI).rem_euclid(TAU) - PI;
    let without = 0.1 / p.track_spacing;
    println!("turns at {rate:.3} rad/s of {without:.3}");
    assert!(
        rate > 0.4 * without && rate < 0.98 * without,
        "{rate} of {without}"
    );
    let [x, y, _] = driven.plant.truth().cog;
    assert!(x.hypot(y) < 0.01, "{x} {y}");
}

/// A controller around the plant, called at every SYNC; attitude by the plant's own noisy sensors, heading true.
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
            body: model::BODY,
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

    /// One millisecond with this motion asked for.
    fn step(&mut self, forward: f32, yaw_rate: f32) {
        if self.milliseconds.is_multiple_of(SYNC) {
            let plant = &self.driven.plant;
            let [pitch, roll] = plant.body_sensors().inclination;
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

    /// Mean error of the speed over the last 5 of 25 s at 0.15 m/s, as a share of it.
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
    let error = |factor: f64, compensates, measures| {
        let soil = Soil::nominal().scaled(factor);
        let error = Controlled::new(soil, &slope(20.0), compensates, measures).speed_error();
        println!(
            "ground times {factor}, compensation {compensates}, speed measured {measures}: {:+.2} %",
            100.0 * error
        );
        error.abs()
    };
    // As configured, but for the pressure, which the controller takes to be even.
    assert!(error(1.0, false, false) > 0.08);
    assert!(error(1.0, true, false) < 0.03);
    assert!(error(1.0, true, true) < 0.005);
    // Cohesion and friction other than configured.
    for factor in [0.7, 1.3] {
        let without = error(factor, false, false);
        assert!(error(factor, true, false) < without);
        assert!(error(factor, true, true) < 0.01);
    }
}

#[test]
fn an_arc_of_one_metre_closes() {
    for (profile, compensates, bound) in [
        (Profile::default(), true, 0.05),
        (Profile::default(), false, 0.05),
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
            "compensation {compensates}: closes within {:.1} mm after {:.2} s, radius within {:.1} mm, odometry {:.1} {:.1} mm",
            1e3 * closing,
            robot.milliseconds as f64 * DT,
            1e3 * farthest,
            1e3 * pose.x,
            1e3 * pose.y
        );
        assert!(closing < bound && farthest < bound);
    }
}

#[test]
fn a_stop_is_a_stop_and_a_straight_line_after_a_push_is_found_again() {
    let mut robot = Controlled::new(Soil::nominal(), &Profile::default(), true, false);
    for _ in 0..3_000 {
        robot.step(0.15, 0.0);
    }
    // Somebody turns the robot by 0.3 rad on the way.
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

/// A load high above the body.
fn loaded(mass: f64, up: f64) -> CrawlerParameters {
    CrawlerParameters {
        soil: Soil::firm(),
        payload: Some(Payload {
            mass,
            place: [0.0, 0.0, up],
            from_time_s: 0.0,
        }),
        ..CrawlerParameters::nominal()
    }
}

/// Belt speeds, m/s, the acceleration with which they are taken up, m/s^2, and for how long, s.
type Leg = ([f64; 2], f64, f64);

/// Time at which the robot turns over on these legs, s.
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

/// A rigid robot on rigid ground turns over where its centre of gravity passes the end of the runs, or the middle of a track. The
/// ground gives way under the lower edge, so the plant does some degrees before.
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

/// What turns the robot over, and the same done gently, slowly or without the load, which does not.
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
    let cases: [(&str, [(CrawlerParameters, Profile, Vec<Leg>); 2]); 5] = [
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
