//! Bounds and defaults of the settings that depend on what a board is built of: they are narrower
//! than those of the table of settings.

use crate::settings::{Bounds, Setting, Settings, bounds_of_row};
use core::fmt;

/// Bounds of a setting on a board.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limit {
    /// The setting.
    pub setting: Setting,
    /// Its name. The names of the table are not in the program of a node.
    pub name: &'static str,
    /// Smallest and largest value, in the unit of the setting.
    pub bounds: [i32; 2],
    /// Value of a node that was never given one.
    pub default: i32,
}

/// A value that the board does not bear.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BeyondBoard {
    /// What it is beyond.
    pub limit: Limit,
    /// The value.
    pub got: i32,
}

impl fmt::Display for BeyondBoard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Limit { name, bounds, .. } = self.limit;
        let [minimum, maximum] = bounds;
        let got = self.got;
        write!(
            out,
            "{name} = {got}, this board allows {minimum} to {maximum}"
        )
    }
}

/// Sets the defaults of a board.
pub fn set_defaults(limits: &[Limit], settings: &mut Settings) {
    for limit in limits {
        // Cannot fail: a test sets all defaults.
        let _ = settings.set(limit.setting.bounds().key, limit.default);
    }
}

/// Returns the numbers of the row with this index of the table of settings, with the default of
/// the board: a value that equals it need not be in flash.
pub fn row(limits: &[Limit], index: usize) -> Option<Bounds> {
    let row = bounds_of_row(index)?;
    let mut limits = limits.iter();
    // A load and a save ask for every row. The keys of the limits would have to be unpacked.
    let limit = limits.find(|limit| limit.setting as usize == index);
    Some(Bounds {
        default: limit.map_or(row.default, |limit| limit.default),
        ..row
    })
}

/// Checks the settings against the bounds of a board.
///
/// # Errors
/// The first value that is beyond them.
pub fn check(limits: &[Limit], settings: &Settings) -> Result<(), BeyondBoard> {
    for limit in limits {
        let got = settings.get(limit.setting);
        let [minimum, maximum] = limit.bounds;
        if !(minimum..=maximum).contains(&got) {
            return Err(BeyondBoard { limit: *limit, got });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn a_value_beyond_the_board_is_named_with_its_bounds() {
        let limits = [Limit {
            setting: Setting::OverVoltage,
            name: "over_voltage",
            bounds: [6_000, 26_000],
            default: 25_000,
        }];
        let mut settings = Settings::default();
        let error = check(&limits, &settings).expect_err("the default of the table");
        let text = std::format!("{error}");
        assert_eq!(
            text,
            "over_voltage = 32000, this board allows 6000 to 26000"
        );
        set_defaults(&limits, &mut settings);
        assert_eq!(check(&limits, &settings), Ok(()));
        assert_eq!(settings.get(Setting::OverVoltage), 25_000);
        for (value, allowed) in [(6_000, true), (26_000, true), (26_001, false)] {
            settings
                .set(Setting::OverVoltage.bounds().key, value)
                .unwrap();
            assert_eq!(check(&limits, &settings).is_ok(), allowed, "{value}");
        }
    }
}
