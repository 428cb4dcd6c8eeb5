//! From when on, and why, the guard holds the robot to the end of a run.

use crate::simulator::record::Sample;

/// State of the guard in which it holds the robot because of a fault.
const HELD: &str = "held";

/// The hold that goes on.
#[derive(Default)]
pub(super) struct Hold {
    since_s: Option<f64>,
    why: Option<String>,
}

impl Hold {
    pub fn add(&mut self, sample: &Sample) {
        let received = &sample.received;
        if received.guard_state != HELD {
            *self = Self::default();
            return;
        }
        self.since_s.get_or_insert(sample.time_s);
        // The guard's report comes with its state, or shortly after it.
        let mut reports = received.events.iter();
        let report = reports.find(|event| !event.injected && event.text.contains("(0x"));
        self.why = self.why.take().or(report.map(|event| event.text.clone()));
    }

    /// The hold in words.
    pub fn note(self) -> Option<String> {
        let (since_s, why) = self.since_s.zip(self.why)?;
        Some(format!("The robot is held from {since_s:.2} s on: {why}."))
    }
}
