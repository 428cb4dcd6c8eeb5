//! The bounds of a scenario, except the operator's and those of the other robots' sections.

use super::{Description, Fault, FaultKind, Payload, Problem, Robot, Scenario, Terrain};
use crate::plant::b2p2::B2p2Parameters;
use crate::plant::crawler::CrawlerParameters;
use tautrack::robots::rt_mover::parameters::{BODY_LENGTH, WHEEL_RADIUS};

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
        self.robot.check()?;
        self.terrain.check(self.front_m())?;
        self.operator.check(self.duration_s)?;
        for (index, fault) in self.faults.iter().enumerate() {
            fault.check(&format!("fault[{index}]"), self.duration_s)?;
        }
        if let Some(payload) = &self.robot.payload {
            payload.check("robot.payload", self.duration_s)?;
        }
        if let Some(hylos) = &self.hylos {
            hylos.check(&self)?;
        } else if let Terrain::Hillside { .. } = self.terrain {
            contradiction("terrain", "is a hillside, which only Hylos' plant has")?;
        }
        if let Some(crawler) = &self.crawler {
            crawler.check(&self)?;
        }
        if let Some(robot) = &self.rt_mover {
            robot.check(&self)?;
        }
        self.check_expectations()?;
        Ok(Scenario(self))
    }

    /// Foremost point of the robot at the start.
    fn front_m(&self) -> f64 {
        if self.crawler.is_some() {
            0.5 * CrawlerParameters::nominal().extent[0]
        } else if self.rt_mover.is_some() {
            0.5 * BODY_LENGTH + WHEEL_RADIUS
        } else {
            self.robot.front_m()
        }
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

impl Robot {
    fn check(&self) -> Result<(), Problem> {
        let B2p2Parameters { l1, l2, .. } = B2p2Parameters::nominal();
        // From `L1 + 2 L2` on the extension is never negative; from `K / L1` = 2.4 on the screw's stated errors hold.
        let least_k = f64::max(l1 + 2.0 * l2, 2.4 * l1);
        within(
            "robot.k_m",
            self.k_m,
            least_k,
            2.0,
            "m (the least is L1 + 2 L2 and 2.4 L1 of the robot)",
        )?;
        within(
            "robot.pulley_radius_m",
            self.pulley_radius_m,
            0.01,
            0.15,
            "m",
        )?;
        within("robot.com_offset_m", self.com_offset_m, -0.2, 0.2, "m")?;
        within("robot.sensor_noise", self.sensor_noise, 0.0, 100.0, "")?;
        Ok(())
    }

    /// Foremost point of the robot at the start, for any chassis angle: straight, axle 3 is at `(K + L1) / 2`.
    fn front_m(&self) -> f64 {
        f64::midpoint(self.k_m, self.parameters().l1) + self.pulley_radius_m
    }
}

impl Payload {
    /// `key` is the path of its table.
    pub(super) fn check(&self, key: &str, duration_s: f64) -> Result<(), Problem> {
        within(&format!("{key}.mass_kg"), self.mass_kg, 0.0, 50.0, "kg")?;
        for (index, coordinate) in self.place_m.iter().enumerate() {
            within(
                &format!("{key}.place_m[{index}]"),
                *coordinate,
                -1.0,
                1.0,
                "m",
            )?;
        }
        within(&format!("{key}.from_s"), self.from_s, 0.0, duration_s, "s")
    }
}

impl Terrain {
    fn check(&self, front_m: f64) -> Result<(), Problem> {
        let ahead = |key: &str, x: f64| {
            let unit = "m (the least is where the robot's front stands at the start)";
            within(key, x, front_m, 50.0, unit)
        };
        match *self {
            Self::Flat => Ok(()),
            Self::Stairs {
                riser_m,
                run_m,
                count,
                width_m,
                first_nose_m,
                landing_m,
                down: _,
            } => {
                within("terrain.stairs.riser_m", riser_m, 0.01, 0.5, "m")?;
                within("terrain.stairs.run_m", run_m, 0.05, 2.0, "m")?;
                within("terrain.stairs.count", f64::from(count), 1.0, 20.0, "")?;
                within("terrain.stairs.width_m", width_m, 0.8, 20.0, "m")?;
                within("terrain.stairs.landing_m", landing_m, 0.5, 50.0, "m")?;
                ahead("terrain.stairs.first_nose_m", first_nose_m)
            }
            Self::Curb {
                height_m,
                nose_m,
                depth_m,
            } => {
                within("terrain.curb.height_m", height_m, 0.01, 0.5, "m")?;
                within("terrain.curb.depth_m", depth_m, 0.05, 50.0, "m")?;
                ahead("terrain.curb.nose_m", nose_m)
            }
            Self::Ramp {
                angle_deg,
                foot_m,
                length_m,
            } => {
                within("terrain.ramp.angle_deg", angle_deg, 0.0, 75.0, "deg")?;
                within("terrain.ramp.length_m", length_m, 0.1, 50.0, "m")?;
                ahead("terrain.ramp.foot_m", foot_m)
            }
            Self::Hillside {
                slope_deg,
                foot_m,
                wave_height_m,
            } => {
                within("terrain.hillside.slope_deg", slope_deg, 0.0, 60.0, "deg")?;
                within("terrain.hillside.foot_m", foot_m, 1.0, 6.0, "m")?;
                within(
                    "terrain.hillside.wave_height_m",
                    wave_height_m,
                    0.0,
                    0.1,
                    "m",
                )
            }
            Self::Slope {
                angle_deg,
                side_deg,
            } => {
                within("terrain.slope.angle_deg", angle_deg, -75.0, 75.0, "deg")?;
                within("terrain.slope.side_deg", side_deg, -75.0, 75.0, "deg")
            }
        }
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
        match self.what {
            FaultKind::FrameLoss { probability } => within(
                &format!("{key}.what.frame_loss.probability"),
                probability,
                0.0,
                1.0,
                "",
            ),
            FaultKind::FrameFlip { bit, .. } => within(
                &format!("{key}.what.frame_flip.bit"),
                f64::from(bit),
                0.0,
                63.0,
                "",
            ),
            FaultKind::EncoderFrozen(super::NodeName::Guard) => contradiction(
                &format!("{key}.what.encoder_frozen"),
                "is the guard, which has no encoder",
            ),
            FaultKind::Restart(node) if node != super::NodeName::Guard => contradiction(
                &format!("{key}.what.restart"),
                "is a drive, whose rotor turns on while its node restarts; only the guard can",
            ),
            _ => Ok(()),
        }
    }
}

/// Checks a chassis angle.
pub(super) fn chassis(key: &str, angle_deg: f64) -> Result<(), Problem> {
    let [least, most] = B2p2Parameters::nominal().joint_travel.map(f64::to_degrees);
    within(
        key,
        angle_deg,
        least,
        most,
        "deg (the travel of the chassis joint)",
    )
}

/// Bounds included. A NaN or infinity is told apart, because its bound is not the point.
pub(super) fn within(
    key: &str,
    got: f64,
    least: f64,
    most: f64,
    unit: &'static str,
) -> Result<(), Problem> {
    let key = || key.to_owned();
    if !got.is_finite() {
        Err(Problem::NotFinite { key: key(), got })
    } else if got < least {
        Err(Problem::BelowLeast {
            key: key(),
            got,
            least,
            unit,
        })
    } else if got > most {
        Err(Problem::AboveMost {
            key: key(),
            got,
            most,
            unit,
        })
    } else {
        Ok(())
    }
}

fn text(key: &str, value: &str) -> Result<(), Problem> {
    if value.trim().is_empty() {
        contradiction(key, "is empty")
    } else {
        Ok(())
    }
}

pub(super) fn contradiction(key: &str, why: &'static str) -> Result<(), Problem> {
    Err(Problem::Contradiction {
        key: key.to_owned(),
        why,
    })
}
