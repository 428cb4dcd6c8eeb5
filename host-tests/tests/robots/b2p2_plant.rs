//! Tests of B2P2's plant against hand calculations, conservation laws and the climb in the paper.
//!
//! Ideal motors replace the nodes: a rotor with inertia under a stiff servo.

use crate::stamp;
use core::f64::consts::TAU;
use tautrack::link::Shaft;
use tautrack_host_tests::robots::b2p2::plant::{B2p2, B2p2Parameters};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::ground::{Ground, Stairs};
use tautrack_host_tests::world::load::Load;

/// Number of B2P2's motors.
const MOTORS: usize = 4;

pub(super) const DT: f64 = 1.0e-3;
const MASS: f64 = 6.356_067 + 0.897_066 + 1.062_15;
pub(super) const WEIGHT: f64 = MASS * 9.81;

/// Rotor with its gear, seen from the output shaft, under a position and velocity servo.
struct Rotor {
    inertia: f64,
    /// Natural frequency of the servo, rad/s; it is critically damped.
    frequency: f64,
    limit: f64,
    angle: f64,
    rate: f64,
}

impl Rotor {
    fn new(inertia: f64, frequency: f64, limit: f64) -> Self {
        Self {
            inertia,
            frequency,
            limit,
            angle: 0.0,
            rate: 0.0,
        }
    }

    /// Runs one millisecond in ten substeps towards an angle (rad) and a rate (rad/s), under the
    /// torque of the load (N m).
    fn step(&mut self, angle: f64, rate: f64, load: f64) -> Shaft {
        for _ in 0..10 {
            let asked = self.inertia
                * self.frequency
                * (self.frequency * (angle - self.angle) + 2.0 * (rate - self.rate));
            let torque = asked.clamp(-self.limit, self.limit);
            self.rate += (torque - load) / self.inertia * (DT / 10.0);
            self.angle += self.rate * (DT / 10.0);
        }
        Shaft {
            position: (self.angle / TAU * 4_294_967_296.0) as i64,
            velocity: self.rate as f32,
        }
    }
}

/// B2P2 with ideal motors. The screw keeps the belts taut, following the angle of the joint's
/// shaft.
pub(super) struct Driven {
    pub(super) plant: B2p2,
    parameters: B2p2Parameters,
    rotors: [Rotor; MOTORS],
    alive: [bool; MOTORS],
    track_angles: [f64; 2],
    theta: f64,
    steps: u64,
}

impl Driven {
    pub(super) fn new(parameters: &B2p2Parameters, terrain: Ground, seed: u64) -> Self {
        let metre = parameters.screw_lead / TAU;
        Self {
            plant: B2p2::new(parameters, &terrain, seed),
            rotors: [
                Rotor::new(0.05, 30.0, 10.0),
                Rotor::new(0.05, 30.0, 10.0),
                Rotor::new(0.05, 200.0, 60.0),
                Rotor::new(16.0 * metre * metre, 400.0, 2000.0 * metre),
            ],
            alive: [true; MOTORS],
            track_angles: [0.0; 2],
            theta: parameters.initial_theta,
            steps: 0,
            parameters: *parameters,
        }
    }

    /// Runs one millisecond with these belt speeds (m/s), turning the chassis joint towards `theta`
    /// at 0.5 rad/s.
    pub(super) fn step(&mut self, belts: [f64; 2], theta: f64) {
        let p = &self.parameters;
        let change = (theta - self.theta).clamp(-0.5 * DT, 0.5 * DT);
        self.theta += change;
        let speeds = belts.map(|belt| belt / p.pulley_radius);
        for (angle, speed) in self.track_angles.iter_mut().zip(speeds) {
            *angle += speed * DT;
        }
        let joint = self.rotors[2].angle + p.initial_theta;
        let [now, next] =
            [joint, joint + DT * self.rotors[2].rate].map(|angle| p.taut_length(angle));
        let powered_up = p.taut_length(p.initial_theta) + p.initial_extension_error;
        let per_metre = TAU / p.screw_lead;
        let targets = [
            [self.track_angles[0], speeds[0]],
            [self.track_angles[1], speeds[1]],
            [self.theta - p.initial_theta, change / DT],
            [
                (now - powered_up) * per_metre,
                (next - now) / DT * per_metre,
            ],
        ];
        let shafts: [_; MOTORS] = core::array::from_fn(|i| {
            let load = f64::from(self.plant.sensors(i).shaft_torque);
            let shaft = self.rotors[i].step(targets[i][0], targets[i][1], load);
            self.alive[i].then_some(shaft)
        });
        self.plant.step(&shafts);
        self.steps += 1;
    }

