//! Evaluates hazards in which the guard restarts, or the operator requests a reset, in the middle
//! of a climb.
//!
//! In these runs the commands are harmless; the danger is that the drives let go. So the comparison
//! is not the run without the filter. It is the same run without the fault, in which the operator
//! disarms at the time of the fault, which switches all drives off. (A guard that holds the robot
//! does not follow that request.) The scenario is a hazard if the robot then topples, or if its
//! centre of gravity moves by more than [`LARGEST_MOVE_M`]. With the guard it must do neither until
//! the end of the run. The operator requests nothing new after the reset or the restart, so nothing
//! may start to drive either.

use super::SuiteError;
use super::evaluation::{Finding, Row, Trials, toppled_s};
use crate::scenario::{Description, FaultKind, OperatorRequest};
use crate::simulator::record::Sample;
use crate::simulator::run::Options;

/// Maximum distance that the centre of gravity may move after the interruption, m: the distance of
/// a stop, plus the settling of the robot from one nose onto the next contact.
pub const LARGEST_MOVE_M: f64 = 0.1;

pub(super) const NOTHING_TO_HOLD: &str =
    "no hazard: it neither topples nor moves with the drives switched off";

/// Whether the scenario contains a restart of the guard or a reset.
pub(super) fn is_interruption(scenario: &Description) -> bool {
    restart_s(scenario).is_some() || reset_event(scenario).is_some()
}

/// When the guard restarts, s.
fn restart_s(scenario: &Description) -> Option<f64> {
    let restarts = |what: &FaultKind| matches!(what, FaultKind::Restart(_));
    let fault = scenario.faults.iter().find(|fault| restarts(&fault.what));
    fault.map(|fault| fault.at_s)
}

/// Number of the event that requests the reset.
fn reset_event(scenario: &Description) -> Option<usize> {
    let mut events = scenario.operator.events.iter();
    events.position(|event| event.request == Some(OperatorRequest::Reset))
}

/// Evaluates a scenario with an interruption.
pub(super) fn interruption(trials: &Trials) -> Result<Row, SuiteError> {
    let scenario = trials.scenario.description();
    let with = trials.outcome(scenario.clone(), Options::default())?;
    let reset_s = || {
        // The first of these times is the start of the script.
        let command = reset_event(&scenario)? + 1;
        with.commands_s.get(command).copied()
    };
    let interrupted_s = restart_s(&scenario).or_else(reset_s);
    let interrupted = interrupted_s.is_some();
    let interrupted_s = interrupted_s.unwrap_or(scenario.duration_s);
    let begins_s = scenario.faults.first().map(|fault| fault.at_s);
    let off_s = begins_s.unwrap_or(interrupted_s);
    let mut without = scenario;
    without.faults.clear();
    let options = Options {
        disarm_s: Some(off_s),
        ..Options::default()
    };
    let off = trials.outcome(without, options)?;
    let moved_off_m = moved_m(&off.samples, off_s);
    let toppled_off = toppled_s(&off.samples).is_some();
    let moved_m = moved_m(&with.samples, interrupted_s);
    let toppled_with_guard = toppled_s(&with.samples).is_some();
    let finding = Finding::Interruption {
        interrupted_s,
        moved_off_m,
        toppled_off,
        moved_m,
        toppled_with_guard,
    };
    let hazard = interrupted && (toppled_off || moved_off_m > LARGEST_MOVE_M);
    let findings = [
        (!hazard, NOTHING_TO_HOLD),
        (toppled_with_guard, "topples with the guard"),
        (
            !(moved_m <= LARGEST_MOVE_M),
            "the drives do not hold the robot",
        ),
    ];
    Ok(trials.row(finding, &findings))
}

/// Maximum distance of the centre of gravity from where it was at `from_s`, m.
fn moved_m(samples: &[Sample], from_s: f64) -> f64 {
    let mut later = samples.iter().filter(|sample| sample.time_s >= from_s);
    let Some(start) = later.next().map(|sample| sample.truth.cog) else {
        return 0.0;
    };
    later.fold(0.0, |most, sample| {
        let offset = [0, 1, 2].map(|axis| sample.truth.cog[axis] - start[axis]);
        let distance = offset.iter().map(|it| it * it).sum::<f64>().sqrt();
        if distance > most { distance } else { most }
    })
}
