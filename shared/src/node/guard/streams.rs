//! Recognises two operators by their sequence numbers.
//!
//! The numbers of one operator only rise; some may be missing, because frames are lost. Between
//! those of a second operator they jump forth and back. One such jump may be a flipped bit or an
//! operator's program that starts again, so it takes two of them.

use crate::bus::pdo::{DEAD_MAN_HELD, OperatorCommand};

/// Number of commands that may be lost in a row.
const LOST: u8 = 8;
/// Time within which two jumps show two operators, us.
const WINDOW_US: u64 = 1_000_000;

/// The sequence numbers that came.
#[derive(Clone, Debug, Default)]
pub(super) struct Streams {
    newest: Option<OperatorCommand>,
    /// Sequence number before the last jump.
    other: Option<u8>,
    /// When the last jump back came, us, and the last one within [`WINDOW_US`] of another.
    jumped_us: Option<u64>,
    two_us: Option<u64>,
}

impl Streams {
    /// Takes a command, and returns whether it shows that there are two operators.
    pub fn receive(&mut self, command: OperatorCommand, now_us: u64) -> bool {
        let Some(newest) = self.newest.replace(command) else {
            return false;
        };
        let number = command.sequence;
        let follows = |before: u8| (1..=LOST).contains(&number.wrapping_sub(before));
        if follows(newest.sequence) {
            return false;
        }
        let back = if number == newest.sequence {
            differ(command, newest)
        } else {
            let continues = self.other.replace(newest.sequence).is_some_and(follows);
            continues || newest.sequence.wrapping_sub(number) <= LOST
        };
        if !back {
            return false;
        }
        let found = recent(self.jumped_us.replace(now_us), now_us);
        if found {
            self.two_us = Some(now_us);
        }
        found
    }

    /// Returns whether two operators were recognised within the last second.
    pub fn are_two(&self, now_us: u64) -> bool {
        recent(self.two_us, now_us)
    }
}

fn recent(time_us: Option<u64>, now_us: u64) -> bool {
    time_us.is_some_and(|time_us| now_us.saturating_sub(time_us) <= WINDOW_US)
}

/// Returns whether two commands with the same number differ in more than the dead-man switch, which
/// the guard's board may change.
fn differ(command: OperatorCommand, other: OperatorCommand) -> bool {
    let request = |command: OperatorCommand| command.request | DEAD_MAN_HELD;
    let motion = |command: OperatorCommand| (command.forward, command.yaw_rate, command.posture);
    request(command) != request(other) || motion(command) != motion(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(numbers: impl IntoIterator<Item = (u8, i16)>) -> bool {
        let mut streams = Streams::default();
        let mut found = false;
        for (step, (sequence, forward)) in numbers.into_iter().enumerate() {
            let command = OperatorCommand {
                forward,
                sequence,
                ..OperatorCommand::default()
            };
            found |= streams.receive(command, 20_000 * step as u64);
        }
        found
    }

    #[test]
    fn one_operator_who_loses_commands_starts_again_or_has_a_flipped_bit_is_one() {
        assert!(!found((0..600).map(|number| (number as u8, 0))));
        for lost in 1..=7_usize {
            assert!(!found(
                (0..600).step_by(lost).map(|number| (number as u8, 0))
            ));
        }
        for start in 0..=u8::MAX {
            let again = (0..20).map(|number| (start.wrapping_add(number), 0));
            assert!(!found((0..20).map(|number| (number, 0)).chain(again)));
        }
        for bit in 0..8 {
            let flipped = |number: u8| number ^ if number == 100 { 1 << bit } else { 0 };
            assert!(!found((0..200).map(|number| (flipped(number), 0))), "{bit}");
        }
    }

    /// The second operator sends between any two commands of the first, or every few of them.
    #[test]
    fn interleaved_operators_are_two_whatever_their_numbers_and_rates_are() {
        for start in 0..=u8::MAX {
            for every in 1..=8_u8 {
                let both = (0..60_u8).flat_map(|number| {
                    let second = start.wrapping_add(number / every);
                    let second = number.is_multiple_of(every).then_some((second, 300));
                    [Some((number, 0)), second].into_iter().flatten()
                });
                assert!(found(both), "from {start}, every {every}");
            }
        }
    }
}
