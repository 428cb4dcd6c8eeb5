//! Publishes the guard's state: the payloads of its TPDOs, and the counts of its interventions.

use super::Guard;
use super::interface::FaultReport;
use crate::bus::pdo::{GuardMargins, GuardMotion, GuardPassed, GuardPosition, GuardState};
use crate::bus::scale::{centi, centidegrees, micro, milli};
use crate::estimate::state::{State, Validity};
use crate::math::to_i16;
use crate::robots::{Body, PostureCommand};
use crate::stability::verdict::Verdict;

/// The newest verdict, and how often commands were refused and scaled.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    verdict: Verdict,
    refused: u32,
    scaled: u32,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            verdict: Verdict::Passed,
            refused: 0,
            scaled: 0,
        }
    }
}

impl Tally {
    /// Takes the verdict of a SYNC period. An intervention counts once, when its kind begins.
    pub fn count(&mut self, verdict: Verdict) {
        let kind = |verdict: Verdict| verdict.code() >> 4;
        if kind(verdict) != kind(self.verdict) {
            match verdict {
                Verdict::Passed => {}
                Verdict::Scaled(_) | Verdict::PostureScaled(_) | Verdict::Doubted(_) => {
                    self.scaled = self.scaled.saturating_add(1);
                }
                Verdict::Refused(_)
                | Verdict::PostureRefused(_)
                | Verdict::Blind(_)
                | Verdict::EmergencyStopped
                | Verdict::Tripped(_)
                | Verdict::Overridden(_)
                | Verdict::BackingOff(_)
                | Verdict::Unattended => {
                    self.refused = self.refused.saturating_add(1);
                }
            }
        }
        self.verdict = verdict;
    }
}

impl<B: Body> Guard<B> {
    /// Updates the payloads that every tick publishes.
    pub(super) fn publish(&mut self) {
        let [back, front, left, right] = self.balance.margins().now.map(milli);
        let fault = self.fault.unwrap_or(FaultReport { node: 0, code: 0 });
        let command = self.operator.command();
        let outputs = &mut self.outputs;
        outputs.motion = GuardMotion {
            odometry: self.body.odometry_um(),
            pitch: centidegrees(self.attitude.pitch().radians()),
            roll: centidegrees(self.attitude.roll().radians()),
        };
        outputs.state = GuardState {
            state: self.state.code(),
            verdict: self.tally.verdict.code(),
            scale: centi(self.speed_scale) as u8,
            fault_node: fault.node,
            fault_code: fault.code,
            heading: (self.attitude.heading().to_bits() >> 16) as i16,
        };
        outputs.margins = GuardMargins {
            back,
            front,
            left,
            right,
        };
        outputs.passed = GuardPassed {
            asked_speed: command.forward,
            passed_speed: milli(self.body.speed()),
            asked_posture: command.posture,
            passed_posture: self.body.posture().word(),
        };
        outputs.clearance = self.body.clearance();
        outputs.slack = self.body.slack().map(micro);
        outputs.belt_tension = to_i16(self.body.belt_tension() * 10.0);
        outputs.refused = self.tally.refused;
        outputs.scaled = self.tally.scaled;
    }
}

/// Creates the payload of TPDO 5 from the robot's state.
pub(super) fn position(state: &State) -> GuardPosition {
    let centimetres = |axis: usize| centi(state[axis].value);
    let invalid = state[0].validity == Validity::Invalid;
    GuardPosition {
        north: centimetres(0),
        east: centimetres(1),
        up: centimetres(2),
        validity: (0..4).fold(0, |bits, axis| {
            bits | (state[axis].validity as u8) << (2 * axis)
        }),
        age: if invalid {
            u8::MAX
        } else {
            u8::try_from(state[0].age_ms / 100).unwrap_or(u8::MAX)
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::support::Edge;

    #[test]
    fn an_intervention_counts_once_when_its_kind_begins() {
        let mut tally = Tally::default();
        for (verdict, refused, scaled) in [
            (Verdict::Passed, 0, 0),
            (Verdict::Scaled(Edge::Back), 0, 1),
            (Verdict::Scaled(Edge::Left), 0, 1),
            (Verdict::Refused(Edge::Left), 1, 1),
            (Verdict::Refused(Edge::Front), 1, 1),
            (Verdict::Scaled(Edge::Front), 1, 2),
            (Verdict::Passed, 1, 2),
            (Verdict::Unattended, 2, 2),
            (Verdict::Passed, 2, 2),
            (Verdict::Unattended, 3, 2),
        ] {
            tally.count(verdict);
            assert_eq!(
                (tally.refused, tally.scaled),
                (refused, scaled),
                "{verdict:?}"
            );
            assert_eq!(tally.verdict, verdict);
        }
    }

    /// Two bits of validity for each of north, east, up and heading, the lowest first.
    #[test]
    fn a_position_is_in_centimetres_and_tenths_of_a_second() {
        let mut state = State::default();
        assert_eq!(position(&state).age, u8::MAX, "no position");
        for (axis, (value, validity)) in [
            (1.23, Validity::Measured),
            (-4.5, Validity::Invalid),
            (0.07, Validity::Measured),
            (9.0, Validity::Measured),
        ]
        .into_iter()
        .enumerate()
        {
            (state[axis].value, state[axis].validity) = (value, validity);
        }
        for (age_ms, age) in [(0, 0), (99, 0), (1_200, 12), (25_499, 254), (90_000, 255)] {
            state[0].age_ms = age_ms;
            let sent = position(&state);
            assert_eq!((sent.north, sent.east, sent.up), (123, -450, 7));
            let (valid, invalid) = (Validity::Measured as u8, Validity::Invalid as u8);
            let bits = [valid, invalid, valid, valid];
            for (axis, expected) in bits.into_iter().enumerate() {
                assert_eq!(sent.validity >> (2 * axis) & 3, expected, "axis {axis}");
            }
            assert_eq!(sent.age, age);
        }
    }
}
