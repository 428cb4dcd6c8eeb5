//! Compares a run with what its scenario expects.

use super::Summary;
use super::table::counted;
use crate::scenario::{Expect, Scenario};

impl Summary {
    /// Lists the expectations that the run did not meet, one sentence each.
    pub fn unmet_expectations(&self, scenario: &Scenario) -> Vec<String> {
        let expect = &scenario.expect;
        let mut unmet = Vec::new();
        let mut outcome = |expected: Option<bool>, got: bool, positive: &str, negative: &str| {
            if expected.is_some_and(|expected| expected != got) {
                let (wanted, found) = if got {
                    (negative, positive)
                } else {
                    (positive, negative)
                };
                unmet.push(format!("The robot {found}; expected: {wanted}."));
            }
        };
        let moves = !scenario.operator.client && *expect != Expect::default();
        let armed = expect.armed.or(moves.then_some(true));
        outcome(armed, self.armed, "was armed", "was never armed");
        outcome(expect.landed, self.landed, "landed", "did not land");
        outcome(expect.toppled, self.toppled, "toppled", "did not topple");
        outcome(
            expect.stopped,
            self.stopped,
            "stood still at the end",
            "was moving at the end",
        );
        if let (Some([from, to]), Some(time)) = (expect.landing_between_s, self.landing_time_s)
            && !(from..=to).contains(&time)
        {
            unmet.push(format!(
                "The robot landed at {time:.2} s; expected: between {from} and {to} s."
            ));
        }
        let interventions = self.guard.interventions;
        if expect
            .guard_intervenes
            .is_some_and(|expected| expected != (interventions > 0))
        {
            let expected = if interventions > 0 {
                "none"
            } else {
                "at least one"
            };
            unmet.push(format!(
                "The guard intervened {}; expected: {expected}.",
                counted(interventions, "time")
            ));
        }
        if let Some(bound) = expect.tension_error_below_m
            && let Some(error) = self.tension_error_m
            && error.max >= bound
        {
            let got = error.max * 1e3;
            unmet.push(format!(
                "The belt was off by {got:.2} mm; expected: less than {} mm.",
                bound * 1e3
            ));
        }
        for (index, fault) in scenario.faults.iter().enumerate() {
            let Some(limit) = fault.notice_within_ms else {
                continue;
            };
            let what = fault.what.node().map_or(fault.what.words(), |node| {
                format!("{}: {node}", fault.what.words())
            });
            match self.faults.get(index).and_then(|facts| facts.after_ms) {
                Some(after) if after <= limit => {}
                Some(after) => unmet.push(format!(
                    "Fault \"{what}\" was noticed after {after:.0} ms; expected: {limit} ms."
                )),
                None => unmet.push(format!(
                    "Fault \"{what}\" was never noticed; expected: within {limit} ms."
                )),
            }
        }
        unmet
    }
}
