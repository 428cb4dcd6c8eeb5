//! Formats the results of the clearance suite as Markdown.

use super::Row;
use super::draw::Kind;
use super::row::{Ending, POSSIBLE_MM};
use std::fmt::Write;
use tautrack::robots::b2p2::clearance::Phase;

/// The tables of a suite: by kind of obstacle, by margin of the statics, and the runs that were not
/// cleared though the statics has a margin.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(HEAD);
    for kind in Kind::ALL {
        let of_kind: Vec<&Row> = rows
            .iter()
            .filter(|row| row.obstacle.kind == kind)
            .collect();
        line(&mut text, kind.name(), &of_kind);
    }
    line(&mut text, "**all**", &rows.iter().collect::<Vec<_>>());
    text.push('\n');
    text.push_str(&HEAD.replace("obstacle", "margin by statics"));
    let bins = [
        ("below -20 mm", f64::NEG_INFINITY, -20.0),
        ("-20 to 0 mm", -20.0, 0.0),
        ("0 to 20 mm", 0.0, 20.0),
        ("20 to 40 mm", 20.0, 40.0),
        ("40 mm and more", 40.0, f64::INFINITY),
    ];
    for (name, from, to) in bins {
        let within = |row: &&Row| (from..to).contains(&row.margin_mm);
        line(
            &mut text,
            name,
            &rows.iter().filter(within).collect::<Vec<_>>(),
        );
    }
    let failed = |row: &&Row| row.failed.as_ref().is_some_and(|it| it.fault.is_some());
    if rows.iter().any(|row| failed(&row)) {
        text.push('\n');
        text.push_str(&HEAD.replace("obstacle", "something fails in"));
        for phase in Phase::ALL.map(Phase::name) {
            let of_phase =
                |row: &&Row| failed(row) && row.failed.as_ref().is_some_and(|it| it.phase == phase);
            let rows: Vec<&Row> = rows.iter().filter(of_phase).collect();
            if !rows.is_empty() {
                line(&mut text, phase, &rows);
            }
        }
        line(
            &mut text,
            "**all**",
            &rows.iter().filter(failed).collect::<Vec<_>>(),
        );
    }
    for row in rows.iter().filter(|row| row.missed()) {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n{}: {}", row.number, progress(row));
        for (time_s, phase) in &row.phases {
            let _ = write!(text, "\n       {time_s:6.2} s  {phase}");
        }
    }
    text.push('\n');
    text
}

const HEAD: &str = "| obstacle | runs | possible | cleared of these | cleared | given up | held | stopped | unfinished | toppled | interventions | mean time |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";

fn line(text: &mut String, name: &str, rows: &[&Row]) {
    let count = |ending: Ending| rows.iter().filter(|row| row.ending == ending).count();
    let possible: Vec<_> = rows
        .iter()
        .filter(|row| row.margin_mm >= POSSIBLE_MM)
        .collect();
    let of_these = possible
        .iter()
        .filter(|row| row.ending == Ending::Cleared)
        .count();
    let interventions: u64 = rows.iter().map(|row| row.interventions).sum();
    let cleared = rows.iter().filter(|row| row.ending == Ending::Cleared);
    let times = cleared
        .map(|row| row.time_s)
        .fold(0.0, |sum, time| sum + time);
    let _ = writeln!(
        text,
        "| {name} | {} | {} | {of_these} | {} | {} | {} | {} | {} | {} | {interventions} | {:.1} s |",
        rows.len(),
        possible.len(),
        count(Ending::Cleared),
        count(Ending::GivenUp),
        count(Ending::Held),
        count(Ending::Stopped),
        count(Ending::Unfinished),
        count(Ending::Toppled),
        times / count(Ending::Cleared).max(1) as f64,
    );
}

/// One line about a run.
pub fn progress(row: &Row) -> String {
    let [up, down, roll] = row.attitude_deg;
    let mut text = format!(
        "{:?} after {:.1} s, {:.0} mm by statics, pitch {down} to {up}, roll {roll}, margin {} mm, \
         {} interventions ({})",
        row.ending, row.time_s, row.margin_mm, row.least_margin_mm, row.interventions, row.about
    );
    if row.failed.as_ref().is_some_and(|it| it.fault.is_none()) {
        text.push_str("; nothing failed before the end");
    }
    text
}
