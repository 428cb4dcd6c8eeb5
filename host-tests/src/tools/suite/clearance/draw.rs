//! Draws obstacles for the autonomous clearance, and the robot that meets them.

use super::failure::Failure;
use crate::robots::Robot;
use crate::robots::payload::Payload;
use crate::scenario::{Clearance, Description, Event, Scenario, ScenarioError, Sensors, When};
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};
use tautrack::robots::b2p2::clearance::Phase;

/// Kind of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Stairs that lead up.
    StairsUp,
    /// Stairs that lead down.
    StairsDown,
    /// A step up.
    CurbUp,
    /// A step down.
    CurbDown,
    /// A ramp up to a plateau.
    Ramp,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::StairsUp,
        Self::StairsDown,
        Self::CurbUp,
        Self::CurbDown,
        Self::Ramp,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::StairsUp => "stairs up",
            Self::StairsDown => "stairs down",
            Self::CurbUp => "curb up",
            Self::CurbDown => "curb down",
            Self::Ramp => "ramp",
        }
    }
}

/// An obstacle and its robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Kind.
    pub kind: Kind,
    /// Height of a step or of the curb, m; 0 for a ramp.
    pub riser_m: f64,
    /// Depth of a step, m; 0 for a ramp and a curb.
    pub run_m: f64,
    /// Number of steps.
    pub steps: u32,
    /// Angle of a ramp, degrees.
    pub angle_deg: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Constant K of the belts, m.
    pub k_m: f64,
    /// Mass of the payload, kg.
    pub payload_kg: f64,
    /// Angle between the heading and the obstacle, degrees.
    pub heading_deg: f64,
    /// x at which the obstacle lies behind the centre of gravity, m.
    pub end_m: f64,
}

/// Longest time from power-up until the robot drives toward the obstacle, s.
const START_S: f64 = 6.0;
/// Rate with which the operator turns the robot before the obstacle, degrees/s.
const TURN_DEG_S: f64 = 20.0;

/// Draws the run with this number, and what fails in it, if something shall. Then the obstacle is
/// one that leads to the phase in which it fails.
///
/// # Errors
/// A drawn value is out of a scenario's bounds, which is a mistake in this file.
pub fn draw(
    seed: u64,
    number: u64,
    faulty: bool,
) -> Result<(Scenario, Obstacle, Option<Failure>), ScenarioError> {
    // The third key does not occur in the other suites.
    let mut random = Random::new(&[seed, number, 0x100]);
    let random = &mut random;
    let mut drawn = beginning(random);
    let kinds = [
        (Kind::StairsUp, 0.35),
        (Kind::StairsDown, 0.2),
        (Kind::CurbUp, 0.15),
        (Kind::CurbDown, 0.1),
        (Kind::Ramp, 0.2),
    ];
    let mut kind = random.weighted(&kinds).unwrap_or(Kind::StairsUp);
    let failure = faulty.then(|| Failure::draw(random, number));
    if let Some(of_phase) = failure.as_ref().and_then(|it| obstacle_of(it.phase)) {
        kind = of_phase;
    }
    let k_m = random.between(1.15, 1.4);
    let payload = random.coin().then(|| payload(random));
    let mut obstacle = Obstacle {
        kind,
        riser_m: 0.0,
        run_m: 0.0,
        steps: 1,
        angle_deg: 0.0,
        friction: random.between(0.8, 1.3),
        k_m,
        payload_kg: payload.as_ref().map_or(0.0, |load| load.mass_kg),
        heading_deg: 0.0,
        end_m: 0.0,
    };
    drawn.friction = obstacle.friction;
    drawn.robot = Robot::nominal(1.0);
    drawn.robot.b2p2_mut().payload = payload;
    let arches = failure.as_ref().is_some_and(Failure::arches);
    if arches {
        // The robot of `curb-30-cm.toml`.
        obstacle.k_m = 1.5;
        obstacle.payload_kg = 0.0;
        drawn.robot.b2p2_mut().payload = None;
        drawn.robot.b2p2_mut().com_offset_m = -0.035;
    }
    let k_m = obstacle.k_m;
    drawn.robot.b2p2_mut().k_m = k_m;
    // Axle 3 of the straight robot is at (K + 0.32) / 2, its belt 0.05 m farther.
    let front = 0.5 * (k_m + 0.32) + 0.05;
    let ahead = front + random.between(0.1, 0.5);
    let too_high = failure.as_ref().is_some_and(Failure::needs_a_high_curb);
    drawn.terrain = terrain(random, &mut obstacle, ahead, too_high);
    if random.chance(0.6) && !arches {
        obstacle.heading_deg = random.sign() * random.between(0.0, 15.0);
    }
    let rates = [50, 100, 200, 1_000];
    let hz = rates[random.below(rates.len() as u64) as usize];
    drawn.sensors = Sensors {
        inertial_hz: hz.max(100),
        inclinometer_hz: hz.min(100),
        ..Sensors::default()
    };
    let speed = random.between(0.08, 0.15);
    operator(&mut drawn, &obstacle, speed);
    let travel = obstacle.end_m + 1.5 + 0.5 * f64::from(obstacle.steps) * obstacle.riser_m;
    // A second attempt takes up to a minute.
    drawn.duration_s = START_S + 75.0 + 1.6 * travel / speed.min(0.12);
    drawn.name = format!("clearance-{seed}-{number}");
    drawn.about = about(&obstacle);
    if let Some(failure) = &failure {
        drawn.about = format!("{}; {}", drawn.about, failure.words());
        drawn.name.push_str("-fault");
    }
    Ok((Scenario::checked(drawn)?, obstacle, failure))
}

