//! Defects on purpose, by which the tests of the images are tested. Only the program
//! `defective_axle` has them, which is never flashed.

/// Defect of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(dead_code)] // a board without a bridge has a part of them
pub enum Defect {
    /// The core runs at 170 MHz without boost mode.
    NoBoost = 1,
    /// The watchdog waits for 500 ms.
    SlowWatchdog,
    /// The thread alone feeds the watchdog.
    FedByOneParty,
    /// The bridge stays live in a panic and in a hard fault.
    LiveInFault,
    /// The bridge is live before the drive is enabled.
    LiveAtStart,
    /// Both transistors of a half bridge are on at each edge.
    NoDeadTime,
    /// The PWM runs at 20 005 Hz.
    OtherPeriod,
    /// The line "safe torque off" opens the bridge when it is closed.
    InvertedBreak,
    /// The pin of "safe torque off" has another alternate function.
    WrongFunction,
    /// The current interrupt waits for all others.
    LowPriority,
    /// The control task masks all interrupts for 20 us.
    MaskedLong,
    /// The bus runs at 500 kbit/s.
    SlowBus,
    /// The controller stays off after a bus-off.
    NoRecovery,
    /// Frames wait for the bus as long as it is gone.
    OldFrames,
}

/// Number of the defect, 0 for none. The tests change it in the flash image.
#[cfg(feature = "defects")]
#[used]
static DEFECT: u8 = 0;

/// Whether the program has this defect.
#[inline]
#[allow(dead_code)] // the tests include this file for the numbers
pub fn has(defect: Defect) -> bool {
    #[cfg(feature = "defects")]
    return *core::hint::black_box(&DEFECT) == defect as u8;
    #[cfg(not(feature = "defects"))]
    {
        let _ = defect;
        false
    }
}
