//! Prints the summary as a few lines for a terminal.

use super::{SETTLED_S, Summary};
use crate::results::zmp::{Figures, PAPER_PERCENT};
use crate::simulator::facts::NodeFacts;
use std::fmt;

impl Summary {
    /// Name and value of each line; the value is `None` if this robot or run has none.
    fn rows(&self) -> impl Iterator<Item = (&'static str, Option<String>)> {
        let outcome = match (self.toppled, self.landing_time_s) {
            (true, _) => "toppled".to_owned(),
            (false, Some(time)) => format!("landed at {time:.2} s"),
            (false, None) => "upright".to_owned(),
        };
        let margin = self
            .min_backward_margin_m
            // The sum turns -0 into 0.
            .map(|margin| libm::round(margin * 1e3) + 0.0)
            .map(|margin| format!("at least {margin} mm to the back"));
        let belt = self.tension_error_m.map(|error| {
            format!(
                "p99 {:.2} mm, max {:.2} mm",
                error.p99 * 1e3,
                error.max * 1e3
            )
        });
        let zero_moment_point = self.zero_moment_point.map(|figures| {
            let Figures { raw, smoothed } = figures;
            format!(
                "mean {:.2} % of the length, peak {:.1} %; smoothed {:.2} %, {:.1} % (paper: mean {PAPER_PERCENT} %)",
                raw.mean, raw.peak, smoothed.mean, smoothed.peak
            )
        });
        // Only a robot with a belt has this line.
        let zero_moment_point = zero_moment_point.or(belt.as_ref().map(|_| "none".to_owned()));
        [
            ("outcome", Some(outcome)),
            (
                "simulated",
                Some(format!(
                    "{:.1} s in {:.1} s, {:.1} x real time",
                    self.simulated_s, self.wall_s, self.realtime_factor
                )),
            ),
            ("nodes", Some(boards(&self.nodes))),
            ("belt error", belt),
            (
                "pitch",
                Some(format!(
                    "{:.1} to {:.1} deg",
                    self.pitch_deg.min, self.pitch_deg.max
                )),
            ),
            ("margin", margin),
            ("|ZMP - CoG|", zero_moment_point),
            (
                "guard",
                Some(format!(
                    "{}, {} scaled, {} refused",
                    counted(self.guard.interventions, "intervention"),
                    self.guard.scaled,
                    self.guard.refused
                )),
            ),
            (
                "bus",
                Some(format!(
                    "load {:.0} % mean, {:.0} % peak; {} frames, worst wait {:.2} ms",
                    self.bus.load_mean * 100.0,
                    self.bus.load_max * 100.0,
                    self.bus.frames,
                    self.bus.worst_latency_ms
                )),
            ),
            ("state hash", Some(self.state_hash.clone())),
        ]
        .into_iter()
    }
}

impl fmt::Display for Summary {
    /// Prints the summary as a few lines for a terminal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} (seed {})", self.scenario, self.seed)?;
        for (name, value) in self.rows() {
            if let Some(value) = value {
                writeln!(f, "  {name:<13} {value}")?;
            }
        }
        for (channel, found) in self.headlines() {
            writeln!(
                f,
                "  {:<13} {}: {:.4}{} in the last {SETTLED_S} s, {:.4} to {:.4} in all",
                "channel",
                channel.name(),
                found.settled,
                channel.suffix(),
                found.min,
                found.max
            )?;
        }
        for sentence in &self.notes {
            writeln!(f, "  {:<13} {sentence}", "note")?;
        }
        for fault in &self.faults {
            let node = fault
                .node
                .map(|node| format!(" on {node}"))
                .unwrap_or_default();
            let noticed = match (&fault.noticed_by, fault.after_ms) {
                (Some(by), Some(after)) => format!("noticed by {by} after {after:.0} ms"),
                _ => "not noticed".to_owned(),
            };
            writeln!(
                f,
                "  {:<13} {}{node} at {:.2} s, {noticed}",
                "fault", fault.what, fault.time_s
            )?;
        }
        for sentence in &self.unmet {
            writeln!(f, "  {:<13} {sentence}", "NOT AS ASKED")?;
        }
        write!(
            f,
            "  {:<13} {}",
            "expectation",
            if self.expectation_met {
                "met"
            } else {
                "NOT met"
            }
        )
    }
}

/// Lists the nodes, grouped by board. A usual run has only one board.
fn boards(nodes: &[NodeFacts]) -> String {
    let mut boards: Vec<(&str, Vec<&str>)> = Vec::new();
    for node in nodes {
        match boards.iter_mut().find(|(board, _)| *board == node.board) {
            Some((_, names)) => names.push(node.name.as_str()),
            None => boards.push((&node.board, vec![node.name.as_str()])),
        }
    }
    let groups = boards
        .iter()
        .map(|(board, names)| format!("{board}: {}", names.join(", ")));
    groups.collect::<Vec<_>>().join("; ")
}

/// A count with its noun: `1 intervention`, `2 interventions`.
pub(super) fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
