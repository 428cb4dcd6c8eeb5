//! The operator of a scenario: the first command, the events that change it, and their bounds.

use crate::bounds::{Problem, contradiction, within};
use serde::{Deserialize, Serialize};
use tautrack::bus::pdo::Request;

/// Maximum yaw rate that can be commanded, degrees/s. The object of the guard that takes it ends at
/// 32.767 rad/s.
const MAXIMUM_YAW_RATE_DEG_S: f64 = 1_800.0;

pub(super) fn chassis_rate() -> f64 {
    28.6
}

/// The operator of a scenario: a script, or a client on the bus.
///
/// A script begins when the guard is armed. It has a first command and a list of events that change
/// it; each event waits for the one before. If a client is the operator, the simulator sends no
/// commands. In a file a script is a table, and a client is `operator = "client"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Operator {
    /// Whether a client is the operator; then all other fields are ignored.
    #[serde(skip)]
    pub client: bool,
    /// Whether the script begins at power-up instead of when the guard is armed. Then the first
    /// request is to stop, and an event arms the robot.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub from_power_up: bool,
    /// Forward speed commanded at first, m/s.
    pub speed_mps: f64,
    /// Chassis angle commanded at first, front up positive, degrees.
    #[serde(default)]
    pub chassis_deg: f64,
    /// Height of the step that RT-Mover is commanded to climb at first, m; 0 commands none.
    #[serde(default)]
    pub step_m: f64,
    /// Rate at which the commanded chassis angle moves from one value to the next, degrees/s.
    #[serde(default = "chassis_rate")]
    pub chassis_rate_deg_s: f64,
    /// Yaw rate commanded per radian of heading error, 1/s; 0 commands none.
    #[serde(default)]
    pub heading_gain_per_s: f64,
    /// Whether the belts of B2P2 are released at first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub belts: Option<Belts>,
    /// Whether B2P2 clears obstacles by itself: then the operator's posture has no effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance: Option<Clearance>,
    /// Request until the first event with another one. Without it the operator requests to arm,
    /// and where the robot starts on a slope he confirms the homing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request: Option<OperatorRequest>,
    /// Changes of the command, in order.
    #[serde(default, rename = "event")]
    pub events: Vec<Event>,
}

impl Operator {
    pub(super) fn check(&self, duration_s: f64) -> Result<(), Problem> {
        within("operator.speed_mps", self.speed_mps, -1.0, 1.0, "m/s")?;
        let rate = self.chassis_rate_deg_s;
        within("operator.chassis_rate_deg_s", rate, 0.1, 180.0, "deg/s")?;
        let gain = self.heading_gain_per_s;
        within("operator.heading_gain_per_s", gain, 0.0, 10.0, "1/s")?;
        within("operator.step_m", self.step_m, 0.0, 0.3, "m")?;
        for (index, event) in self.events.iter().enumerate() {
            event.check(&format!("operator.event[{index}]"), duration_s)?;
        }
        Ok(())
    }
}

/// Who clears obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clearance {
    /// The robot's own controller.
    Autonomous,
    /// The operator.
    Manual,
}

/// One change of the command; values that it does not contain stay as they are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Conditions for which the event waits.
    pub when: When,
    /// Chassis angle commanded from then on, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chassis_deg: Option<f64>,
    /// Height of the step that RT-Mover is commanded to climb from then on, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
    /// Clearance commanded to Hylos from then on, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// Forward speed commanded from then on, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
    /// Yaw rate commanded from then on, counter-clockwise positive, degrees/s; replaces the heading
    /// control.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_rate_deg_s: Option<f64>,
    /// Whether the belts of B2P2 are released from then on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub belts: Option<Belts>,
    /// Who clears obstacles from then on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<Clearance>,
    /// Request from then on; `arm` until the first one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request: Option<OperatorRequest>,
}

/// What the operator wants of B2P2's belts. Every command repeats it until the next change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Belts {
    /// Taut.
    Taut,
    /// Released by the guard's setting `release_slack`.
    Released,
}

