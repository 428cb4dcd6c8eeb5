//! `--grid`: compares the statics with the simulation over riser and run of stairs, and draws both.

use super::model::straight;
use super::row::{Ending, clear};
use super::{Row, draw};
use crate::programs::Programs;
use crate::robots::Robot;
use crate::tools::suite::SuiteError;
use crate::tools::suite::cores::on_all_cores;
use std::fmt::Write;

/// Risers and runs of the grid, cm, and the coefficient of friction.
pub const RISERS_CM: [u32; 13] = [8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20];
/// Runs of the grid, cm.
pub const RUNS_CM: [u32; 15] = [22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36];
const FRICTION: f64 = 1.0;
/// Margin beyond which statics and simulation must agree, mm.
const CLEAR_MM: f64 = 10.0;

/// Runs every cell of the grid: the nominal robot before five steps.
///
/// # Errors
/// [`SuiteError`] of the first run that fails.
pub fn grid(programs: &Programs, done: &(dyn Fn(&Row) + Sync)) -> Result<Vec<Row>, SuiteError> {
    let cells: Vec<(u32, u32)> = RISERS_CM
        .into_iter()
        .flat_map(|riser| RUNS_CM.map(|run| (riser, run)))
        .collect();
    on_all_cores(&cells, |(riser, run)| {
        let [riser_m, run_m] = [riser, run].map(|length| f64::from(*length) * 0.01);
        let (scenario, obstacle) =
            draw::stairs(riser_m, run_m, FRICTION).map_err(SuiteError::Scenario)?;
        let row = clear(&scenario, &obstacle, None, programs)?;
        done(&row);
        Ok(row)
    })
}

/// Cells whose margin is far from 0, and those of them in which statics and simulation agree.
pub fn agreement(rows: &[Row]) -> [usize; 2] {
    let far = || rows.iter().filter(|row| row.margin_mm.abs() > CLEAR_MM);
    let agrees = |row: &&Row| (row.margin_mm > 0.0) == (row.ending == Ending::Cleared);
    [far().count(), far().filter(agrees).count()]
}

/// The chart: cleared cells are filled, and a line is where the margin of the statics is 0.
pub fn chart(rows: &[Row]) -> String {
    let x = |run_cm: f64| 70.0 + (run_cm - 21.0) * 30.0;
    let y = |riser_cm: f64| 380.0 - (riser_cm - 7.0) * 25.0;
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 560 430\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"560\" height=\"430\" \
         fill=\"white\"/>\n",
    );
    for row in rows {
        let (cx, cy) = (x(1e2 * row.obstacle.run_m), y(1e2 * row.obstacle.riser_m));
        let fill = if row.ending == Ending::Cleared {
            "#2a7"
        } else {
            "white"
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<circle cx=\"{cx:.0}\" cy=\"{cy:.0}\" r=\"7\" fill=\"{fill}\" stroke=\"#333\"/>"
        );
    }
    let robot = straight(&Robot::default());
    let limit = |run_cm: f64| {
        let clears = |riser_cm: &f64| {
            robot
                .stairs(riser_cm * 0.01, run_cm * 0.01, FRICTION)
                .margin
                >= 0.0
        };
        let risers = (0..=1_400).map(|step| 7.0 + f64::from(step) * 0.01);
        risers.take_while(clears).last().unwrap_or(7.0)
    };
    let mut points = String::new();
    for step in 0..=32 {
        let run_cm = 21.0 + f64::from(step) * 0.5;
        let _ = write!(points, "{:.0},{:.1} ", x(run_cm), y(limit(run_cm)));
    }
    let _ = writeln!(
        svg,
        "<polyline points=\"{points}\" fill=\"none\" stroke=\"#c33\" stroke-width=\"2\"/>"
    );
    for run in RUNS_CM {
        let _ = writeln!(
            svg,
            "<text x=\"{:.0}\" y=\"400\" text-anchor=\"middle\">{run}</text>",
            x(f64::from(run))
        );
    }
    for riser in RISERS_CM.into_iter().step_by(2) {
        let _ = writeln!(
            svg,
            "<text x=\"40\" y=\"{:.0}\" text-anchor=\"end\">{riser}</text>",
            y(f64::from(riser)) + 4.0
        );
    }
    svg.push_str(
        "<text x=\"300\" y=\"420\" text-anchor=\"middle\">run, cm</text>\n\
         <text x=\"60\" y=\"30\">riser, cm; filled: cleared in simulation; line: limit by \
         statics</text>\n</svg>\n",
    );
    svg
}
