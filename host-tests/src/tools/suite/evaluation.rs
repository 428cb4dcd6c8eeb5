//! Evaluates one scenario of the hazard suite from runs with and without the guard.

use super::SuiteError;
use super::interruption::{NOTHING_TO_HOLD, interruption, is_interruption};
use super::lead::Lead;
use crate::programs::Programs;
use crate::results::summary::intervenes;
use crate::scenario::{Description, Scenario};
use crate::simulator::record::Sample;
use crate::simulator::run::{Options, Outcome, run};
use std::cell::Cell;

/// Distance that the guard must take from a motion before it counts as having acted, m. The
/// operator would not notice less.
const FELT_M: f64 = 0.005;
/// Maximum part of the distance that a legitimate run may lose with the guard.
const LARGEST_LOSS: f64 = 0.05;
/// A run ends when the robot has stood still for this time, s. No script waits longer, so nothing
/// more would happen.
const STILL_S: f64 = 3.0;

/// The guard counts as having acted if the passed chassis angle stays behind the commanded one by
/// more than this, rad.
const CHASSIS_LAG: f64 = 5.0 * std::f64::consts::PI / 180.0;

const NO_HAZARD: &str = "no hazard: it does not topple without the guard";
const NOT_LEGITIMATE: &str = "topples without the guard";
const BY_ITSELF: &str = "no hazard: it topples before the operator commands anything";

/// How many runs are made, and how fine the search is, for one scenario.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Thoroughness {
    /// Finds the last saving moment to 0.1 s. Runs legitimate scenarios with and without the guard.
    Full,
    /// Finds the last saving moment to 0.3 s. If the guard saved the robot, letting go when the
    /// guard first acted is assumed to save it too. A legitimate run without interventions is not
    /// repeated without the guard, because nothing would differ.
    Quick,
}

impl Thoroughness {
    fn resolution_s(self) -> f64 {
        match self {
            Self::Full => 0.1,
            Self::Quick => 0.3,
        }
    }
}

/// Result of one scenario.
pub struct Row {
    /// The scenario.
    pub scenario: Scenario,
    /// The figures of its runs.
    pub finding: Finding,
    /// Requirements that were not met; empty if all were.
    pub unmet: Vec<&'static str>,
    /// Virtual time of all its runs, including runs of draws that were rejected, s.
    pub simulated_s: f64,
}

impl Row {
    /// Whether the scenario is what its kind says: a hazard topples without the guard after the
    /// operator commanded something, a legitimate run does not topple without the guard.
    pub fn is_of_its_kind(&self) -> bool {
        let not = [NO_HAZARD, NOT_LEGITIMATE, BY_ITSELF, NOTHING_TO_HOLD];
        !self.unmet.iter().any(|what| not.contains(what))
    }
}

/// Figures of one scenario.
#[derive(Clone, Copy, Debug)]
pub enum Finding {
    /// A run that topples without the guard.
    Hazard {
        /// When the robot toppled without the guard, s.
        toppled_s: Option<f64>,
        /// Whether the robot also toppled with the guard.
        toppled_with_guard: bool,
        /// When the guard had first held back [`FELT_M`] of travel, or the chassis, s.
        acted_s: Option<f64>,
        /// Last time at which letting go saves the robot, s.
        savable_until_s: f64,
        /// Travel of the belts between these two times in the run without the guard, m; negative if
        /// the guard acted later.
        lead_m: f64,
    },
    /// A restart of the guard or a reset, after which the drives must hold the robot.
    Interruption {
        /// When it happened, s.
        interrupted_s: f64,
        /// How far the centre of gravity moved afterwards with the drives switched off, m.
        moved_off_m: f64,
        /// Whether the robot toppled with the drives switched off.
        toppled_off: bool,
        /// How far the centre of gravity moved afterwards with the guard, m.
        moved_m: f64,
        /// Whether the robot toppled with the guard.
        toppled_with_guard: bool,
    },
    /// A run in which the guard must not hinder the operator.
    Legitimate {
        /// Travel of the belts without the guard, m.
        way_m: f64,
        /// Part of this travel that was lost with the guard, 0 to 1.
        loss: f64,
        /// Number of interventions of the guard.
        interventions: usize,
    },
}

