//! Formats the tables of `cargo cost` and the page docs/cost.md.

use super::ledger::{Kernel, Ledger};
use super::{CORE_HZ, Entry, Measurement};
use crate::programs::setup::checkout::root;
use std::fmt::Write;
use std::io;
use std::path::PathBuf;

/// Text of the page before and between the tables. Words in braces are replaced by the results.
const PAGE: &str = include_str!("page.md");

/// Path of docs/cost.md.
///
/// # Errors
/// The program does not run in a checkout.
pub fn path() -> io::Result<PathBuf> {
    Ok(root()?.join("docs/cost.md"))
}

/// The complete text of docs/cost.md.
pub fn page(measurement: &Measurement, ledger: &Ledger) -> String {
    let mut excuses = String::new();
    for Kernel {
        name,
        ceiling,
        excuse,
        ..
    } in &ledger.kernel
    {
        if let Some(excuse) = excuse {
            // Writing to a string cannot fail.
            let _ = writeln!(
                excuses,
                "* **{name}** (ceiling {}): {excuse}",
                or_dash(ceiling.as_ref())
            );
        }
    }
    PAGE.replace("{rustc}", &measurement.rustc)
        .replace("{kernels}", &kernels(measurement, ledger))
        .replace("{periods}", &periods(measurement))
        .replace("{images}", &images(measurement))
        .replace("{excuses}", &excuses)
}

/// Both tables, to print on a terminal.
pub fn tables(measurement: &Measurement, ledger: &Ledger) -> String {
    format!("{}\n{}", kernels(measurement, ledger), images(measurement))
}

fn kernels(measurement: &Measurement, ledger: &Ledger) -> String {
    let heads = [
        "kernel or tick",
        "instructions",
        "mean",
        "ceiling",
        "modelled cycles",
        "of its period",
        "code bytes",
        "worst error",
    ];
    let rows = measurement.entries.iter().map(|entry| {
        let kernel = ledger.kernel(&entry.name);
        let rate = kernel.and_then(|kernel| kernel.rate_hz);
        [
            entry.name.clone(),
            range(entry.least, entry.most),
            format!("{:.1}", entry.mean),
            or_dash(kernel.and_then(|kernel| kernel.ceiling.as_ref())),
            range(entry.cycles[0], entry.cycles[1]),
            or_dash(rate.map(|rate| share(entry, rate)).as_ref()),
            entry.code_bytes.to_string(),
            or_dash(kernel.and_then(|kernel| kernel.error.as_ref())),
        ]
    });
    table(heads, &rows.collect::<Vec<_>>())
}

/// Guards: the robot, the ticks of its SYNC period, and the entries that count them.
const GUARDS: &[(&str, u32, &[&str])] = &[
    (
        "B2P2",
        4,
        &[
            "guard tick with SYNC",
            "guard tick with frames",
            "guard tick that evaluates",
            "guard tick that updates the estimate",
        ],
    ),
    ("crawler", 4, &["guard tick of the crawler"]),
    ("RT-Mover", 5, &["guard tick of RT-Mover"]),
    ("Hylos", 8, &["guard tick of Hylos"]),
];

/// Instructions of all ticks of a SYNC period, quiet and busy.
fn periods(measurement: &Measurement) -> String {
    let rows = GUARDS.iter().map(|&(robot, ticks, names)| {
        let sum = |suffix: &str| {
            let of_entry = |name: &&str| {
                let name = format!("{name}{suffix}");
                let entry = measurement.entries.iter().find(|entry| entry.name == name);
                entry.map(|entry| entry.mean)
            };
            let sum: Option<f64> = names.iter().map(of_entry).sum();
            // An entry with every tick of the period has their mean.
            let per_entry = f64::from(ticks) / names.len() as f64;
            or_dash(sum.map(|sum| format!("{:.0}", sum * per_entry)).as_ref())
        };
        [robot.to_owned(), ticks.to_string(), sum(""), sum(", busy")]
    });
    table(
        ["guard of", "ticks", "quiet", "busy"],
        &rows.collect::<Vec<_>>(),
    )
}

fn images(measurement: &Measurement) -> String {
    let rows = measurement.images.iter();
    let rows = rows.map(|image| {
        [
            image.name.clone(),
            image.flash.to_string(),
            image.ram.to_string(),
            or_dash(image.stack.as_ref()),
        ]
    });
    table(
        [
            "program",
            "flash, bytes",
            "static RAM, bytes",
            "deepest stack, bytes",
        ],
        &rows.collect::<Vec<_>>(),
    )
}

/// The counts that differ between `before` and `after`, one line each.
pub fn changes(before: &Measurement, after: &Measurement) -> String {
    let mut text = String::new();
    for entry in &after.entries {
        // Writing to a string cannot fail.
        let _ = match before.entries.iter().find(|old| old.name == entry.name) {
            None => writeln!(text, "{}: new, {}", entry.name, entry.most),
            Some(old) if old.most != entry.most => writeln!(
                text,
                "{}: {} -> {} ({:+.1} %)",
                entry.name,
                old.most,
                entry.most,
                100.0 * (f64::from(entry.most) / f64::from(old.most.max(1)) - 1.0)
            ),
            Some(_) => Ok(()),
        };
    }
    if text.is_empty() {
        text.push_str("no count has changed\n");
    }
    text
}

fn share(entry: &Entry, rate_hz: u32) -> String {
    let percent = 100.0 * f64::from(entry.cycles[1]) * f64::from(rate_hz) / CORE_HZ;
    format!("{percent:.2} % of 1/{rate_hz} s")
}

fn range(least: u32, most: u32) -> String {
    if least == most {
        most.to_string()
    } else {
        format!("{least}-{most}")
    }
}

fn or_dash(value: Option<&impl ToString>) -> String {
    value.map_or_else(|| "-".to_owned(), ToString::to_string)
}

/// A Markdown table whose columns are also aligned in plain text: the first to the left, the others
/// to the right.
fn table<const N: usize>(heads: [&str; N], rows: &[[String; N]]) -> String {
    let widths: [usize; N] = std::array::from_fn(|column| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([heads[column].len()]).max().unwrap_or(0)
    });
    let line = |cells: [&str; N]| {
        let mut line = String::from("|");
        for (column, (cell, width)) in cells.into_iter().zip(widths).enumerate() {
            // Writing to a string cannot fail.
            let _ = if column == 0 {
                write!(line, " {cell:<width$} |")
            } else {
                write!(line, " {cell:>width$} |")
            };
        }
        line + "\n"
    };
    let rule: [String; N] = std::array::from_fn(|column| {
        let dashes = "-".repeat(widths[column].saturating_sub(1));
        if column == 0 {
            format!("{dashes}-")
        } else {
            format!("{dashes}:")
        }
    });
    let mut text = line(heads) + &line(rule.each_ref().map(String::as_str));
    for row in rows {
        text += &line(row.each_ref().map(String::as_str));
    }
    text
}
