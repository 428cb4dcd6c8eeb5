//! Checks the bounds of a scenario, except those of the operator, the robots and the ground.

use super::{Description, Fault, FaultKind, Scenario, frame, hand};
use crate::bounds::{Problem, contradiction, within};
use crate::robots::{Kind, NodeName, Posture};
use tautrack::can::Frame;
use tautrack::link::MAX_SETTINGS;
use tautrack::settings::{Description as Bounds, Setting};

const CLEARS: &str = "is for B2P2, which can clear obstacles by itself";

impl Description {
    /// Checks every value.
    ///
    /// # Errors
    /// Names key, value and bound of the first bad one.
    pub fn check(self) -> Result<Scenario, Problem> {
        text("name", &self.name)?;
        text("about", &self.about)?;
        within("duration_s", self.duration_s, 0.1, 3600.0, "s")?;
        within("friction", self.friction, 0.05, 3.0, "")?;
        let robot = self.robot.section();
        robot.check(&self.conditions())?;
        self.terrain.check(robot.front_m())?;
        self.operator.check(self.duration_s)?;
        for (index, fault) in self.faults.iter().enumerate() {
            let key = format!("fault[{index}]");
            fault.check(&key, self.duration_s)?;
            let nodes = self.kind().facts().nodes;
            let has = |befallen: NodeName| nodes.iter().any(|(name, _)| *name == befallen);
            if fault.what.node().is_some_and(|node| !has(node)) {
                let why = "is about a node that this robot does not have";
                contradiction(&format!("{key}.what"), why)?;
            }
            let track = match fault.what {
                FaultKind::BeltOff(track) | FaultKind::SlipperyTrack { track, .. } => Some(track),
                _ => None,
            };
            let tracks = [NodeName::LEFT_TRACK, NodeName::RIGHT_TRACK];
            if track.is_some_and(|it| self.kind() != Kind::B2p2 || !tracks.contains(&it)) {
                contradiction(&format!("{key}.what"), "is for the tracks of B2P2")?;
            }
        }
        frame::check(&self.frames)?;
        self.sensors.check()?;
        hand::check(&self.hand, self.kind(), self.duration_s)?;
        self.check_postures()?;
        self.check_motors()?;
        self.check_settings()?;
        self.check_expectations()?;
        Ok(Scenario(self))
    }

    /// Checks that the operator commands only the posture that this robot has: chassis angle,
    /// clearance, step height or none, and releases belts only of a robot with a screw.
    fn check_postures(&self) -> Result<(), Problem> {
        let posture = self.robot.section().posture();
        let step = posture == Posture::Step;
        let travel = match posture {
            Posture::ChassisAngle { travel } => Some(travel),
            _ => None,
        };
        let chassis = |key: &str, angle_deg| match travel.map(|ends| ends.map(f64::to_degrees)) {
            Some([least, most]) => {
                let unit = "deg (the travel of the chassis joint)";
                within(key, angle_deg, least, most, unit)
            }
            None => contradiction(key, "is no posture of this robot"),
        };
        if self.operator.chassis_deg != 0.0 {
            chassis("operator.chassis_deg", self.operator.chassis_deg)?;
        }
        if self.operator.step_m != 0.0 && !step {
            return contradiction("operator.step_m", "is no posture of this robot");
        }
        if self.operator.belts.is_some() && travel.is_none() {
            return contradiction(
                "operator.belts",
                "is for a robot with a screw, which can release its belts",
            );
        }
        if self.operator.clearance.is_some() && travel.is_none() {
            return contradiction("operator.clearance", CLEARS);
        }
        for (index, event) in self.operator.events.iter().enumerate() {
            if event.clearance.is_some() && travel.is_none() {
                let key = format!("operator.event[{index}].clearance");
                return contradiction(&key, CLEARS);
            }
            if event.belts.is_some() && travel.is_none() {
                let key = format!("operator.event[{index}].belts");
                return contradiction(
                    &key,
                    "is for a robot with a screw, which can release its belts",
                );
            }
            if let Some(angle_deg) = event.chassis_deg {
                chassis(&format!("operator.event[{index}].chassis_deg"), angle_deg)?;
            }
            let given = [
                (
                    "clearance_m",
                    event.clearance_m,
                    matches!(posture, Posture::Clearance { .. }),
                ),
                ("step_m", event.step_m, step),
            ];
            for (key, value, fits) in given {
                if value.is_some() && !fits {
                    let key = format!("operator.event[{index}].{key}");
                    return contradiction(&key, "is no posture of this robot");
                }
            }
        }
        Ok(())
    }

    /// Checks that every motor belongs to a drive of the robot, and that its values are within
    /// their bounds.
    fn check_motors(&self) -> Result<(), Problem> {
        let nodes = self.robot.section().nodes(&self.conditions());
        for (name, motor) in &self.motors {
            let table = format!("motor.{name}");
            let Some(node) = nodes.iter().find(|node| node.name == *name) else {
                return contradiction(&table, "is a node that this robot does not have");
            };
            match &node.motor {
                Some(model) => motor.check(&table, model)?,
                None => return contradiction(&table, "is the guard, which has no motor"),
            }
        }
        Ok(())
    }

