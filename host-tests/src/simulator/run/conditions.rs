//! Conditions that end a run.

use super::Options;
use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tautrack::link::STEP_US;

/// Speeds below which the robot counts as standing still, m/s and rad/s.
const STILL_MPS: f64 = 0.005;
const STILL_RADPS: f64 = 0.02;

/// Conditions that end a run.
pub(super) struct Conditions {
    pub steps: u64,
    pub toppled: bool,
    pub still_s: f64,
    pub client_operates: bool,
    pub interrupt: Option<Arc<AtomicBool>>,
}

impl Conditions {
    pub fn of(scenario: &Scenario, options: &Options) -> Self {
        Self {
            steps: (scenario.duration_s * 1e6) as u64 / STEP_US,
            toppled: options.end_when_toppled,
            still_s: options.end_when_still_s.unwrap_or(f64::INFINITY),
            client_operates: scenario.operator.client,
            interrupt: options.interrupt.clone(),
        }
    }

    pub fn interrupted(&self) -> bool {
        let set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        self.interrupt.as_ref().is_some_and(set)
    }
}

/// Whether an armed robot, its belts and its joint stood still since the sample before, which had
/// the chassis angle `theta_before`, rad.
pub(super) fn is_still(theta_before: Option<f64>, now: &Sample) -> bool {
    let truth = &now.truth;
    let speeds = [truth.ground_speed, truth.belt_speed[0], truth.belt_speed[1]];
    let turned = theta_before.map_or(f64::INFINITY, |before| truth.theta - before);
    now.received.guard_state == "armed"
        && speeds.iter().all(|speed| speed.abs() < STILL_MPS)
        && truth.pitch_rate.abs() < STILL_RADPS
        && turned.abs() * f64::from(SAMPLE_HZ) < STILL_RADPS
}