/// Makes the runs of one scenario and adds up their virtual time.
pub(super) struct Trials<'a> {
    pub(super) scenario: &'a Scenario,
    programs: &'a Programs,
    simulated_s: Cell<f64>,
}

impl<'a> Trials<'a> {
    pub(super) fn new(scenario: &'a Scenario, programs: &'a Programs) -> Self {
        Self {
            scenario,
            programs,
            simulated_s: Cell::new(0.0),
        }
    }

    /// Runs the scenario with the guard on or off, and returns its samples. From `let_go_s` on, if
    /// given, the operator commands no motion.
    fn samples(&self, guard: bool, let_go_s: Option<f64>) -> Result<Vec<Sample>, SuiteError> {
        let mut description = self.scenario.description();
        description.guard = guard;
        let options = Options {
            let_go_s,
            end_when_still_s: Some(STILL_S),
            ..Options::default()
        };
        Ok(self.outcome(description, options)?.samples)
    }

    /// Runs a changed scenario; the run ends when the robot topples.
    pub(super) fn outcome(
        &self,
        description: Description,
        options: Options,
    ) -> Result<Outcome, SuiteError> {
        let checked = Scenario::checked(description).map_err(SuiteError::Scenario)?;
        let options = Options {
            end_when_toppled: true,
            ..options
        };
        let outcome = run(&checked, self.programs, options)
            .map_err(|error| SuiteError::Run(self.scenario.name.clone(), error))?;
        let simulated_s = outcome.samples.last().map_or(0.0, |sample| sample.time_s);
        self.simulated_s.set(self.simulated_s.get() + simulated_s);
        Ok(outcome)
    }

