//! The operator's switches that are wired to a board.

/// State of the operator's switches on a board. The default is that of a board without them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct OperatorSwitches {
    /// The emergency stop is actuated.
    pub emergency_stop: bool,
    /// The dead-man switch is released.
    pub dead_man_released: bool,
}

impl OperatorSwitches {
    /// Both switches prevent motion.
    pub const ACTUATED: Self = Self {
        emergency_stop: true,
        dead_man_released: true,
    };
}
