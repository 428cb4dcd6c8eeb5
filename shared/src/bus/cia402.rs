//! The drive state machine of CiA 402, as a table of transitions.

/// State of a drive. CiA 402 also has "not ready to switch on" and "fault reaction active". Here
/// they would last less than a tick, so they are omitted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// The drive waits for the command "shutdown".
    SwitchOnDisabled,
    /// The drive waits for the command "switch on".
    ReadyToSwitchOn,
    /// The drive waits for the command "enable operation". There is no torque yet.
    SwitchedOn,
    /// The axle follows its set-points.
    OperationEnabled,
    /// The axle ramps down and holds its position.
    QuickStopActive,
    /// A fault is latched. The windings are shorted or the bridge is open.
    Fault,
}

/// Command that the low bits of the controlword (object 0x6040) give.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DriveCommand {
    /// Leads to "ready to switch on".
    Shutdown,
    /// Leads to "switched on".
    SwitchOn,
    /// Leads to "operation enabled".
    EnableOperation,
    /// Leads to "switch on disabled" at once, from every state but "fault".
    DisableVoltage,
    /// The axle ramps down and holds its position.
    QuickStop,
}

/// Bit 4 of the controlword: a rising edge starts homing. In profile position mode it hands over a
/// new set-point.
pub const CONTROL_START: u16 = 1 << 4;
/// Bit 5 of the controlword: a new set-point replaces the present one at once.
pub const CHANGE_IMMEDIATELY: u16 = 1 << 5;
/// Bit 6 of the controlword: a new set-point is relative to the one before.
pub const RELATIVE: u16 = 1 << 6;
/// Bit 7 of the controlword: a rising edge clears faults.
pub const CONTROL_FAULT_RESET: u16 = 1 << 7;
/// Bit 8 of the controlword: the axle ramps to standstill and stays in operation.
pub const CONTROL_HALT: u16 = 1 << 8;

/// Controlwords that give each command.
pub mod controlword {
    /// [`super::DriveCommand::Shutdown`].
    pub const SHUTDOWN: u16 = 0x06;
    /// [`super::DriveCommand::SwitchOn`].
    pub const SWITCH_ON: u16 = 0x07;
    /// [`super::DriveCommand::EnableOperation`].
    pub const ENABLE_OPERATION: u16 = 0x0f;
    /// [`super::DriveCommand::DisableVoltage`].
    pub const DISABLE_VOLTAGE: u16 = 0x00;
    /// [`super::DriveCommand::QuickStop`].
    pub const QUICK_STOP: u16 = 0x02;
}

/// Bits of the statusword (object 0x6041) besides those of the state.
pub mod status {
    /// Target reached. In homing mode: no homing is under way. During a halt: the axle stands.
    pub const TARGET_REACHED: u16 = 1 << 10;
    /// A limit of the axle acts; object 0x2000 says which.
    pub const LIMIT_ACTIVE: u16 = 1 << 11;
    /// In homing mode: homing is attained. In profile position mode with handshake: set-point
    /// acknowledge. In profile velocity mode: the axle stands. Otherwise: the drive follows its
    /// set-point.
    pub const FOLLOWING: u16 = 1 << 12;
    /// In homing mode: homing failed. In the modes with a target position: following error.
    pub const ERROR_OF_MODE: u16 = 1 << 13;
    /// The position is homed.
    pub const HOMED: u16 = 1 << 14;
    /// The rotor is being aligned. Operation is enabled afterwards.
    pub const ALIGNING: u16 = 1 << 15;
}

