//! Formats the results of the hazard suite as Markdown.

use super::draw::Kind;
use super::evaluation::{Finding, Row};
use super::{Drawn, Findings};
use std::fmt::Write;

/// Tables of hazards, interruptions and legitimate runs with a line for each named scenario, then
/// one of the drawn scenarios with a line for each kind, and one with those that do not hold.
pub fn table(findings: &Findings) -> String {
    let mut text = hazards(&findings.named);
    text.push_str(&interruptions(&findings.named));
    text.push_str(&legitimate(&findings.named));
    if findings.drawn.iter().any(|drawn| !drawn.rows.is_empty()) {
        text.push_str(&random(findings));
    }
    text
}

/// `holds`, or the unmet requirements.
pub fn verdict(row: &Row) -> String {
    if row.unmet.is_empty() {
        "holds".into()
    } else {
        row.unmet.join(", ")
    }
}

fn seconds(time_s: Option<f64>) -> String {
    time_s.map_or_else(|| "never".into(), |time_s| format!("{time_s:.1} s"))
}

// Below, results of `writeln!` are ignored because writing to a string cannot fail.

fn hazards(rows: &[Row]) -> String {
    let mut text = String::from(
        "| hazard | topples without | with the guard | guard acts | letting go saves until | lead | |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        if let Finding::Hazard {
            toppled_s,
            toppled_with_guard,
            acted_s,
            savable_until_s,
            lead_m,
        } = row.finding
        {
            let with = if toppled_with_guard {
                "topples"
            } else {
                "stands"
            };
            let (without, acted) = (seconds(toppled_s), seconds(acted_s));
            let _ = writeln!(
                text,
                "| {} | {without} | {with} | {acted} | {savable_until_s:.1} s | {:.0} mm | {} |",
                row.scenario.name,
                // Adding 0 turns a negative zero into a positive one.
                (lead_m * 1e3).round() + 0.0,
                verdict(row)
            );
        }
    }
    text
}

fn interruptions(rows: &[Row]) -> String {
    let mut text = String::from(
        "\n| restart or reset on stairs | at | drives switched off | with the guard | |\n|---|---|---|---|---|\n",
    );
    for row in rows {
        if let Finding::Interruption {
            interrupted_s,
            moved_off_m,
            toppled_off,
            moved_m,
            toppled_with_guard,
        } = row.finding
        {
            let words = |moved_m: f64, toppled: bool| {
                let toppled = if toppled { ", topples" } else { "" };
                format!("moves {:.0} mm{toppled}", moved_m * 1e3)
            };
            let (off, with) = (
                words(moved_off_m, toppled_off),
                words(moved_m, toppled_with_guard),
            );
            let _ = writeln!(
                text,
                "| {} | {interrupted_s:.1} s | {off} | {with} | {} |",
                row.scenario.name,
                verdict(row)
            );
        }
    }
    text
}

fn legitimate(rows: &[Row]) -> String {
    let mut text = String::from(
        "\n| legitimate run | travel | lost with the guard | interventions | |\n|---|---|---|---|---|\n",
    );
    for row in rows {
        if let Finding::Legitimate {
            way_m,
            loss,
            interventions,
        } = row.finding
        {
            let _ = writeln!(
                text,
                "| {} | {way_m:.2} m | {:.1} % | {interventions} | {} |",
                row.scenario.name,
                loss * 100.0,
                verdict(row)
            );
        }
    }
    text
}

fn random(findings: &Findings) -> String {
    let mut text = format!(
        "\n| drawn at random (seed {}) | held | drawn again | largest lead | largest loss | refused or scaled |\n|---|---|---|---|---|---|\n",
        findings.seed
    );
    for (drawn, kind) in findings.drawn.iter().zip(Kind::ALL) {
        let _ = writeln!(text, "{}", summary(drawn, kind));
    }
    let failures: Vec<_> = findings
        .drawn
        .iter()
        .flat_map(|drawn| &drawn.rows)
        .filter(|row| !row.unmet.is_empty())
        .collect();
    if !failures.is_empty() {
        text.push_str("\n| does not hold | | what |\n|---|---|---|\n");
    }
    for row in failures {
        let Row { scenario, .. } = row;
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            scenario.name,
            scenario.about,
            verdict(row)
        );
    }
    text
}

/// The line of one kind of drawn scenarios.
fn summary(drawn: &Drawn, kind: Kind) -> String {
    let held = drawn.rows.iter().filter(|row| row.unmet.is_empty()).count();
    let (mut lead, mut loss, mut touched) = (None, None, 0);
    for row in &drawn.rows {
        match row.finding {
            Finding::Hazard {
                lead_m,
                acted_s: Some(_),
                ..
            } => {
                lead = Some(lead.map_or(lead_m, |most: f64| most.max(lead_m)));
                touched += 1;
            }
            Finding::Hazard { .. } | Finding::Interruption { .. } => {}
            Finding::Legitimate {
                loss: share,
                interventions,
                ..
            } => {
                loss = Some(loss.map_or(share, |most: f64| most.max(share)));
                touched += usize::from(interventions > 0);
            }
        }
    }
    let figure = |value: Option<f64>, factor: f64, unit: &str| {
        value.map_or_else(String::new, |value| format!("{:.1} {unit}", value * factor))
    };
    format!(
        "| {} | {held} of {} | {} | {} | {} | {touched} |",
        kind.folder(),
        drawn.rows.len(),
        drawn.redrawn,
        figure(lead, 1e3, "mm"),
        figure(loss, 100.0, "%"),
    )
}
