//! Answers the requests of the page. Every request and every answer is JSON.

use super::request::Request;
use super::{Drive, scene};
use crate::results::scene::{ground, still};
use crate::scenario::{Description, Scenario};
use crate::simulator::record::{BusFrame, Sample};
use crate::simulator::run::{Sink, Unwritten};
use serde_json::{Value, json};

/// Number of steps for which a run continues after the robot has toppled or a part has come off it.
const AFTERWARDS: u64 = 500;
/// A run ends when the centre of gravity is this close to the end of the ground, m.
const EDGE: f64 = 0.8;

/// The page's simulator, with one run at a time.
#[derive(Default)]
pub struct Session {
    going: Option<Going>,
}

/// The run.
struct Going {
    drive: Drive,
    /// Number of its last step.
    end: u64,
    /// Minimum and maximum of x, then of y, of the ground; `None` if it has no end.
    extent: Option<[[f64; 2]; 2]>,
    heard: Heard,
}

/// Frames and log lines since the last answer.
#[derive(Default)]
struct Heard {
    listens: bool,
    frames: Vec<BusFrame>,
    log: Vec<String>,
}

impl Sink for Heard {
    fn sample(&mut self, _: Sample) -> Result<(), Unwritten> {
        Ok(())
    }

    fn frame(&mut self, frame: &BusFrame) -> Result<(), Unwritten> {
        if self.listens {
            self.frames.push(*frame);
        }
        Ok(())
    }

    fn log(&mut self, line: &str) -> Result<(), Unwritten> {
        self.log.push(line.to_owned());
        Ok(())
    }
}

impl Session {
    /// Answers a request. An error is `{"error": TEXT}`.
    pub fn answer(&mut self, request: &[u8]) -> Vec<u8> {
        let answer = serde_json::from_slice(request)
            .map_err(|error| error.to_string())
            .and_then(|request| self.act(request));
        let answer = answer.unwrap_or_else(|error| json!({ "error": error }));
        serde_json::to_vec(&answer).unwrap_or_default()
    }

    fn act(&mut self, request: Request) -> Result<Value, String> {
        if let Request::Start {
            scenario,
            changes,
            person,
        } = request
        {
            return self.start(&scenario, &changes, person);
        }
        let going = self.going.as_mut().ok_or("no run has been started")?;
        let drive = &mut going.drive;
        match request {
            Request::Start { .. } => {}
            Request::Advance(steps) => return going.advance(steps),
            Request::Bus(steps) => {
                going.run(steps)?;
                return Ok(scene::frames(&mut going.heard.frames));
            }
            Request::Command(command) => drive.command(command),
            Request::Ask(request) => drive.request(request),
            Request::Break(what) => drive.break_it(what)?,
            Request::Mend(what) => drive.mend(&what),
            Request::Send { id, data } => drive.send(id, data)?,
            Request::Listen(listens) => going.heard.listens = listens,
            Request::Ground { area, cell } => {
                return Ok(ground(drive.plant(), area, cell));
            }
            Request::Save => {
                return Ok(json!({ "scenario": drive.save()?, "hash": drive.hash() }));
            }
        }
        Ok(Value::Null)
    }

    fn start(&mut self, text: &str, changes: &Value, person: bool) -> Result<Value, String> {
        let mut scenario = Scenario::parse(text, "scenario").map_err(|error| error.to_string())?;
        if !changes.is_null() {
            let mut whole = serde_json::to_value(&scenario).map_err(|error| error.to_string())?;
            merge(&mut whole, changes);
            let changed: Description =
                serde_json::from_value(whole).map_err(|error| error.to_string())?;
            scenario = Scenario::checked(changed).map_err(|error| error.to_string())?;
        }
        self.going = None;
        let drive = Drive::start(&scenario, person)?;
        let still = still(&scenario, drive.plant());
        self.going = Some(Going {
            end: (drive.recorded().duration_s * 1e3) as u64,
            extent: scenario.robot.section().extent(&scenario.terrain),
            drive,
            heard: Heard::default(),
        });
        Ok(still)
    }
}

impl Going {
    fn advance(&mut self, steps: u64) -> Result<Value, String> {
        self.run(steps)?;
        let mut state = scene::state(&mut self.drive);
        state["log"] = std::mem::take(&mut self.heard.log).into();
        state["ended"] = (self.drive.steps() >= self.end).into();
        Ok(state)
    }

    fn run(&mut self, steps: u64) -> Result<(), String> {
        let until = self.drive.steps().saturating_add(steps);
        while self.drive.steps() < until.min(self.end) {
            self.drive
                .step(&mut self.heard)
                .map_err(|error| error.to_string())?;
            let truth = self.drive.plant().truth();
            if truth.toppled || truth.came_off.is_some() {
                self.end = self.end.min(self.drive.steps() + AFTERWARDS);
            }
            let leaves =
                |([from, to], place): ([f64; 2], f64)| !(from + EDGE..to - EDGE).contains(&place);
            let extent = self.extent.into_iter().flatten();
            if extent.zip(truth.cog).any(leaves) {
                self.end = self.drive.steps();
            }
        }
        Ok(())
    }
}

/// Applies a merge patch (RFC 7396).
fn merge(into: &mut Value, patch: &Value) {
    let Value::Object(changes) = patch else {
        *into = patch.clone();
        return;
    };
    if !into.is_object() {
        *into = json!({});
    }
    for (key, change) in changes {
        if let Value::Object(into) = &mut *into {
            if change.is_null() {
                into.remove(key);
            } else {
                merge(into.entry(key.clone()).or_insert(Value::Null), change);
            }
        }
    }
}
