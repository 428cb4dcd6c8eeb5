//! Interface between the current control and the power stage of a board: readings and commands of
//! one PWM period.
//!
//! A board converts nothing: it passes the codes of its converter and the counts of its rotor
//! sensor, and writes the compare values to its timer. [`Ratings`] says what a code and a compare
//! value mean on this board.

use crate::math::cubic::mul_high;

/// What the current control must know of a power stage.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ratings {
    /// PWM periods per second, Hz; also the rate of the current samples.
    pub pwm_hz: u32,
    /// Compare value of a half bridge whose high side is always on; 64 to 2^15.
    pub period: u16,
    /// Largest compare value, after the compensation of the dead time, with which the low side of a
    /// half bridge charges the supply of the high side's driver; at most `period`.
    pub highest: u16,
    /// Largest compare value with which the low side conducts long enough to sample its current. In
    /// each vector that the bridge gives, two half bridges are below 91.4 % of `period` and half a
    /// dead time.
    pub sampled: u16,
    /// Current that the code 0 or 2^16 - 1 means, A.
    pub full_scale: f32,
    /// Highest supply voltage that the board bears, V. The diodes of an open bridge charge its
    /// capacitor.
    pub highest_supply: f32,
}

/// Part of the supply voltage that the bridge gives at most, between two terminals, before the
/// compensation of the dead time.
pub const MAX_DUTY: f32 = 0.95;

/// Readings of one PWM period.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Readings {
    /// Codes of the currents out of half bridges a and b, 16 bits, left-aligned. The zero is
    /// [`CurrentSensing::zero`]; larger codes are currents into the motor.
    pub currents: [u16; 2],
    /// The same of half bridge c, on a board that measures it. The sum of the three is checked
    /// then.
    pub third: Option<u16>,
    /// Count of the rotor sensor of a three-phase motor: within a turn of the rotor, or from turn
    /// to turn, wrapping at 2^32. A brushed motor needs none.
    pub rotor: u32,
    /// The supply voltage is above `over_voltage`. A board that does not compare it in each period
    /// passes `false`.
    pub over_voltage: bool,
}

impl Default for Readings {
    /// No current, no motion and a good supply.
    fn default() -> Self {
        Self {
            currents: [1 << 15; 2],
            third: None,
            rotor: 0,
            over_voltage: false,
        }
    }
}

/// Command to the power stage for one PWM period.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum PowerStage {
    /// All transistors open: the currents decay through the diodes, and the rotor turns freely.
    #[default]
    Off,
    /// All low sides on: the windings are shorted, and the back-EMF brakes the rotor.
    Brake,
    /// Compare values of half bridges a, b and c, from 0 to [`Ratings::period`]. A brushed motor is
    /// connected to a and b.
    Drive([u16; 3]),
}

/// Offset and gain of the current measurement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CurrentSensing {
    /// Codes at which no current flows. Domain: 2^14 to 3 times 2^14.
    pub zero: [i32; 2],
    /// True current divided by the current that the code means; 2^30 is one. Domain: 2^29 to
    /// 15/8 of 2^30.
    pub gain: [i32; 2],
}

impl Default for CurrentSensing {
    fn default() -> Self {
        Self {
            zero: [1 << 15; 2],
            gain: [1 << 30; 2],
        }
    }
}

impl CurrentSensing {
    /// Largest size of a current that both converters show in both directions; 2^30 is full scale.
    pub fn range(&self) -> i32 {
        let range = |phase: usize| {
            let zero = self.zero[phase];
            let codes = Ord::min(zero, 65_535 - zero).clamp(0, 1 << 15);
            mul_high(codes << 15, self.gain[phase]) << 2
        };
        Ord::min(range(0), range(1))
    }

    /// Converts codes to currents; 2^30 is the full scale of the board.
    #[inline]
    pub fn currents(&self, [a, b]: [u16; 2]) -> [i32; 2] {
        let ([zero_a, zero_b], [gain_a, gain_b]) = (self.zero, self.gain);
        [current(a, zero_a, gain_a), current(b, zero_b, gain_b)]
    }

    /// Converts the code of half bridge c, which has this zero and the gain of b.
    #[inline]
    pub fn third(&self, code: u16, zero: i32) -> i32 {
        current(code, zero, self.gain[1])
    }
}

/// Converts a code of a converter with this zero and gain. Beyond full scale on the longer side of
/// the range, the current counts as full scale.
#[inline(always)]
#[allow(clippy::inline_always)] // the PWM interrupt calls it up to three times
fn current(code: u16, zero: i32, gain: i32) -> i32 {
    let difference = i32::from(code) - zero;
    mul_high(difference.clamp(-(1 << 15), 1 << 15) << 15, gain) << 2
}

/// What has opened the bridge without software, since the drive was disabled last.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BridgeStop {
    /// The input "safe torque off" is open.
    SafeTorqueOff,
    /// A comparator has seen a very large current.
    Comparator,
    /// An event of the processor.
    Processor,
    /// The last reset followed a failure of the crystal or the program. It comes once.
    Crash,
}
