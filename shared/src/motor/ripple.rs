//! Finds a back-EMF that does not belong to the rotor's angle: the encoder stands still, slips or
//! counts backwards, or two leads are swapped.
//!
//! A rotor that swings in a field, or turns relative to the axes of its sensor, has its back-EMF
//! there as an alternating voltage. The errors of a healthy drive hardly alternate: that of the
//! resistance changes with the current alone, and that of the dead time is nearly constant. So the
//! bound of an alternating voltage is much lower than that of a constant one. A score counts the
//! control periods in which one of the two bounds is exceeded, so that a swing need not exceed it
//! all the time.

use super::current::VOLTAGE_FULL_SCALE;
use crate::math::limit;

/// Part of the difference to a new value that the filters cover in a control period: 10 ms.
const FILTER: f32 = 0.1;
/// Part of a change of the back-EMF that an angle leaves in d which still counts as right: the sine
/// of 20 degrees.
const RIGHT: f32 = 0.35;

/// What a control period adds to the score if it exceeds a bound; else 1 is subtracted.
const EXCEEDS: u8 = 2;
/// Score of a wrong back-EMF. Sound drives reached 4 under the loads of
/// `shared/tests/node/motor_faults/wrong_angle.rs`.
const WRONG: u8 = 8;
/// The same while the current does not follow its demand.
const SURELY_WRONG: u8 = 44;
/// Score below which the back-EMF counts as right.
const CALM: u8 = 4;

/// Voltages of one control period, V, and their bounds.
#[derive(Clone, Copy, Debug)]
pub struct Unexplained {
    /// Voltages in d and q that nothing explains.
    pub voltage: [f32; 2],
    /// Back-EMF by the encoder.
    pub emf: f32,
    /// Current that makes the torque, A.
    pub current: f32,
    /// Resistance by which the settings may be wrong, ohm.
    pub resistance: f32,
    /// Bound of an alternating voltage, without that of a changing current or back-EMF.
    pub alternating: f32,
    /// What is added to it while the current changes its sign: the error of the dead time, which
    /// does so, too.
    pub crossing: f32,
    /// Bound of any voltage.
    pub whole: f32,
    /// The current follows its demand.
    pub follows: bool,
}

/// Filtered voltages, and the score.
#[derive(Clone, Debug, Default)]
pub struct Ripple {
    /// Means of the voltages in d and q, V, of the back-EMF, V, and of the current, A.
    means: Option<[f32; 4]>,
    score: u8,
}

impl Ripple {
    /// Forgets everything: the voltage is not known.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Returns whether the back-EMF fits to the rotor's angle.
    pub fn is_calm(&self) -> bool {
        self.score < CALM
    }

    /// Evaluates one control period. NaN counts as 0. Returns whether the back-EMF is wrong. If the
    /// current does not follow its demand, a lead may be open, and another watch finds this first.
    #[inline]
    pub fn update(&mut self, now: &Unexplained) -> bool {
        let [d, q] = now.voltage;
        let values = [d, q, now.emf, now.current].map(|value| limit(value, VOLTAGE_FULL_SCALE));
        let [d, q, ..] = values;
        let means = self.means.get_or_insert(values);
        let mut away = [0.0; 4];
        for ((mean, value), away) in means.iter_mut().zip(values).zip(&mut away) {
            *mean += (value - *mean) * FILTER;
            *away = value - *mean;
        }
        let [away_d, away_q, emf, current] = away;
        let crosses = means[3] * values[3] < 0.0;
        let alternating = now.alternating
            + RIGHT * emf.abs()
            + now.resistance * current.abs()
            + if crosses { now.crossing } else { 0.0 };
        let exceeds = away_d * away_d + away_q * away_q > alternating * alternating
            || d * d + q * q > now.whole * now.whole;
        self.score = if exceeds {
            self.score.saturating_add(EXCEEDS)
        } else {
            self.score.saturating_sub(1)
        };
        self.score >= if now.follows { WRONG } else { SURELY_WRONG }
    }
}
