//! Scenarios: one TOML file says what a run is made of and what must come out of it.
//!
//! [`Description`] is the file as written; [`Scenario`] is a description that passed every check, so nothing checks again.
//! `operator` is the section of that name with its bounds, `driver` reads who the operator is, `fault`
//! is what can go wrong, `crawler`, `hylos` and `rt_mover` are the sections of those robots, `plant`
//! turns values into the plant's, `check` holds the other bounds, `error` says what was bad and where,
//! `script` plays the operator.

mod check;
pub mod crawler;
mod driver;
mod error;
mod fault;
pub mod hylos;
mod operator;
mod plant;
pub mod rt_mover;
mod script;

pub use crawler::{Crawler, SlipCompensation};
pub use error::{Problem, ScenarioError};
pub use fault::{Fault, FaultKind, NodeName};
pub use hylos::Hylos;
pub use operator::{Event, Operator, OperatorRequest, When};
pub use rt_mover::RtMover;
pub use script::{Ask, BusView, Script};

use crate::machines::Kind;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A description that passed every check. Read-only; [`Description::check`] makes one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Scenario(Description);

impl std::ops::Deref for Scenario {
    type Target = Description;

    fn deref(&self) -> &Description {
        &self.0
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// Says what is wrong with the first bad value, with file, line and column.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(error) => Err(ScenarioError::new(
                &file,
                Problem::Unreadable(error.to_string()),
            )),
        }
    }

    /// Checks the text of a scenario file; `file` is the name that errors show.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(text: &str, file: &str) -> Result<Self, ScenarioError> {
        error::parse(text, file)?
            .check()
            .map_err(|problem| error::locate(problem, text, file))
    }

    /// Checks a description that no file holds; its errors show the scenario's name.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn checked(description: Description) -> Result<Self, ScenarioError> {
        let name = description.name.clone();
        description
            .check()
            .map_err(|problem| ScenarioError::new(&name, problem))
    }

    /// Which robot it is.
    pub fn kind(&self) -> Kind {
        if self.crawler.is_some() {
            Kind::Crawler
        } else if self.hylos.is_some() {
            Kind::Hylos
        } else if self.rt_mover.is_some() {
            Kind::RtMover
        } else {
            Kind::B2p2
        }
    }

    /// A copy to change and check again, for sweeps and command-line switches.
    pub fn description(&self) -> Description {
        self.0.clone()
    }
}

/// A scenario file as written. Axes as in [`crate::record::Truth`]; axle 1 starts at x = 0, y = 0, heading 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Name of the run, as reports show it.
    pub name: String,
    /// What the run shows, one or two sentences.
    pub about: String,
    /// Seed of all noise and of all random faults.
    pub seed: u64,
    /// Virtual time to run, s.
    pub duration_s: f64,
    /// Whether the guard's filter limits the operator. Off, it passes every command on.
    #[serde(default = "on")]
    pub guard: bool,
    /// Whether the guard tells the drives the torques that it knows in advance.
    #[serde(default = "on")]
    pub feed_forward: bool,
    /// Coefficient of friction between track and ground; of the crawler's soft ground, its strength over the one that the guard is told.
    pub friction: f64,
    /// The ground.
    pub terrain: Terrain,
    /// B2P2, and what its paper leaves open about it; the nominal stand-in where no robot is named at all.
    #[serde(default = "Robot::nominal")]
    pub robot: Robot,
    /// The crawler instead of B2P2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crawler: Option<Crawler>,
    /// Hylos instead of B2P2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hylos: Option<Hylos>,
    /// RT-Mover instead of B2P2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rt_mover: Option<RtMover>,
    /// Who drives.
    #[serde(with = "driver")]
    pub operator: Operator,
    /// What goes wrong.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
    /// What must come out.
    #[serde(default)]
    pub expect: Expect,
}

fn on() -> bool {
    true
}

/// The ground; level where nothing is said.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Terrain {
    /// Level ground without end.
    Flat,
    /// Stairs up to a landing.
    Stairs {
        /// Height of one step.
        riser_m: f64,
        /// Depth of one step.
        run_m: f64,
        /// Number of risers; the last leads onto the landing.
        count: u32,
        /// Width, centred on y = 0.
        width_m: f64,
        /// x of the first nose.
        first_nose_m: f64,
        /// Length of the landing.
        #[serde(default = "landing")]
        landing_m: f64,
        /// The robot starts on the landing, and the stairs lead down.
        #[serde(default)]
        down: bool,
    },
    /// One step up and, behind it, down again.
    Curb {
        /// Height.
        height_m: f64,
        /// x of its nose.
        nose_m: f64,
        /// Length along x.
        #[serde(default = "landing")]
        depth_m: f64,
    },
    /// Level ground, a ramp up, and a plateau.
    Ramp {
        /// Rise.
        angle_deg: f64,
        /// x of its foot.
        foot_m: f64,
        /// Length along its face.
        length_m: f64,
    },
    /// Hylos' hill that rises to the left, with waves on all of it; the robot starts on the level before it.
    Hillside {
        /// Rise along y.
        slope_deg: f64,
        /// y of the middle of its foot.
        foot_m: f64,
        /// Half the height between crest and trough of the waves.
        #[serde(default)]
        wave_height_m: f64,
    },
    /// A plane without end, on which the robot starts.
    Slope {
        /// Rise along x.
        angle_deg: f64,
        /// Rise to the left.
        #[serde(default)]
        side_deg: f64,
    },
}

fn landing() -> f64 {
    6.0
}

fn usual() -> f64 {
    1.0
}

/// What the papers leave open about the robot; DESIGN.md section 6 has the nominal values and their reasons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Belt length `K` without the arcs around the pulleys.
    pub k_m: f64,
    /// Radius of the three pulleys, belt included.
    pub pulley_radius_m: f64,
    /// Height of body 1's centre of mass over the line through axles 1 and 2.
    #[serde(default)]
    pub com_offset_m: f64,
    /// Noise of the sensors on the body, as a multiple of the usual.
    #[serde(default = "usual")]
    pub sensor_noise: f64,
    /// Load beside the robot's own mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
}

impl Robot {
    /// The stand-in of DESIGN.md section 6.
    pub fn nominal() -> Self {
        Self {
            k_m: 1.232,
            pulley_radius_m: 0.05,
            com_offset_m: 0.0,
            sensor_noise: 1.0,
            payload: None,
        }
    }
}

/// A point mass fixed to body 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass.
    pub mass_kg: f64,
    /// Place in body 1: origin at axle 1, x towards axle 2, y left, z up.
    pub place_m: [f64; 3],
    /// Virtual time from which it is on board.
    #[serde(default)]
    pub from_s: f64,
    /// Whether the guard's settings know of it.
    pub declared: bool,
}

/// What must come out; what is absent is not asked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Stands level behind the last nose at some moment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landed: Option<bool>,
    /// Turns over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toppled: Option<bool>,
    /// Earliest and latest landing, virtual time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landing_between_s: Option<[f64; 2]>,
    /// Stands still during the last second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<bool>,
    /// The guard holds back or refuses at least once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guard_intervenes: Option<bool>,
    /// Largest strain or slack of the belt during the climb.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_error_below_m: Option<f64>,
}