    /// Checks that every setting belongs to a node of the robot, exists and is within its bounds,
    /// and that the node takes as many settings as the scenario and the robot give it.
    fn check_settings(&self) -> Result<(), Problem> {
        let nodes = self.nodes();
        for (name, changes) in &self.settings {
            let table = format!("settings.{name}");
            let Some(node) = nodes.iter().find(|node| node.name == *name) else {
                return contradiction(&table, "is a node that this robot does not have");
            };
            for (name, value) in changes {
                let key = format!("{table}.{name}");
                let Some(setting) = Setting::from_name(name) else {
                    return contradiction(&key, "is no setting; docs/settings.md has them all");
                };
                if [Setting::NodeId, Setting::FilterActive].contains(&setting) {
                    return contradiction(&key, "is what the scenario and its robot say elsewhere");
                }
                let Bounds {
                    minimum,
                    maximum,
                    unit,
                    ..
                } = setting.description();
                let [least, most] = [*minimum, *maximum].map(f64::from);
                within(&key, f64::from(*value), least, most, unit)?;
            }
            if node.settings.len() >= MAX_SETTINGS {
                return contradiction(&table, "and the robot have more settings than a node takes");
            }
        }
        Ok(())
    }

    fn check_expectations(&self) -> Result<(), Problem> {
        let expect = &self.expect;
        if self.terrain.last_nose_m().is_none() && expect.landed == Some(true) {
            return contradiction(
                "expect.landed",
                "is true, but this terrain has no nose to land behind",
            );
        }
        if let Some([earliest, latest]) = expect.landing_between_s {
            within(
                "expect.landing_between_s[0]",
                earliest,
                0.0,
                self.duration_s,
                "s",
            )?;
            within(
                "expect.landing_between_s[1]",
                latest,
                earliest,
                self.duration_s,
                "s",
            )?;
            if expect.landed != Some(true) {
                return contradiction(
                    "expect.landing_between_s",
                    "needs `landed = true` beside it",
                );
            }
        }
        if expect.guard_intervenes == Some(true) && !self.guard {
            return contradiction("expect.guard_intervenes", "is true, but the guard is off");
        }
        expect.tension_error_below_m.map_or(Ok(()), |bound| {
            within("expect.tension_error_below_m", bound, 1e-6, 1.0, "m")
        })
    }
}

impl Fault {
    fn check(&self, key: &str, duration_s: f64) -> Result<(), Problem> {
        within(
            &format!("{key}.at_s"),
            self.at_s,
            0.0,
            duration_s,
            "s (the run ends there)",
        )?;
        if let Some(until) = self.until_s {
            within(
                &format!("{key}.until_s"),
                until,
                self.at_s,
                f64::MAX,
                "s (the fault begins there)",
            )?;
        }
        if let Some(limit) = self.notice_within_ms {
            within(
                &format!("{key}.notice_within_ms"),
                limit,
                1.0,
                60_000.0,
                "ms",
            )?;
        }
        let id_within =
            |key: &str, id: u16| within(key, f64::from(id), 0.0, f64::from(Frame::MAX_ID), "");
        match self.what {
            FaultKind::FrameLoss { probability } => within(
                &format!("{key}.what.frame_loss.probability"),
                probability,
                0.0,
                1.0,
                "",
            ),
            FaultKind::FrameFlip { id, bit, .. } => {
                let key = format!("{key}.what.frame_flip");
                id_within(&format!("{key}.id"), id.unwrap_or(0))?;
                within(&format!("{key}.bit"), f64::from(bit), 0.0, 63.0, "")
            }
            FaultKind::Forger {
                id,
                ref data,
                period_ms,
            } => {
                let key = format!("{key}.what.forger");
                id_within(&format!("{key}.id"), id)?;
                let length = data.len() as f64;
                within(&format!("{key}.data"), length, 0.0, 8.0, "bytes")?;
                let period = period_ms as f64;
                within(&format!("{key}.period_ms"), period, 1.0, 60_000.0, "ms")
            }
            FaultKind::SwitchStuck {
                node: NodeName::GUARD,
                ..
            } => contradiction(
                &format!("{key}.what.switch_stuck.node"),
                "is the guard, which has no switches",
            ),
            FaultKind::SlipperyTrack { friction, .. } => {
                let key = format!("{key}.what.slippery_track.friction");
                within(&key, friction, 0.0, 3.0, "")
            }
            FaultKind::EncoderFrozen(NodeName::GUARD) => contradiction(
                &format!("{key}.what.encoder_frozen"),
                "is the guard, which has no encoder",
            ),
            _ => Ok(()),
        }
    }
}

fn text(key: &str, value: &str) -> Result<(), Problem> {
    if value.trim().is_empty() {
        contradiction(key, "is empty")
    } else {
        Ok(())
    }
}