/// Five steps before the nominal robot.
///
/// # Errors
/// A value is out of a scenario's bounds.
pub fn stairs(
    riser_m: f64,
    run_m: f64,
    friction: f64,
) -> Result<(Scenario, Obstacle), ScenarioError> {
    let mut drawn = beginning(&mut Random::new(&[0]));
    drawn.robot = Robot::nominal(1.0);
    let ahead_m = 1.0;
    let obstacle = Obstacle {
        kind: Kind::StairsUp,
        riser_m,
        run_m,
        steps: 5,
        angle_deg: 0.0,
        friction,
        k_m: drawn.robot.b2p2_mut().k_m,
        payload_kg: 0.0,
        heading_deg: 0.0,
        end_m: ahead_m + 4.0 * run_m,
    };
    drawn.friction = friction;
    drawn.terrain = Terrain::Stairs {
        riser_m,
        run_m,
        count: obstacle.steps,
        width_m: 6.0,
        first_nose_m: ahead_m,
        landing_m: 6.0,
        down: false,
    };
    operator(&mut drawn, &obstacle, 0.13);
    drawn.duration_s = 120.0;
    drawn.name = format!("stairs-{riser_m}-{run_m}");
    drawn.about = about(&obstacle);
    Ok((Scenario::checked(drawn)?, obstacle))
}

/// Kind of the obstacle that leads to a phase; `None` if every one does.
fn obstacle_of(phase: Phase) -> Option<Kind> {
    match phase {
        Phase::Climb | Phase::Sway | Phase::Crest | Phase::Land => Some(Kind::StairsUp),
        Phase::Descend => Some(Kind::StairsDown),
        Phase::Withdraw | Phase::Raise | Phase::Arch | Phase::Haul => Some(Kind::CurbUp),
        _ => None,
    }
}

fn payload(random: &mut Random) -> Payload {
    Payload {
        mass_kg: random.between(0.1, 1.0),
        place_m: [
            random.between(0.1, 0.25),
            random.between(-0.05, 0.05),
            random.between(0.05, 0.15),
        ],
        from_s: 0.0,
        declared: true,
    }
}

/// Draws the obstacle `ahead` m in front of axle 1.
fn terrain(random: &mut Random, obstacle: &mut Obstacle, ahead: f64, too_high: bool) -> Terrain {
    let stairs = |obstacle: &mut Obstacle, down: bool| {
        obstacle.end_m = ahead + f64::from(obstacle.steps - 1) * obstacle.run_m;
        Terrain::Stairs {
            riser_m: obstacle.riser_m,
            run_m: obstacle.run_m,
            count: obstacle.steps,
            width_m: 6.0,
            first_nose_m: ahead,
            landing_m: 6.0,
            down,
        }
    };
    match obstacle.kind {
        Kind::StairsUp | Kind::StairsDown => {
            obstacle.riser_m = random.between(0.08, 0.2);
            obstacle.run_m = random.between(0.22, 0.36);
            obstacle.steps = 2 + random.below(11) as u32;
            stairs(obstacle, obstacle.kind == Kind::StairsDown)
        }
        Kind::CurbDown => {
            obstacle.riser_m = random.between(0.05, 0.3);
            obstacle.run_m = 0.3;
            let terrain = stairs(obstacle, true);
            obstacle.run_m = 0.0;
            terrain
        }
        Kind::CurbUp => {
            obstacle.riser_m = random.between(if too_high { 0.27 } else { 0.05 }, 0.3);
            obstacle.end_m = ahead;
            Terrain::Curb {
                height_m: obstacle.riser_m,
                nose_m: ahead,
                depth_m: 6.0,
            }
        }
        Kind::Ramp => {
            obstacle.angle_deg = random.between(10.0, 40.0);
            let length_m = random.between(0.4, 2.0);
            obstacle.end_m = ahead + length_m * libm::cos(obstacle.angle_deg.to_radians());
            Terrain::Ramp {
                angle_deg: obstacle.angle_deg,
                foot_m: ahead,
                length_m,
            }
        }
    }
}

/// An operator who turns the robot on the spot, and then only commands the speed.
fn operator(drawn: &mut Description, obstacle: &Obstacle, speed: f64) {
    let operator = &mut drawn.operator;
    operator.speed_mps = 0.0;
    operator.chassis_deg = 0.0;
    operator.heading_gain_per_s = 0.0;
    let after = |time_s| When {
        after_s: Some(time_s),
        ..When::default()
    };
    let turn = obstacle.heading_deg;
    if turn != 0.0 {
        operator.events.push(Event {
            when: after(0.1),
            yaw_rate_deg_s: Some(turn.signum() * TURN_DEG_S),
            ..Event::default()
        });
        operator.events.push(Event {
            when: after((turn.abs() / TURN_DEG_S * 1e3).round() / 1e3),
            yaw_rate_deg_s: Some(0.0),
            ..Event::default()
        });
    }
    operator.events.push(Event {
        when: after(0.3),
        speed_mps: Some(speed),
        clearance: Some(Clearance::Autonomous),
        ..Event::default()
    });
}

fn about(obstacle: &Obstacle) -> String {
    let Obstacle {
        kind,
        riser_m,
        run_m,
        steps,
        angle_deg,
        friction,
        k_m,
        payload_kg,
        heading_deg,
        ..
    } = obstacle;
    let name = kind.name();
    let what = match kind {
        Kind::StairsUp | Kind::StairsDown => format!("{name}, {steps} of {riser_m} by {run_m} m"),
        Kind::CurbUp | Kind::CurbDown => format!("{name}, {riser_m} m"),
        Kind::Ramp => format!("{name}, {angle_deg} degrees"),
    };
    format!("{what}; friction {friction}, K {k_m} m, {payload_kg} kg, turned {heading_deg} degrees")
}
