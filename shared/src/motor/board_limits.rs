//! Bounds and defaults of the settings that depend on what a board is built of: they are narrower
//! than those of the table of settings.

use super::limits::OVERSPEED;
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

/// A `velocity_limit` at which an open bridge charges the supply too high.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SupplyTooHigh {
    /// Supply voltage if the bridge opens at the speed of the fault "overspeed", V.
    pub got: f32,
    /// What the board bears, V.
    pub maximum: f32,
}

impl fmt::Display for SupplyTooHigh {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { got, maximum } = self;
        write!(
            out,
            "supply if the bridge opens at 120 % of velocity_limit = {got:.1} V, at most \
             {maximum:.1} V on this board"
        )
    }
}

/// Highest voltage to which the diodes of an open bridge charge a capacitor of 100 uF, per back-EMF
/// between two terminals, for a brushed motor. Nothing controls it above its supply, so the
/// capacitor already has the back-EMF. The table in docs/motor.md shows the result.
const BRUSHED: f32 = 1.1;
/// The same of a three-phase motor. Until it opens, the bridge keeps the supply below the back-EMF.
/// Then the inductances carry the voltage beyond it.
const THREE_PHASE: f32 = 1.28;

/// Returns the supply voltage, V, to which a bridge that opens at the speed of the fault
/// "overspeed" charges the capacitor, for a velocity limit of 1 rad/s.
fn supply_of_open_bridge(settings: &Settings) -> f32 {
    let constant = settings.si(Setting::TorqueConstant) * settings.si(Setting::GearRatio);
    let by_constant = if settings.get(Setting::MotorKind) == 0 {
        BRUSHED
    } else {
        // Root of 3, for the voltage between two phases, by the 1.5 of the torque of three phases.
        THREE_PHASE * 1.154_700_5
    };
    OVERSPEED * by_constant * constant
}

/// Returns the largest velocity limit, rad/s, of the motor in the settings on a board that bears a
/// supply voltage of `highest`, V.
pub fn largest_velocity(settings: &Settings, highest: f32) -> f32 {
    highest / supply_of_open_bridge(settings)
}

/// Checks that a bridge that opens at any speed up to the fault "overspeed" charges the supply to
/// at most `maximum`, V.
///
/// # Errors
/// The voltage that it would reach.
pub fn check_velocity(settings: &Settings, maximum: f32) -> Result<(), SupplyTooHigh> {
    let got = supply_of_open_bridge(settings) * settings.si(Setting::VelocityLimit);
    if got > maximum {
        return Err(SupplyTooHigh { got, maximum });
    }
    Ok(())
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
