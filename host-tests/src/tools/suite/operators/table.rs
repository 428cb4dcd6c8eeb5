//! Formats the results of the operators' suite as Markdown.

use super::{Plan, Row};
use clap::ValueEnum;
use std::fmt::Write;

/// Head of the table, with the names of the columns of [`line`].
pub const HEAD: &str = "| robot | guard | seed | runs | toppled on fair ground | toppled over an edge \
                        | drawn again | never armed | armed | driven | commands passed | scaled | refused |\n\
                        |---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

/// The table of one suite, and below it each run that toppled.
pub fn table(plan: &Plan, rows: &[Row]) -> String {
    let mut text = format!("{HEAD}{}", line(plan, rows));
    if rows.iter().any(|row| row.topple.is_some()) {
        text.push_str("\n| toppled | time | where | pitch, roll, chassis 1 s before | commanded | guard |\n|---|---|---|---|---|---|\n");
    }
    for row in rows {
        let Some(topple) = &row.topple else { continue };
        let place = if topple.over_edge {
            "over an edge"
        } else {
            "on fair ground"
        };
        let [pitch, roll, chassis] = topple.attitude_deg;
        let [speed, angle] = topple.commanded;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} ({}) | {:.1} s | {place} | {pitch}, {roll}, {chassis} | {speed} m/s, {angle} | {} |",
            row.number, row.about, topple.time_s, topple.verdict
        );
    }
    text
}

fn line(plan: &Plan, rows: &[Row]) -> String {
    let count = |what: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| what(row)).count();
    let sum = |what: &dyn Fn(&Row) -> u64| rows.iter().map(what).sum::<u64>();
    let shares: f64 = rows.iter().map(|row| row.armed_share).sum();
    let distance: f64 = rows.iter().map(|row| row.distance_m).sum();
    let robot = plan.robot.to_possible_value();
    format!(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {:.0} % | {distance:.0} m | {} | {} | {} |\n",
        robot.as_ref().map_or("", |value| value.get_name()),
        if plan.guard { "on" } else { "off" },
        plan.seed,
        rows.len(),
        count(&Row::failed),
        count(&|row| row.topple.as_ref().is_some_and(|topple| topple.over_edge)),
        sum(&|row| row.drawn_again),
        count(&|row| !row.armed),
        100.0 * shares / rows.len().max(1) as f64,
        sum(&|row| row.commands.passed),
        sum(&|row| row.commands.scaled),
        sum(&|row| row.commands.refused),
    )
}

/// One line about a run, for the terminal.
pub fn progress(row: &Row) -> String {
    let outcome = match &row.topple {
        None if !row.armed => "is never armed".into(),
        None => "stands".into(),
        Some(topple) if topple.over_edge => format!("over an edge at {:.1} s", topple.time_s),
        Some(topple) => format!("TOPPLES at {:.1} s", topple.time_s),
    };
    format!(
        "{:>5}  {:5.1} s simulated  {:5.1} m  {outcome}  ({})",
        row.number, row.simulated_s, row.distance_m, row.about
    )
}
