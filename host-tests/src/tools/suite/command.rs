//! Runs the suites for `cargo demo --suite`: builds the programs, prints progress, writes files.

use super::clearance::{self, Shard, shards};
use super::evaluation::Row;
use super::operators::Plan;
use super::operators::journal::Journal;
use super::{Findings, operators as operated, suite, table};
use crate::programs::setup::checkout;
use crate::programs::{Board, Programs};
use crate::robots::Kind;
use crate::scenario::{Scenario, Sensors};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn programs(board: Board, kind: Kind) -> Result<Programs, String> {
    kind.programs(board).map_err(|error| error.to_string())
}

/// Runs the hazard suite with nodes on `board`. Returns whether every row holds.
///
/// # Errors
/// The programs do not build, a scenario cannot be run, or a file cannot be written.
pub fn hazards(
    board: Board,
    random: u64,
    seed: u64,
    sensors: Sensors,
    out: &Path,
) -> Result<bool, String> {
    let programs = programs(board, Kind::default())?;
    let root = checkout::root().map_err(|error| error.to_string())?;
    let scenarios = root.join("host-tests/scenarios");
    let done = |row: &Row| {
        let simulated_s = row.simulated_s;
        let verdict = table::verdict(row);
        println!(
            "{:28} {simulated_s:6.1} s simulated  {verdict}",
            row.scenario.name
        );
    };
    let began = Instant::now();
    let findings = suite(&scenarios, random, seed, sensors, &programs, &done)
        .map_err(|error| error.to_string())?;
    let table = table::table(&findings);
    let simulated_s: f64 = findings.rows().map(|row| row.simulated_s).sum();
    println!(
        "\n{table}\n{simulated_s:.0} s simulated in {:.0} s",
        began.elapsed().as_secs_f64()
    );
    write_findings(out, &table, &findings)
        .map_err(|error| format!("cannot write to {}: {error}", out.display()))?;
    Ok(findings.all_hold())
}

/// Writes the tables, and each drawn scenario that does not hold as a file for `--scenario`.
fn write_findings(
    folder: &Path,
    table: &str,
    findings: &Findings,
) -> Result<(), Box<dyn std::error::Error>> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("hazards.md"), table)?;
    let drawn = findings.drawn.iter().flat_map(|drawn| &drawn.rows);
    for row in drawn.filter(|row| !row.unmet.is_empty()) {
        let file = folder.join(&row.scenario.name).with_extension("toml");
        fs::write(file, toml::to_string(&row.scenario)?)?;
    }
    Ok(())
}

/// Runs the operators' suite, or the runs of it that have no result yet. Returns whether no robot
/// toppled on fair ground.
///
/// # Errors
/// The programs do not build, a run fails, or a file cannot be written.
pub fn operators(board: Board, plan: &Plan, out: &Path) -> Result<bool, String> {
    let programs = programs(board, plan.robot)?;
    let robot = plan.robot.argument();
    let guard = if plan.guard { "on" } else { "off" };
    let folder = out.join(format!("operators-{robot}-{guard}"));
    let cannot = |error| format!("cannot write to {}: {error}", folder.display());
    fs::create_dir_all(&folder).map_err(cannot)?;
    let (journal, known) = Journal::open(&folder.join("runs.jsonl")).map_err(cannot)?;
    let began = Instant::now();
    let done = |row: &operated::Row, scenario: &Scenario| {
        println!("{}", operated::table::progress(row));
        let kept = journal
            .append(row)
            .and_then(|()| keep(row, scenario, &folder));
        if let Err(error) = kept {
            eprintln!("error: run {} is not kept: {error}", row.number);
        }
    };
    let rows =
        operated::operators(plan, &programs, &known, &done).map_err(|error| error.to_string())?;
    let table = operated::table::table(plan, &rows);
    let simulated_s: f64 = rows.iter().map(|row| row.simulated_s).sum();
    println!(
        "\n{table}\n{simulated_s:.0} s simulated; this time {:.0} s of the wall clock",
        began.elapsed().as_secs_f64()
    );
    let file = folder.join(format!("seed-{}.md", plan.seed));
    fs::write(file, table).map_err(cannot)?;
    Ok(!rows.iter().any(operated::Row::failed))
}