/// What the operator requests in addition to motion. Every command repeats it until the next
/// request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperatorRequest {
    /// Switch all motors off at once.
    Disarm,
    /// Home the drives that need it, then drive.
    Arm,
    /// Stop and hold the position.
    Stop,
    /// Clear latched faults and a trip.
    Reset,
    /// Supervised override of a trip: drive at crawl speed although the guard tripped.
    Override,
    /// Move back from where the guard tripped.
    BackOff,
    /// Emergency stop.
    EmergencyStop,
    /// As [`OperatorRequest::Arm`], and home drives off level ground, too.
    ArmOffLevel,
}

impl OperatorRequest {
    /// The request's code on the bus.
    pub fn code(self) -> Request {
        match self {
            Self::Disarm => Request::Disarm,
            Self::Arm => Request::Arm,
            Self::Stop => Request::Stop,
            Self::Reset => Request::Reset,
            Self::Override => Request::Override,
            Self::BackOff => Request::BackOff,
            Self::EmergencyStop => Request::EmergencyStop,
            Self::ArmOffLevel => Request::ArmOffLevel,
        }
    }

    /// The request as written in a scenario file.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Disarm => "disarm",
            Self::Arm => "arm",
            Self::Stop => "stop",
            Self::Reset => "reset",
            Self::Override => "override",
            Self::BackOff => "back_off",
            Self::EmergencyStop => "emergency_stop",
            Self::ArmOffLevel => "arm_off_level",
        }
    }
}

/// Conditions on what the bus shows. All conditions that are given must hold at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct When {
    /// Virtual time since power-up is at least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Time since the previous event (for the first: since arming) is at least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_s: Option<f64>,
    /// Odometry since arming is at least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_m: Option<f64>,
    /// Odometry since the previous event (for the first: since arming) is at least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_m: Option<f64>,
    /// Pitch is above this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_above_deg: Option<f64>,
    /// Pitch is below this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_below_deg: Option<f64>,
}

impl Event {
    /// Whether no value changes.
    pub fn changes_nothing(&self) -> bool {
        let postures = self.chassis_deg.or(self.step_m).or(self.clearance_m);
        postures
            .or(self.speed_mps)
            .or(self.yaw_rate_deg_s)
            .is_none()
            && self.request.is_none()
            && self.belts.is_none()
            && self.clearance.is_none()
    }

    fn check(&self, key: &str, duration_s: f64) -> Result<(), Problem> {
        if self.when == When::default() {
            return contradiction(
                &format!("{key}.when"),
                "names no condition; give at least one",
            );
        }
        if self.changes_nothing() {
            return contradiction(
                key,
                "changes nothing; give chassis_deg, step_m, clearance_m, speed_mps, \
                 yaw_rate_deg_s, belts, clearance or request",
            );
        }
        let when = &self.when;
        let bounds = [
            ("when.time_s", when.time_s, 0.0, duration_s, "s"),
            ("when.after_s", when.after_s, 0.0, duration_s, "s"),
            ("when.odometry_m", when.odometry_m, -100.0, 1000.0, "m"),
            ("when.after_m", when.after_m, -100.0, 1000.0, "m"),
            (
                "when.pitch_above_deg",
                when.pitch_above_deg,
                -90.0,
                90.0,
                "deg",
            ),
            (
                "when.pitch_below_deg",
                when.pitch_below_deg,
                -90.0,
                90.0,
                "deg",
            ),
            ("step_m", self.step_m, 0.0, 0.3, "m"),
            ("clearance_m", self.clearance_m, 0.1, 0.4, "m"),
            ("speed_mps", self.speed_mps, -1.0, 1.0, "m/s"),
            (
                "yaw_rate_deg_s",
                self.yaw_rate_deg_s,
                -MAXIMUM_YAW_RATE_DEG_S,
                MAXIMUM_YAW_RATE_DEG_S,
                "deg/s",
            ),
        ];
        for (name, value, least, most, unit) in bounds {
            if let Some(value) = value {
                within(&format!("{key}.{name}"), value, least, most, unit)?;
            }
        }
        if let (Some(above), Some(below)) = (when.pitch_above_deg, when.pitch_below_deg)
            && above >= below
        {
            return contradiction(
                &format!("{key}.when"),
                "asks for a pitch above and below that cannot hold at once",
            );
        }
        Ok(())
    }
}