    fn seconds(&self) -> f64 {
        self.steps as f64 * DT
    }

    /// Drives both belts at `speed` for `seconds`, with the chassis joint at its commanded angle.
    pub(super) fn drive(&mut self, speed: f64, seconds: f64) {
        for _ in 0..(seconds / DT).round() as u64 {
            self.step([speed; 2], self.theta);
        }
    }

    /// Belt speeds that keep the robot on the x axis, m/s.
    pub(super) fn straight(&self, speed: f64) -> [f64; 2] {
        let truth = self.plant.truth();
        let turn = -1.5 * truth.yaw - 0.8 * truth.axle_1[1];
        [speed - 0.16 * turn, speed + 0.16 * turn]
    }

    /// Drives at `speed` for `seconds` and returns the mean of `value`.
    pub(super) fn mean(&mut self, speed: f64, seconds: f64, value: impl Fn(&Self) -> f64) -> f64 {
        let steps = (seconds / DT).round();
        let mut sum = 0.0;
        for _ in 0..steps as u64 {
            self.drive(speed, DT);
            sum += value(self);
        }
        sum / steps
    }

    pub(super) fn torque(&self, motor: usize) -> f64 {
        f64::from(self.plant.sensors(motor).shaft_torque)
    }
}

/// Hash of the whole physical state, FNV-1a with 64 bits, continued from `state`.
fn hash(plant: &B2p2, mut state: u64) -> u64 {
    plant.truth_bits(&mut |bytes| {
        for byte in bytes {
            state = (state ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    });
    state
}

/// Result of a climb.
#[derive(Debug, Default, PartialEq)]
struct Climb {
    landed_s: Option<f64>,
    toppled_s: Option<f64>,
    highest_pitch_deg: f64,
    lowest_backward_margin: f64,
    slip: f64,
    most_screw_newton: f64,
    most_tension_error: f64,
    hash: u64,
}

/// Runs the operator of these tests: front up on the approach, straight on the stairs, down over
/// the last nose (if `lower`).
fn climb(parameters: &B2p2Parameters, lower: bool, seed: u64, at_most_s: f64) -> Climb {
    let stairs = Stairs::paper();
    let mut robot = Driven::new(parameters, Ground::Stairs(stairs), seed);
    let mut result = Climb {
        hash: 0xcbf2_9ce4_8422_2325,
        ..Climb::default()
    };
    let mut theta = 45.0_f64.to_radians();
    let mut on_stairs = false;
    while robot.seconds() < at_most_s && result.landed_s.is_none() && result.toppled_s.is_none() {
        let truth = robot.plant.truth();
        let past = truth.cog[0] - stairs.last_nose_x();
        on_stairs |= truth.pitch > 8.0_f64.to_radians();
        if on_stairs && lower {
            theta = if (0.02..0.30).contains(&past) {
                -30.0_f64.to_radians()
            } else {
                0.0
            };
        }
        result.landed_s = (past > 0.3 && truth.pitch.abs() < 0.02).then(|| robot.seconds());
        result.toppled_s = truth.toppled.then(|| robot.seconds());
        result.highest_pitch_deg = result.highest_pitch_deg.max(truth.pitch.to_degrees());
        result.lowest_backward_margin = truth
            .backward_margin
            .map_or(result.lowest_backward_margin, |m| {
                m.min(result.lowest_backward_margin)
            });
        result.slip = truth.slip;
        result.most_tension_error = result.most_tension_error.max(truth.tension_error.abs());
        result.most_screw_newton = result
            .most_screw_newton
            .max((robot.torque(3) * TAU / parameters.screw_lead).abs());
        robot.step(robot.straight(0.13), theta);
        result.hash = hash(&robot.plant, result.hash);
    }
    result
}

#[test]
fn b2p2_climbs_the_staircase_of_the_paper_and_lands() {
    let Some(_stamp) = stamp("b2p2_climbs_the_staircase_of_the_paper_and_lands") else {
        return;
    };
    let climb = climb(&B2p2Parameters::nominal(), true, 1, 40.0);
    assert!(
        climb
            .landed_s
            .is_some_and(|time| (18.0..30.0).contains(&time)),
        "{climb:?}"
    );
    assert!((35.0..50.0).contains(&climb.highest_pitch_deg), "{climb:?}");
    assert!(climb.slip < 0.2, "{climb:?}");
    println!("{climb:?}");
}

#[test]
fn the_short_variant_climbs_too() {
    let Some(_stamp) = stamp("the_short_variant_climbs_too") else {
        return;
    };
    let climb = climb(&B2p2Parameters::short(), true, 1, 40.0);
    assert!(
        climb.landed_s.is_some() && climb.toppled_s.is_none(),
        "{climb:?}"
    );
}

#[test]
fn a_front_kept_up_topples_the_robot_backward_at_the_first_nose() {
    let climb = climb(&B2p2Parameters::nominal(), false, 1, 20.0);
    assert!(
        climb.toppled_s.is_some_and(|time| time < 15.0) && climb.lowest_backward_margin < 0.0,
        "{climb:?}"
    );
}

#[test]
fn a_payload_high_up_topples_the_robot_that_climbs_without_it() {
    let payload = Some(Load {
        mass: 2.0,
        place: [0.16, 0.0, 0.25],
        from_time_s: 2.0,
    });
    let climb = climb(
        &B2p2Parameters {
            payload,
            ..B2p2Parameters::nominal()
        },
        true,
        1,
        20.0,
    );
    assert!(climb.toppled_s.is_some(), "{climb:?}");
}

#[test]
fn the_ground_carries_the_weight_and_the_belts_set_the_speed() {
    let Some(_stamp) = stamp("the_ground_carries_the_weight_and_the_belts_set_the_speed") else {
        return;
    };
    let mut robot = Driven::new(&B2p2Parameters::nominal(), Ground::Flat, 1);
    robot.drive(0.0, 1.0);
    let lift = robot.mean(0.0, 0.5, |robot| robot.plant.lift());
    assert!(
        (lift - WEIGHT).abs() < 1e-3 * WEIGHT,
        "{lift} N for {WEIGHT} N"
    );
    robot.drive(0.13, 2.0);
    let before = robot.plant.truth().axle_1[0];
    robot.drive(0.13, 5.0);
    let truth = robot.plant.truth();
    let speed = (truth.axle_1[0] - before) / 5.0;
    assert!((speed - 0.13).abs() < 1e-4, "{speed} m/s");
    assert!(
        truth.slip < 2e-3 && truth.axle_1[1].abs() < 0.02,
        "{truth:?}"
    );
}

#[test]
fn climbing_a_slope_costs_the_sprockets_its_share_of_the_weight() {
    let pitch = 10.0_f64.to_radians();
    let mut robot = Driven::new(
        &B2p2Parameters::nominal(),
        Ground::Incline { pitch, roll: 0.0 },
        1,
    );
    robot.drive(0.1, 3.0);
    let torque = robot.mean(0.1, 0.5, |robot| robot.torque(0) + robot.torque(1));
    let expected = WEIGHT * pitch.sin() * 0.05;
    assert!(
        (torque - expected).abs() < 0.02 * expected,
        "{torque} N m, by hand {expected}"
    );
    let truth = robot.plant.truth();
    assert!(
        (truth.pitch - pitch).abs() < 1e-3 && truth.roll.abs() < 1e-3,
        "{truth:?}"
    );
}

#[test]
fn dead_tracks_roll_down_against_their_gears_friction() {
    let pitch = 10.0_f64.to_radians();
    let parameters = B2p2Parameters {
        dead_track_friction: 0.1,
        ..B2p2Parameters::nominal()
    };
    let mut robot = Driven::new(&parameters, Ground::Incline { pitch, roll: 0.0 }, 1);
    robot.drive(0.0, 1.0);
    robot.alive = [false, false, true, true];
    robot.drive(0.0, 0.2);
    let before = robot.plant.truth().ground_speed;
    robot.drive(0.0, 1.0);
    let acceleration = before - robot.plant.truth().ground_speed;
    // Ground speed is horizontal; each rotor adds the mass J / r^2 to its belt.
    let force = WEIGHT * pitch.sin() - 2.0 * 0.1 / 0.05;
    let expected = force / (MASS + 2.0 * 0.05 / (0.05 * 0.05)) * pitch.cos();
    assert!(
        (acceleration - expected).abs() < 0.05 * expected,
        "{acceleration} m/s^2, by hand {expected}"
    );
}

/// Tension of belts that are 2 % too long, so that they are slack in each posture, N.
const LOOSE: f64 = -2.0e3;

#[test]
fn a_dead_joint_holds_by_friction_or_belt_or_falls_and_a_dead_screw_holds() {
    let theta = 45.0_f64.to_radians();
    for (friction, belt_tension, falls) in
        [(8.0, LOOSE, false), (1.0, LOOSE, true), (1.0, 50.0, false)]
    {
        let parameters = B2p2Parameters {
            initial_theta: theta,
            dead_joint_friction: friction,
            belt_tension,
            ..B2p2Parameters::nominal()
        };
        let mut robot = Driven::new(&parameters, Ground::Flat, 1);
        robot.drive(0.0, 0.5);
        let extension = robot.plant.truth().extension;
        robot.alive[2..].fill(false);
        robot.drive(0.0, 0.3);
        let truth = robot.plant.truth();
        assert_eq!(
            truth.theta < theta - 0.05,
            falls,
            "friction {friction} N m, tension {belt_tension} N: {truth:?}"
        );
        assert!((truth.extension - extension).abs() < 1e-4, "{truth:?}");
    }
}

#[test]
fn a_joint_continues_from_where_it_is_when_its_node_returns() {
    let parameters = B2p2Parameters {
        initial_theta: 0.7,
        dead_joint_friction: 1.0,
        belt_tension: LOOSE,
        ..B2p2Parameters::nominal()
    };
    let mut robot = Driven::new(&parameters, Ground::Flat, 1);
    robot.drive(0.0, 0.2);
    robot.alive[2] = false;
    robot.drive(0.0, 0.15);
    let fallen = robot.plant.truth().theta;
    assert!(fallen < 0.65, "{fallen} rad");
    robot.alive[2] = true;
    // The rotor counts from zero again and is commanded to stay there.
    robot.rotors[2] = Rotor::new(0.05, 200.0, 60.0);
    robot.drive(0.0, 0.3);
    let theta = robot.plant.truth().theta;
    assert!(
        (theta - fallen).abs() < 0.05,
        "fell to {fallen} rad, then {theta} rad"
    );
}

#[test]
fn gear_and_rotor_exchange_torque_without_oscillating() {
    let theta = 45.0_f64.to_radians();
    let parameters = B2p2Parameters {
        initial_theta: theta,
        belt_tension: LOOSE,
        ..B2p2Parameters::nominal()
    };
    let mut robot = Driven::new(&parameters, Ground::Flat, 1);
    robot.drive(0.0, 1.0);
    // Calculated by hand from the paper's tables: segment 2 at 0.104 m along its axis and 0.7 mm
    // below it, segment 3 at r - 0.073 m.
    let held = |theta: f64| {
        let arm = |along: f64, up: f64| along * theta.cos() - up * theta.sin();
        let r = parameters.taut_length(theta);
        9.81 * (0.897_066 * arm(0.104_083, -0.000_723)
            + 1.062_15 * arm(r - 0.226 + 0.152_68, 0.000_09))
    };
    for step in 0..700 {
        robot.step([0.0; 2], if step < 300 { theta } else { 1.0 });
        let (torque, hand) = (robot.torque(2), held(robot.plant.truth().theta));
        // The robot stands still at first. 0.2 s after the joint starts to move, the vibration from
        // its start must have died out.
        let bound = if step < 300 { 0.05 } else { 0.5 };
        let judged = !(300..500).contains(&step);
        assert!(
            !judged || (torque - hand).abs() < bound,
            "step {step}: {torque} N m, by hand {hand}"
        );
    }
}

#[test]
fn energy_is_kept_in_free_fall() {
    let parameters = B2p2Parameters {
        initial_clearance: 1.0,
        ..B2p2Parameters::nominal()
    };
    let mut robot = Driven::new(&parameters, Ground::Flat, 1);
    robot.drive(0.0, 1e-3);
    let (energy, height) = (robot.plant.energy(), robot.plant.truth().cog[2]);
    robot.drive(0.0, 0.4);
    let fallen = height - robot.plant.truth().cog[2];
    assert!(
        (fallen - 0.5 * 9.81 * 0.4 * 0.4).abs() < 0.01,
        "fell {fallen} m"
    );
    let change = robot.plant.energy() - energy;
    assert!(
        change.abs() < 1e-2 * WEIGHT * fallen,
        "{change} J of {energy} J"
    );
    assert!(robot.plant.truth().backward_margin.is_none() && robot.plant.lift() == 0.0);
}

#[test]
fn the_same_run_has_the_same_hash_and_another_seed_another() {
    let Some(_stamp) = stamp("the_same_run_has_the_same_hash_and_another_seed_another") else {
        return;
    };
    let run = |seed| climb(&B2p2Parameters::nominal(), true, seed, 12.0);
    let first = run(1);
    assert_eq!(first, run(1));
    assert_ne!(first.hash, run(2).hash);
}

#[test]
fn switches_and_sensors_say_what_the_robot_is() {
    let theta = 30.0_f64.to_radians();
    let (pitch, roll) = (0.2_f64, 0.1_f64);
    let parameters = B2p2Parameters {
        initial_theta: theta,
        initial_extension_error: -0.020,
        ..B2p2Parameters::nominal()
    };
    let mut robot = Driven::new(&parameters, Ground::Incline { pitch, roll }, 1);
    // With a live node, the screw would tauten the belts.
    robot.alive[3] = false;
    robot.drive(0.0, 2.0);
    for motor in [2, 3] {
        assert!(
            robot.plant.sensors(motor).switches.home,
            "motor {motor}: {:?}",
            robot.plant.truth()
        );
    }
    assert!(robot.plant.truth().tension_error < -0.03);
    let (body, truth) = (robot.plant.body_sensors(), robot.plant.truth());
    let [x, y, z] = body.tilt_force.map(f64::from);
    let inclination = [x.atan2(z), y.atan2(x.hypot(z))];
    for (sensed, real) in inclination.into_iter().zip([truth.pitch, truth.roll]) {
        assert!((sensed - real).abs() < 0.01, "{body:?} {truth:?}");
    }
    let length = body
        .specific_force
        .iter()
        .map(|f| f64::from(*f).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!(
        (length - 9.81).abs() < 0.1 && body.specific_force[0] > 0.0 && body.specific_force[1] > 0.0,
        "{body:?}"
    );
    // The robot brakes with 1 m/s^2: the inclinometer shows this as a downward slope of 0.1 rad.
    let mut level = Driven::new(&B2p2Parameters::nominal(), Ground::Flat, 1);
    level.drive(0.3, 2.0);
    for step in 0..300 {
        level.step([0.3 - 0.001 * f64::from(step); 2], 0.0);
    }
    let [forward, _, up] = level.plant.body_sensors().tilt_force.map(f64::from);
    let lie = forward.atan2(up) - level.plant.truth().pitch;
    assert!((-0.13..-0.07).contains(&lie), "{lie} rad");
}

/// The front presses on a curb while the robot drives up it. The solver's position corrections,
/// which push bodies out of each other, turn the body, and the gyroscope must measure this. 0.01
/// rad corresponds to its bias over 2 s plus its delay of 5 ms.
#[test]
fn the_gyroscope_senses_every_turn_of_the_body() {
    let curb = Ground::Curb {
        height: 0.1,
        front_x: 1.0,
        depth: 3.0,
    };
    let mut robot = Driven::new(&B2p2Parameters::nominal(), curb, 1);
    robot.drive(0.4, 0.5);
    let mut sensed = robot.plant.truth().pitch;
    let (mut worst, mut highest) = (0.0_f64, 0.0_f64);
    for step in 0..1_500 {
        robot.step(robot.straight(0.4), -0.5 * DT * f64::from(step));
        let body = robot.plant.body_sensors();
        sensed -= f64::from(body.angular_rate[1]) * DT;
        let pitch = robot.plant.truth().pitch;
        worst = worst.max((sensed - pitch).abs());
        highest = highest.max(pitch);
    }
    assert!(highest > 0.4, "it did not rear up: {highest} rad");
    assert!(worst < 0.01, "{worst} rad");
}

#[test]
fn belts_and_rotors_do_not_tremble() {
    let mut robot = Driven::new(&B2p2Parameters::nominal(), Ground::Flat, 1);
    robot.drive(0.13, 3.0);
    for _ in 0..500 {
        robot.drive(0.13, DT);
        for side in 0..2 {
            let (torque, speed) = (robot.torque(side), robot.plant.truth().belt_speed[side]);
            assert!(torque.abs() < 0.3, "belt {side}: {torque} N m");
            assert!((speed - 0.13).abs() < 5e-4, "belt {side}: {speed} m/s");
        }
    }
}
