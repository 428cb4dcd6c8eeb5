//! Prints what the weighings give.

use super::bodies::SETTINGS;
use super::fit::Fit;
use std::io::{self, Write};
use std::path::Path;

/// A value is not measured if its deviation stays above this part of the one before.
const NOT_MEASURED: f64 = 0.5;

/// Prints masses, residuals and centre of gravity.
pub(super) fn print(fit: &Fit) {
    say("setting             before        now  deviation");
    let [before, before_deviations] = &fit.before;
    let deviations = fit.deviations();
    for (index, setting) in SETTINGS.into_iter().enumerate() {
        let row = setting.description();
        // Millionths: g and mm with a thousandth.
        let unit = if row.unit == "mg" { "g" } else { "mm" };
        let deviation = deviations[index];
        let note = if deviation > NOT_MEASURED * before_deviations[index] {
            "  not measured"
        } else {
            ""
        };
        say(&format!(
            "{:<15} {:>10.1} {:>10.1} {:>7.1} {unit}{note}",
            row.name,
            1e3 * before[index],
            1e3 * fit.masses[index],
            1e3 * deviation,
        ));
    }
    say("\nreading, kg                             read   fitted  deviation");
    for residual in &fit.residuals {
        say(&format!(
            "{:<35} {:>8.3} {:>8.3} {:>8.3}",
            residual.name, residual.read, residual.fitted, residual.deviation
        ));
    }
    say("\ncentre of gravity, mm: from axle 1 forward, left, up; deviation in the side view");
    for cog in &fit.cog {
        let [forward, left, up] = cog.place.map(|coordinate| 1e3 * coordinate);
        let deviation = 1e3 * cog.in_side_view();
        say(&format!(
            "chassis angle {:>3} degrees: {forward:>7.1} {left:>7.1} {up:>7.1}, {deviation:.1}",
            cog.joint_degrees,
        ));
    }
}

/// Prints the uncertainty that the guard should know.
pub(super) fn uncertainty(fit: &Fit) {
    let deviations = fit.cog.iter().map(|cog| {
        let left = if fit.left_is_measured {
            cog.deviation[1]
        } else {
            0.0
        };
        cog.in_side_view().hypot(left)
    });
    let largest = deviations.fold(0.0, f64::max);
    say(&format!(
        "\ncog_uncertainty = {:.0} um covers three deviations",
        3e6 * largest
    ));
    if !fit.left_is_measured {
        say("not of the place to the left: that takes two scales under each axle");
    }
}

/// Says where the masses are.
pub(super) fn written(path: &Path, nodes: usize) {
    say(&format!(
        "wrote the masses of {nodes} nodes into {}",
        path.display()
    ));
}

/// Prints a line. The standard output may be a pipe that its reader has closed.
fn say(line: &str) {
    let _ = writeln!(io::stdout(), "{line}");
}
