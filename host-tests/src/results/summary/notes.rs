//! Explains figures that could look like contradictions.

use super::Summary;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use tautrack::stability::support::NO_EDGE;

/// A smaller margin needs an explanation, m or rad.
const NARROW: f64 = 0.01;

/// The guard's minimum margin to an existing edge, m; `None` if the guard is not armed or has none.
pub(super) fn guard_margin(sample: &Sample) -> Option<f64> {
    let received = &sample.received;
    let margins = received.margins.filter(|_| received.guard_state == "armed");
    margins
        .into_iter()
        .flatten()
        .filter(|margin| *margin < f64::from(NO_EDGE))
        .reduce(f64::min)
}

impl Summary {
    /// Minimum margin in the simulator's ground truth: name, value and unit.
    fn true_margin(&self) -> Option<(String, f64, &'static str)> {
        let backward = self
            .min_backward_margin_m
            .map(|margin| ("rear margin".to_owned(), margin, "m"));
        let channels = self
            .headlines()
            .filter(|(channel, _)| channel.title.to_lowercase().contains("margin"))
            .map(|(channel, found)| (channel.title.to_lowercase(), found.min, channel.unit));
        backward
            .into_iter()
            .chain(channels)
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Explains each figure that needs it, in one sentence or more.
    pub(super) fn explanations(&self, scenario: &Scenario) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some((name, margin, unit)) = self.true_margin()
            && margin < NARROW
            && self.guard.interventions == 0
        {
            let place = if margin < 0.0 {
                "outside"
            } else {
                "over the edge of"
            };
            let what = format!(
                "The least {name} in the ground truth is {margin:.3} {unit}: for a moment the centre of gravity was {place} the points \
                 that carried force."
            );
            let why = match self.min_guard_margin_m {
                _ if !scenario.guard => {
                    "The guard's filter is switched off, so it did not intervene.".to_owned()
                }
                Some(estimate) => format!(
                    "The guard did not intervene: it limits commands by its own estimate, which was at least {estimate:.3} m while it was armed."
                ),
                None => "The guard did not intervene: it had no estimate of its own.".to_owned(),
            };
            notes.push(format!("{what} {why}"));
        }
        notes
    }
}