    /// Makes the row of this scenario. `findings` are pairs of a condition and a text; those whose
    /// condition is true become unmet requirements.
    pub(super) fn row(&self, finding: Finding, findings: &[(bool, &'static str)]) -> Row {
        let unmet = findings.iter().filter(|(bad, _)| *bad);
        Row {
            scenario: self.scenario.clone(),
            finding,
            unmet: unmet.map(|(_, what)| *what).collect(),
            simulated_s: self.simulated_s.get(),
        }
    }

    fn saves(&self, let_go_s: f64) -> Result<bool, SuiteError> {
        Ok(toppled_s(&self.samples(false, Some(let_go_s))?).is_none())
    }

    /// Finds by bisection the last time before `toppled_s` at which letting go saves the robot.
    /// `saves` is a time that is known to save it.
    fn savable_until(
        &self,
        toppled_s: f64,
        saves: Option<f64>,
        resolution_s: f64,
    ) -> Result<f64, SuiteError> {
        let (mut saves, mut fails) = (saves, toppled_s);
        while fails - saves.unwrap_or(0.0) > resolution_s {
            // Letting go very early is the same as not driving at all, so the search starts near
            // the end.
            let probe = saves.map_or((fails - 2.0).max(0.0), |saves| 0.5 * (saves + fails));
            if self.saves(probe)? {
                saves = Some(probe);
            } else {
                fails = probe;
            }
        }
        Ok(saves.unwrap_or(0.0))
    }
}

/// When the robot toppled, s.
pub(super) fn toppled_s(samples: &[Sample]) -> Option<f64> {
    let toppled = samples.iter().find(|sample| sample.truth.toppled);
    toppled.map(|sample| sample.time_s)
}

/// When the guard first held back enough of a motion that the operator notices it, s.
fn acted_s(samples: &[Sample]) -> Option<f64> {
    let (mut before_s, mut lost_m) = (0.0, 0.0);
    let acted = samples.iter().find(|sample| {
        let received = &sample.received;
        let period_s = sample.time_s - before_s;
        before_s = sample.time_s;
        if !intervenes(&received.verdict) {
            return false;
        }
        lost_m += (received.asked_speed - received.passed_speed).abs() * period_s;
        let chassis_waits = (received.asked_theta - received.passed_theta).abs() > CHASSIS_LAG;
        chassis_waits || lost_m > FELT_M
    });
    acted.map(|sample| sample.time_s)
}

/// Evaluates a hazard.
///
/// # Errors
/// [`SuiteError`] if it cannot be run.
pub fn hazard(
    scenario: &Scenario,
    thoroughness: Thoroughness,
    programs: &Programs,
) -> Result<Row, SuiteError> {
    let trials = Trials::new(scenario, programs);
    if is_interruption(scenario) {
        return interruption(&trials);
    }
    let without = trials.samples(false, None)?;
    let Some(toppled_s_without) = toppled_s(&without) else {
        let finding = Finding::Hazard {
            toppled_s: None,
            toppled_with_guard: false,
            acted_s: None,
            savable_until_s: scenario.duration_s,
            lead_m: 0.0,
        };
        return Ok(trials.row(finding, &[(true, NO_HAZARD)]));
    };
    let armed = without
        .iter()
        .find(|sample| sample.received.guard_state == "armed");
    if armed.is_none_or(|armed| armed.time_s >= toppled_s_without) {
        let finding = Finding::Hazard {
            toppled_s: Some(toppled_s_without),
            toppled_with_guard: true,
            acted_s: None,
            savable_until_s: 0.0,
            lead_m: 0.0,
        };
        return Ok(trials.row(finding, &[(true, BY_ITSELF)]));
    }
    let with = trials.samples(true, None)?;
    let acted_s = acted_s(&with);
    let toppled_with_guard = toppled_s(&with).is_some();
    let known = acted_s.filter(|acted| {
        thoroughness == Thoroughness::Quick && !toppled_with_guard && *acted < toppled_s_without
    });
    let savable_until_s =
        trials.savable_until(toppled_s_without, known, thoroughness.resolution_s())?;
    let lead = acted_s.map_or(Lead::default(), |acted| {
        Lead::between(&without, acted, savable_until_s)
    });
    let finding = Finding::Hazard {
        toppled_s: Some(toppled_s_without),
        toppled_with_guard,
        acted_s,
        savable_until_s,
        lead_m: lead.travel_m,
    };
    let findings = [
        (toppled_with_guard, "topples with the guard"),
        (lead.is_too_long(), "the guard acts too early"),
    ];
    Ok(trials.row(finding, &findings))
}

/// Evaluates a legitimate run.
///
/// # Errors
/// [`SuiteError`] if it cannot be run.
pub fn legitimate(
    scenario: &Scenario,
    thoroughness: Thoroughness,
    programs: &Programs,
) -> Result<Row, SuiteError> {
    let trials = Trials::new(scenario, programs);
    let with = trials.samples(true, None)?;
    let interventions = interventions(&with);
    let toppled_with_guard = toppled_s(&with).is_some();
    let alike = interventions == 0 && thoroughness == Thoroughness::Quick;
    let without = if alike {
        None
    } else {
        Some(trials.samples(false, None)?)
    };
    let way = |samples: &[Sample]| {
        samples
            .last()
            .map_or(0.0, |sample| sample.received.odometry)
    };
    let way_m = way(without.as_ref().unwrap_or(&with));
    let loss = if way_m.abs() > 0.01 {
        1.0 - way(&with) / way_m
    } else {
        0.0
    };
    let toppled_without = without
        .as_ref()
        .map_or(toppled_with_guard, |samples| toppled_s(samples).is_some());
    let refused = with
        .iter()
        .any(|sample| sample.received.verdict.starts_with("refused"));
    let finding = Finding::Legitimate {
        way_m,
        loss,
        interventions,
    };
    let findings = [
        (toppled_without, NOT_LEGITIMATE),
        (toppled_with_guard, "topples with the guard"),
        (loss > LARGEST_LOSS, "slower than allowed"),
        (refused, "refused"),
    ];
    Ok(trials.row(finding, &findings))
}

/// Number of times that the guard began to intervene.
fn interventions(samples: &[Sample]) -> usize {
    let mut before = false;
    let mut count = 0;
    for sample in samples {
        let now = intervenes(&sample.received.verdict);
        count += usize::from(now && !before);
        before = now;
    }
    count
}
