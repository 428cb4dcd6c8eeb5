//! Collects the marks of the time line.

use crate::results::summary::{Summary, intervenes};
use crate::scenario::Scenario;
use crate::simulator::record::{Level, Sample};
use serde::Serialize;

/// Maximum number of marks of interventions and bus events in the page. Further ones are only
/// counted.
const MOST_MARKS: usize = 300;

/// A mark of the time line.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Mark {
    #[serde(rename = "t")]
    time_s: f64,
    kind: &'static str,
    text: String,
}

/// Marks of a run that goes on: interventions of the guard and events on the bus.
#[derive(Default)]
pub(super) struct Marks {
    found: Vec<Mark>,
    /// Number of marks that were left out. Injected faults, landing and toppling are never left
    /// out.
    pub left_out: usize,
    /// The last verdict.
    verdict: String,
    toppled_s: Option<f64>,
}

impl Marks {
    pub fn add(&mut self, sample: &Sample) {
        let received = &sample.received;
        if received.verdict != self.verdict {
            received.verdict.clone_into(&mut self.verdict);
            if intervenes(&received.verdict) {
                self.put(sample.time_s, "guard", &received.verdict);
            }
        }
        // An injected fault gets its own mark at the end.
        for event in received.events.iter().filter(|event| !event.injected) {
            let kind = match event.level {
                Level::Info => "event",
                Level::Warning => "warning",
                Level::Error => "error",
            };
            self.put(sample.time_s, kind, &event.text);
        }
        if sample.truth.toppled {
            self.toppled_s = self.toppled_s.or(Some(sample.time_s));
        }
    }

    fn put(&mut self, time_s: f64, kind: &'static str, text: &str) {
        if self.found.len() < MOST_MARKS {
            self.found.push(mark(time_s, kind, text));
        } else {
            self.left_out += 1;
        }
    }

    /// All marks in order of time, with injected faults, landing and toppling.
    pub fn all(&self, scenario: &Scenario, summary: &Summary) -> Vec<Mark> {
        let mut found = self.found.clone();
        for fault in &scenario.faults {
            let node = fault
                .what
                .node()
                .map(|node| format!(": {node}"))
                .unwrap_or_default();
            let text = format!("Injected: {}{node}", fault.what.words());
            found.push(mark(fault.at_s, "fault", &text));
        }
        if let Some(time_s) = summary.landing_time_s {
            found.push(mark(time_s, "good", "Landed: level behind the last nose"));
        }
        if let Some(time_s) = self.toppled_s {
            found.push(mark(time_s, "fault", "Toppled"));
        }
        found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        found
    }
}

fn mark(time_s: f64, kind: &'static str, text: &str) -> Mark {
    Mark {
        time_s,
        kind,
        text: text.to_owned(),
    }
}
