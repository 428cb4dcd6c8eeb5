//! The robots as a run sees them: which nodes there are, what each is told about itself, and which plant they move.
//!
//! One file per robot; a new one is a variant of [`Kind`] and a line in [`machine`].

pub mod b2p2;
pub mod crawler;
pub mod hylos;
pub mod rt_mover;

use crate::plant::Plant;
use crate::scenario::{NodeName, Payload, Scenario};
use clap::ValueEnum;
use tautrack::link::MotorModel;
use tautrack::robots::{self, Body};
use tautrack::settings::Setting;

/// The robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, ValueEnum)]
pub enum Kind {
    /// Tracked, variable geometry (Paillat et al.)
    #[default]
    B2p2,
    /// Two tracks on soft ground (Kurc and Szybicki)
    Crawler,
    /// Four legs with steered wheels (Besseron et al.)
    Hylos,
    /// Four wheels on two arms that step (Nakajima)
    RtMover,
}

impl Kind {
    /// The node program of its guard.
    pub fn guard_program(self) -> &'static str {
        match self {
            Self::B2p2 => "guard",
            Self::Crawler => "guard_crawler",
            Self::Hylos => "guard_hylos",
            Self::RtMover => "guard_rt_mover",
        }
    }

    /// Its scenario when none is named, in `host-tests/scenarios`.
    pub fn scenario_file(self) -> &'static str {
        match self {
            Self::B2p2 => "staircase.toml",
            Self::Crawler => "crawler/slope.toml",
            Self::Hylos => "hylos/loop.toml",
            Self::RtMover => "rt-mover/step-10.toml",
        }
    }

    /// Names of the stages in which its drives come to life.
    pub fn stages(self) -> &'static [&'static str] {
        match self {
            Self::B2p2 => robots::b2p2::B2p2::STAGES,
            Self::Crawler => robots::crawler::Crawler::STAGES,
            Self::Hylos => robots::hylos::Hylos::STAGES,
            Self::RtMover => robots::rt_mover::RtMover::STAGES,
        }
    }

    /// What the operator's word of posture is.
    pub fn posture(self) -> Posture {
        match self {
            Self::B2p2 => Posture::ChassisAngle,
            Self::Crawler => Posture::None,
            Self::Hylos => Posture::Clearance,
            Self::RtMover => Posture::Step,
        }
    }

    /// The channels of [`crate::record::Truth::channels`] that a summary shows.
    pub fn headlines(self) -> &'static [&'static str] {
        match self {
            Self::B2p2 => &[],
            Self::Crawler => &["speed_over_ground_mps", "left_slip_1", "right_slip_1"],
            Self::Hylos => &["tip_over_margin_rad"],
            Self::RtMover => &[
                "front_left_height_m",
                "rear_right_height_m",
                "support_margin_m",
            ],
        }
    }

    /// What the report says beside the curves of those channels.
    pub fn plots_note(self) -> &'static str {
        match self {
            Self::B2p2 => "",
            Self::Crawler => {
                "Rates of sprockets and motors as Fig. 7, skid (sprocket's speed times slip) as Fig. 8 of Kurc and Szybicki, from the truth."
            }
            Self::Hylos => {
                "Least tip-over angle as Fig. 7 of Besseron et al., joint angles and loads of the wheels, from the truth."
            }
            Self::RtMover => {
                "Angles of the arms' shafts and heights of the wheels as Fig. 7 of Nakajima, and the margin over the wheels that carry load, from the truth."
            }
        }
    }

    /// What the simulated robot stands for, and what of it is assumed.
    pub fn origin(self) -> &'static str {
        match self {
            Self::B2p2 => "",
            Self::Crawler => {
                "Lengths, gear and equations come from Kurc and Szybicki, Kinematics of a Robot with Crawler Drive. The paper gives no masses, no track width and no soil: \
                 5 kg with the centre of gravity 45 mm high, tracks 40 mm wide and the soil of this run are assumed. Other values are another robot."
            }
            Self::Hylos => {
                "Equations, mass and the limit of the margin come from Besseron, Grand, Ben Amar and Bidaud, Decoupled control of the high mobility robot Hylos based on a \
                 dynamic stability margin. The paper gives no lengths, no distribution of the mass and no motors: all of these are assumed. Other values are another robot."
            }
            Self::RtMover => {
                "Equations come from Nakajima, Kinematics for a Rough Terrain Mobile Robot to Climb up a Step; lengths from the published overall size. \
                 Masses, the arms' drop, motors and gears are assumed. Other values are another robot."
            }
        }
    }
}

/// What the operator's word of posture is, robot by robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Posture {
    /// There is none.
    None,
    /// Angle of the chassis joint, 2^-16 turns.
    ChassisAngle,
    /// Height of the hips above the wheels, mm.
    Clearance,
    /// Height of the step ahead, mm. The guard passes on no word of its own.
    Step,
}

/// Which program a node runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Closes the loops of one motor.
    Axle,
    /// An axle that keeps the belt taut.
    Screw,
    /// The robot's guard.
    Guard,
}

/// One node of a robot.
#[derive(Clone, Debug)]
pub struct NodeSpec {
    /// Name in the robot.
    pub name: NodeName,
    /// Its program.
    pub role: Role,
    /// `CANopen` node id.
    pub id: u8,
    /// What differs from the settings' defaults, beside the id.
    pub settings: Vec<(Setting, i32)>,
    /// Its motor; `None` for the guard.
    pub motor: Option<MotorModel>,
}

/// A robot in its world: motors in the plant's order, then the guard.
pub struct Machine {
    /// Which robot.
    pub kind: Kind,
    /// Its nodes, the guard last.
    pub nodes: Vec<NodeSpec>,
    /// The world.
    pub plant: Box<dyn Plant>,
}

/// The robot of `scenario` in its world.
pub fn machine(scenario: &Scenario) -> Machine {
    let kind = scenario.kind();
    let (nodes, plant) = if let Some(robot) = &scenario.crawler {
        (
            crawler::nodes(scenario, robot),
            crawler::plant(scenario, robot),
        )
    } else if let Some(robot) = &scenario.hylos {
        (hylos::nodes(scenario, robot), hylos::plant(scenario, robot))
    } else if let Some(robot) = &scenario.rt_mover {
        (
            rt_mover::nodes(scenario, robot),
            rt_mover::plant(scenario, robot),
        )
    } else {
        (b2p2::nodes(scenario), b2p2::plant(scenario))
    };
    Machine { kind, nodes, plant }
}

/// What a calibration left of the plants' declination and hard iron: off by up to 0.4 uT.
const SENSORS: &[(Setting, i32)] = &[
    (Setting::Declination, 1_000),
    (Setting::HardIronForward, 8_300),
    (Setting::HardIronLeft, -4_800),
    (Setting::HardIronUp, 12_400),
];

/// What a guard is told of a declared load.
fn payload(payload: &Payload) -> [(Setting, i32); 4] {
    let [forward, left, up] = payload.place_m.map(|metres| (metres * 1e6).round() as i32);
    [
        (Setting::PayloadMass, (payload.mass_kg * 1e3).round() as i32),
        (Setting::PayloadForward, forward),
        (Setting::PayloadLeft, left),
        (Setting::PayloadUp, up),
    ]
}

/// Place of a node among `nodes`, which is also its number on the virtual bus.
pub fn index_of(nodes: &[NodeSpec], name: NodeName) -> Option<usize> {
    nodes.iter().position(|node| node.name == name)
}
