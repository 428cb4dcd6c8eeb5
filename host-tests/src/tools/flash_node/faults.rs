//! Prints the fault log of a board, which its program keeps in RAM over every reset but a loss of
//! power. The log is found by its checksum, whatever program the board has.

use super::probe;
use std::fmt::Write;
use tautrack::fault_log::{FaultLog, WORDS};
use tautrack::faults;

/// Address of the RAM of both chips.
const RAM: u32 = 0x2000_0000;

/// Causes of a reset, in the order of [`Reset`](tautrack::fault_log::Reset).
const CAUSES: [&str; 7] = [
    "a reset of an unknown cause",
    "power-up or a drop of the supply",
    "the reset pin",
    "a restart by command",
    "a reset by the watchdog",
    "a reset by the watchdog, because crystal or program had failed",
    "a change of the option bytes, or a low-power mode",
];

/// Returns the fault log of a connected board, in words.
///
/// # Errors
/// One line with the command that failed.
pub(super) fn of_board(chip: &str, ram_words: usize) -> Result<String, String> {
    let words = probe::read_words(chip, RAM, ram_words)?;
    Ok(find(&words).map_or_else(
        || "fault log: none, because the power was off or the program is another one\n".to_owned(),
        |log| describe(&log),
    ))
}

/// Finds the log in RAM. The stack, which may hold an older copy, is above the log.
fn find(ram: &[u32]) -> Option<FaultLog> {
    ram.windows(WORDS)
        .filter_map(|words| words.first_chunk::<WORDS>())
        .map(|words| (words, FaultLog::new(words, 0)))
        .find_map(|(words, log)| (log.to_words() == *words).then_some(log))
}

fn describe(log: &FaultLog) -> String {
    if log.is_empty() {
        return "fault log: no fault\n".to_owned();
    }
    let mut text =
        "fault log, the newest fault first (docs/faults.md says what to do):\n".to_owned();
    for entry in (0..log.len()).filter_map(|number| log.get(number)) {
        let code = entry.code;
        let row = faults::TABLE.iter().find(|row| row.code == code);
        let name = row.map_or("fault of the bus", |row| row.name);
        let cause = CAUSES.get(usize::from(entry.reset)).unwrap_or(&CAUSES[0]);
        let milli = |value: i32| f64::from(value) * 1e-3;
        // Writing to a text does not fail.
        let _ = writeln!(
            text,
            "  0x{code:04x} {name}, {:.3} s after {cause}: {:.1} V, {:.2} A, {:.3} rad/s",
            f64::from(entry.time) * 1e-3,
            milli(entry.supply_voltage.into()),
            milli(entry.current.into()),
            milli(entry.velocity),
        );
    }
    text
}