const TRANSITIONS: &[(State, DriveCommand, State)] = {
    use DriveCommand::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
    use State::{OperationEnabled, QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
    &[
        (SwitchOnDisabled, Shutdown, ReadyToSwitchOn),
        (ReadyToSwitchOn, SwitchOn, SwitchedOn),
        (ReadyToSwitchOn, EnableOperation, SwitchedOn),
        (ReadyToSwitchOn, DisableVoltage, SwitchOnDisabled),
        (ReadyToSwitchOn, QuickStop, SwitchOnDisabled),
        (SwitchedOn, EnableOperation, OperationEnabled),
        (SwitchedOn, Shutdown, ReadyToSwitchOn),
        (SwitchedOn, DisableVoltage, SwitchOnDisabled),
        (SwitchedOn, QuickStop, SwitchOnDisabled),
        (OperationEnabled, SwitchOn, SwitchedOn),
        (OperationEnabled, Shutdown, ReadyToSwitchOn),
        (OperationEnabled, DisableVoltage, SwitchOnDisabled),
        (OperationEnabled, QuickStop, QuickStopActive),
        (QuickStopActive, EnableOperation, OperationEnabled),
        (QuickStopActive, DisableVoltage, SwitchOnDisabled),
    ]
};

/// State after each command, by state and command. The state stays the same where the table has no
/// transition.
const AFTER: [[State; 5]; 6] = {
    use State::{
        Fault, OperationEnabled, QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn,
    };
    let mut after = [
        [SwitchOnDisabled; 5],
        [ReadyToSwitchOn; 5],
        [SwitchedOn; 5],
        [OperationEnabled; 5],
        [QuickStopActive; 5],
        [Fault; 5],
    ];
    let mut row = 0;
    while row < TRANSITIONS.len() {
        let (from, by, to) = TRANSITIONS[row];
        after[from as usize][by as usize] = to;
        row += 1;
    }
    after
};

impl DriveCommand {
    /// Returns the command that a controlword gives.
    pub fn from_controlword(word: u16) -> Self {
        BY_LOW_BITS[usize::from(word & 0x0f)]
    }
}

/// Commands by the four low bits of the controlword: enable operation (bit 3), quick stop (bit 2),
/// enable voltage (bit 1), switch on (bit 0).
const BY_LOW_BITS: [DriveCommand; 16] = {
    let mut commands = [DriveCommand::DisableVoltage; 16];
    let mut word = 0;
    while word < commands.len() {
        commands[word] = match word {
            word if word & 0x02 == 0 => DriveCommand::DisableVoltage,
            word if word & 0x04 == 0 => DriveCommand::QuickStop,
            word if word & 0x01 == 0 => DriveCommand::Shutdown,
            0x07 => DriveCommand::SwitchOn,
            _ => DriveCommand::EnableOperation,
        };
        word += 1;
    }
    commands
};

impl State {
    #[must_use]
    /// Returns the state after `command`: the same state if the table has no such transition.
    pub fn after(self, command: DriveCommand) -> Self {
        AFTER[self as usize][command as usize]
    }

    /// Returns whether this state is nearer to torque than `other`. To enter a nearer state,
    /// somebody must be in command, and no latched fault may forbid it.
    pub fn is_above(self, other: Self) -> bool {
        self.height() > other.height()
    }

    /// Rank of the states by what they allow the motor to do.
    fn height(self) -> u8 {
        match self {
            Self::Fault | Self::SwitchOnDisabled => 0,
            Self::ReadyToSwitchOn => 1,
            Self::SwitchedOn => 2,
            Self::QuickStopActive => 3,
            Self::OperationEnabled => 4,
        }
    }

    /// Returns the bits of this state in the statusword: bits 0 to 6, and "remote" (bit 9), which
    /// is set because the node follows the bus.
    pub fn statusword(self) -> u16 {
        0x0200
            | match self {
                Self::SwitchOnDisabled => 0x40,
                Self::ReadyToSwitchOn => 0x31,
                Self::SwitchedOn => 0x33,
                Self::OperationEnabled => 0x37,
                Self::QuickStopActive => 0x17,
                Self::Fault => 0x08,
            }
    }

    /// Returns `word`, which has the bits of another state, with those of this one.
    pub fn in_statusword(self, word: u16) -> u16 {
        const BITS: u16 = 0x6f;
        word & !BITS | self.statusword() & BITS
    }

    /// Returns the state in a received statusword; `None` for a bit pattern that no state has.
    pub fn from_statusword(word: u16) -> Option<Self> {
        Some(match (word & 0x4f, word & 0x20) {
            (0x40, _) => Self::SwitchOnDisabled,
            (0x01, 0x20) => Self::ReadyToSwitchOn,
            (0x03, 0x20) => Self::SwitchedOn,
            (0x07, 0x20) => Self::OperationEnabled,
            (0x07, 0) => Self::QuickStopActive,
            (0x08, _) => Self::Fault,
            _ => return None,
        })
    }
}

/// Returns the controlword that brings a drive in `state` one transition nearer to "operation
/// enabled". In "fault", which only a fault reset ends, this is "disable voltage".
pub fn toward_operation(state: State) -> u16 {
    match state {
        State::SwitchOnDisabled => controlword::SHUTDOWN,
        State::ReadyToSwitchOn => controlword::SWITCH_ON,
        State::Fault => controlword::DISABLE_VOLTAGE,
        State::SwitchedOn | State::OperationEnabled | State::QuickStopActive => {
            controlword::ENABLE_OPERATION
        }
    }
}

/// Modes of operation (object 0x6060). Negative modes are tautrack's own.
pub mod mode {
    /// Taut: the screw keeps the belt taut. The screw computes its set-point from the motion of the
    /// chassis joint.
    pub const TAUT: i8 = -1;
    /// Released: as [`TAUT`], and the target is the slack that the screw gives the belt, 2^-24 m.
    pub const RELEASED: i8 = -2;
    /// Profile position: the set-point moves to the target with a trapezoidal velocity profile.
    pub const PROFILE_POSITION: i8 = 1;
    /// Profile velocity: the velocity ramps to the target.
    pub const PROFILE_VELOCITY: i8 = 3;
    /// Homing: the axle finds its home switch.
    pub const HOMING: i8 = 6;
    /// Cyclic synchronous position: the axle interpolates between the targets of two SYNCs.
    pub const CYCLIC_POSITION: i8 = 8;
    /// Cyclic synchronous velocity: the velocity ramps to the newest target.
    pub const CYCLIC_VELOCITY: i8 = 9;
    /// Cyclic synchronous torque: the torque approaches the newest target with the torque slope.
    pub const CYCLIC_TORQUE: i8 = 10;

    /// Returns whether a drive has this mode; 0 is no mode. An axle holds its position in the modes
    /// of the screw.
    pub fn is_supported(mode: i8) -> bool {
        matches!(
            mode,
            RELEASED | TAUT | 0 | PROFILE_POSITION | PROFILE_VELOCITY | HOMING
        ) || matches!(mode, CYCLIC_POSITION | CYCLIC_VELOCITY | CYCLIC_TORQUE)
    }

    /// Returns whether the set-point is the screw's own: it follows the law of the belt.
    #[inline]
    pub fn follows_joint(mode: i8) -> bool {
        matches!(mode, TAUT | RELEASED)
    }

    /// Returns whether the set-point of a drive in this mode is a position.
    #[inline]
    pub fn controls_position(mode: i8) -> bool {
        !matches!(mode, CYCLIC_VELOCITY | PROFILE_VELOCITY | CYCLIC_TORQUE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: [State; 6] = [
        State::SwitchOnDisabled,
        State::ReadyToSwitchOn,
        State::SwitchedOn,
        State::OperationEnabled,
        State::QuickStopActive,
        State::Fault,
    ];

    #[test]
    fn every_state_is_read_back_from_its_statusword() {
        for state in STATES {
            assert_eq!(
                State::from_statusword(state.statusword() | status::LIMIT_ACTIVE),
                Some(state)
            );
        }
    }

    #[test]
    fn disable_voltage_ends_every_state_but_fault() {
        for state in STATES {
            let after = state.after(DriveCommand::from_controlword(controlword::DISABLE_VOLTAGE));
            assert_eq!(
                after,
                if state == State::Fault {
                    State::Fault
                } else {
                    State::SwitchOnDisabled
                }
            );
        }
    }

    #[test]
    fn three_commands_lead_from_power_up_to_operation() {
        let mut state = State::SwitchOnDisabled;
        for _ in 0..3 {
            state = state.after(DriveCommand::from_controlword(toward_operation(state)));
        }
        assert_eq!(state, State::OperationEnabled);
    }

    /// CiA 402, table of the controlword: bits 0 to 3 of each command, `x` is any.
    #[test]
    fn every_controlword_gives_the_command_of_its_four_low_bits() {
        for word in 0..=u16::MAX {
            let expected = match [3, 2, 1, 0].map(|bit| word >> bit & 1) {
                [_, _, 0, _] => DriveCommand::DisableVoltage,
                [_, 0, 1, _] => DriveCommand::QuickStop,
                [_, 1, 1, 0] => DriveCommand::Shutdown,
                [0, 1, 1, 1] => DriveCommand::SwitchOn,
                _ => DriveCommand::EnableOperation,
            };
            assert_eq!(DriveCommand::from_controlword(word), expected, "{word:#x}");
        }
    }

    #[test]
    fn the_states_are_ordered_by_what_they_allow_the_motor_to_do() {
        let rising = [
            State::SwitchOnDisabled,
            State::ReadyToSwitchOn,
            State::SwitchedOn,
            State::QuickStopActive,
            State::OperationEnabled,
        ];
        for (low, state) in rising.into_iter().enumerate() {
            for (high, other) in rising.into_iter().enumerate() {
                assert_eq!(state.is_above(other), low > high, "{state:?} {other:?}");
            }
            assert_eq!(state.is_above(State::Fault), low > 0);
            assert!(!State::Fault.is_above(state));
        }
    }

    #[test]
    fn eight_modes_and_none_are_supported_and_three_of_them_command_no_position() {
        let supported: [i8; 9] = [-2, -1, 0, 1, 3, 6, 8, 9, 10];
        for mode in i8::MIN..=i8::MAX {
            assert_eq!(
                mode::is_supported(mode),
                supported.contains(&mode),
                "{mode}"
            );
            assert_eq!(mode::controls_position(mode), ![3, 9, 10].contains(&mode));
        }
    }

    #[test]
    fn a_statusword_that_no_state_has_is_no_state() {
        for word in [0x00, 0x21, 0x4f, 0x47] {
            let state = State::from_statusword(word);
            let expected = (word == 0x21).then_some(State::ReadyToSwitchOn);
            assert_eq!(state, expected, "{word:#x}");
        }
    }

    #[test]
    fn the_bits_of_both_words_are_where_the_standard_has_them() {
        let control = [
            CONTROL_START,
            CHANGE_IMMEDIATELY,
            RELATIVE,
            CONTROL_FAULT_RESET,
            CONTROL_HALT,
        ];
        assert_eq!(control, [0x0010, 0x0020, 0x0040, 0x0080, 0x0100]);
        let status = [
            status::TARGET_REACHED,
            status::LIMIT_ACTIVE,
            status::FOLLOWING,
            status::ERROR_OF_MODE,
            status::HOMED,
            status::ALIGNING,
        ];
        assert_eq!(status, [0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000]);
        assert_eq!((mode::TAUT, mode::RELEASED), (-1, -2));
    }
}