/// Runs a shard of the clearance suite. Prints the table, or with `json` one line for each run.
/// Returns whether no robot toppled and each run got to an end.
///
/// # Errors
/// The programs do not build, a run fails, or a file cannot be written.
pub fn clearance(
    board: Board,
    (runs, seed, faulty): (u64, u64, bool),
    shard: Shard,
    json: bool,
    out: &Path,
) -> Result<bool, String> {
    let programs = programs(board, Kind::default())?;
    let folder = out.join("clearance");
    let cannot = |error| format!("cannot write to {}: {error}", folder.display());
    fs::create_dir_all(&folder).map_err(cannot)?;
    let done = |row: &clearance::Row, scenario: &Scenario| {
        if row.missed() {
            let file = folder.join(&scenario.name).with_extension("toml");
            if let Err(error) = fs::write(&file, operated::text(scenario)) {
                eprintln!("error: cannot write {}: {error}", file.display());
            }
        }
        if json {
            print!("{}", shards::line(row));
        } else {
            println!("{:>5}  {}", row.number, clearance::table::progress(row));
        }
    };
    let rows = clearance::clearance((runs, seed, faulty), shard, &programs, &done)
        .map_err(|error| error.to_string())?;
    let lines: String = rows.iter().map(shards::line).collect();
    fs::write(shard.file(&folder, seed), lines).map_err(cannot)?;
    Ok(show(&rows, json))
}

/// Runs the grid of stairs, prints its table, and writes the chart. Returns whether statics and
/// simulation agree in at least 95 % of the cells that are far from the limit.
///
/// # Errors
/// The programs do not build, a run fails, or a file cannot be written.
pub fn grid(board: Board, out: &Path) -> Result<bool, String> {
    let programs = programs(board, Kind::default())?;
    let done = |row: &clearance::Row| println!("{}", clearance::table::progress(row));
    let rows = clearance::grid::grid(&programs, &done).map_err(|error| error.to_string())?;
    let file = out.join("clearance.svg");
    fs::create_dir_all(out)
        .and_then(|()| fs::write(&file, clearance::grid::chart(&rows)))
        .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    let [far, agree] = clearance::grid::agreement(&rows);
    println!("statics and simulation agree in {agree} of {far} cells far from the limit");
    Ok(100 * agree >= 95 * far)
}

/// Prints the merged results of the shards in `folder`. Returns whether no robot toppled and each
/// run got to an end.
///
/// # Errors
/// A file cannot be read, or there is none.
pub fn merge(folder: &Path, json: bool) -> Result<bool, String> {
    let rows = shards::merged(folder)
        .map_err(|error| format!("cannot merge {}: {error}", folder.display()))?;
    if rows.is_empty() {
        return Err(format!("{} has no results (*.jsonl)", folder.display()));
    }
    if json {
        for row in &rows {
            print!("{}", shards::line(row));
        }
    }
    Ok(show(&rows, json))
}

fn show(rows: &[clearance::Row], json: bool) -> bool {
    if !json {
        println!("\n{}", clearance::table::table(rows));
    }
    let fails = [clearance::Ending::Toppled, clearance::Ending::Unfinished];
    !rows.iter().any(|row| fails.contains(&row.ending))
}

/// Writes the scenario of a run that toppled or never armed, with the command that repeats it.
fn keep(row: &operated::Row, scenario: &Scenario, folder: &Path) -> std::io::Result<()> {
    let what = match &row.topple {
        Some(topple) => {
            let place = if topple.over_edge {
                "over an edge"
            } else {
                "on fair ground"
            };
            format!("Topples {place} at {:.2} s", topple.time_s)
        }
        None if !row.armed => "Is never armed".to_owned(),
        None => return Ok(()),
    };
    let file: PathBuf = folder.join(&scenario.name).with_extension("toml");
    let command = format!("cargo demo --nodes host --scenario {}", file.display());
    println!("       {command}");
    let head = format!("# {what}.\n# {command}\n");
    fs::write(file, head + &operated::text(scenario))
}
