//! Parameters of a drive that a client writes by SDO: option codes, windows, position limits,
//! torque slope and homing method of CiA 402.

use super::cia402::mode;

/// Values of the parameter objects of one drive, in their units on the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct DriveParameters {
    /// Quick stop option code (0x605A): 0 switches the bridge off; 1 and 2 ramp to standstill, then
    /// switch it off; 5 and 6 ramp to standstill and hold. 1 and 5 use `acceleration_limit`, 2 and
    /// 6 `quick_stop_deceleration`.
    pub quick_stop: i16,
    /// Shutdown option code (0x605B): 0 switches the bridge off at once; 1 ramps to standstill
    /// first.
    pub shutdown: i16,
    /// Disable operation option code (0x605C): 0 switches the bridge off at once; 1 ramps to
    /// standstill first.
    pub disable_operation: i16,
    /// Halt option code (0x605D): ramps with `acceleration_limit` (1) or with
    /// `quick_stop_deceleration` (2).
    pub halt: i16,
    /// Fault reaction option code (0x605E), for faults whose reaction is to hold: 0 switches the
    /// bridge off; 1 and 2 ramp like 5 and 6 of 0x605A.
    pub fault_reaction: i16,
    /// Following error window (0x6065), in units of position; `u32::MAX` is no window.
    pub following_window: u32,
    /// Following error time out (0x6066), ms.
    pub following_time: u16,
    /// Position window (0x6067), in units of position; `u32::MAX` is no window.
    pub position_window: u32,
    /// Position window time (0x6068), ms.
    pub position_time: u16,
    /// Software position limits (0x607D): lower and upper end, in units of position. They do not
    /// limit unless the lower is below the upper.
    pub position_limits: [i32; 2],
    /// Profile velocity (0x6081), in units of velocity; `u32::MAX` is no limit. It limits the modes
    /// of the profile within the limits of the settings.
    pub profile_velocity: u32,
    /// Profile acceleration (0x6083), in units of velocity per second; `u32::MAX` is no limit.
    pub profile_acceleration: u32,
    /// Torque slope (0x6087), in units of torque per second.
    pub torque_slope: u32,
    /// Homing method (0x6098).
    pub homing_method: i8,
}

/// Returns whether `index` is the index of a parameter in [`DriveParameters`]. Writing a parameter
/// is no set-point.
pub fn is_parameter(index: u16) -> bool {
    matches!(
        index,
        0x605a..=0x605e | 0x6065..=0x6068 | 0x607d | 0x6081 | 0x6083 | 0x6087 | 0x6098 | 0x60c2
    )
}

/// Returns whether a drive supports `value` in the object `index`. Objects that it does not know
/// support every value.
pub fn supports(index: u16, value: i32) -> bool {
    match index {
        0x605a => matches!(value, 0..=2 | 5 | 6),
        0x605b | 0x605c => matches!(value, 0 | 1),
        0x605d => matches!(value, 1 | 2),
        0x605e => matches!(value, 0..=2),
        0x6060 => i8::try_from(value).is_ok_and(mode::is_supported),
        0x6081 | 0x6083 | 0x6087 => value != 0,
        0x6098 => matches!(value, 0 | 17..=24 | 37),
        _ => true,
    }
}

/// Returns whether only some values of the object `index` are supported.
pub fn is_restricted(index: u16) -> bool {
    matches!(
        index,
        0x605a..=0x605e | 0x6060 | 0x6081 | 0x6083 | 0x6087 | 0x6098
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_restricted_supports_every_value() {
        for index in 0..=u16::MAX {
            let all = (-200..200).all(|value| supports(index, value));
            assert_eq!(all, !is_restricted(index), "{index:#x}");
        }
    }

    /// The objects of [`DriveParameters`] by their numbers in CiA 402, and objects of set-points,
    /// modes and actual values near them.
    #[test]
    fn a_parameter_is_no_set_point() {
        let parameters = [
            0x605a, 0x605b, 0x605c, 0x605d, 0x605e, 0x6065, 0x6066, 0x6067, 0x6068, 0x607d, 0x6081,
            0x6083, 0x6087, 0x6098, 0x60c2,
        ];
        for index in parameters {
            assert!(is_parameter(index), "{index:#x}");
        }
        for index in [0x6040, 0x6060, 0x6064, 0x6071, 0x607a, 0x60b2, 0x60ff] {
            assert!(!is_parameter(index), "{index:#x}");
        }
    }

    #[test]
    fn a_motion_or_torque_that_could_never_change_is_refused() {
        for index in [0x6081, 0x6083, 0x6087] {
            assert!(!supports(index, 0));
            assert!(supports(index, 1) && supports(index, i32::MAX));
        }
    }
}
