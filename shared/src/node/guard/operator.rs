//! The operator as the guard receives it: the newest command, its age, and the requests that
//! persist.
//!
//! A request that releases the robot (to arm, to reset, to disarm) counts when three commands with
//! consecutive sequence numbers have made it. So neither a flipped bit nor a second operator's
//! commands between those of the first make one. Every request to stop counts at once.

use super::streams::Streams;
use crate::bus::pdo::{BELTS_RELEASED, CLEARANCE, DEAD_MAN_HELD, OperatorCommand, Request};
use crate::settings::{Setting, Settings};

/// Number of commands in a row that make a request.
const PERSISTENT: u8 = 3;

/// What a command brings besides itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Event {
    /// The request has changed to [`Request::Reset`], and persists.
    Reset,
    /// The sequence numbers are those of two operators.
    TwoOperators,
}

/// The newest command, and whether the operator is still present.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    command: OperatorCommand,
    /// When the sequence number last changed, us.
    received_us: Option<u64>,
    timeout_us: u64,
    dead_man: bool,
    /// Number of commands in a row with the newest request, up to [`PERSISTENT`].
    repeated: u8,
    /// A request to drive has persisted, and no other request came since.
    driving: bool,
    /// A request other than to drive has persisted since the guard started, began to arm, or last
    /// held the robot.
    released: bool,
    streams: Streams,
}

impl Operator {
    /// Creates the state before the first command. The request is [`Request::Stop`].
    pub fn new(settings: &Settings) -> Self {
        Self {
            command: OperatorCommand {
                request: Request::Stop as u8,
                ..OperatorCommand::default()
            },
            received_us: None,
            timeout_us: settings.milliseconds(Setting::OperatorTimeout),
            dead_man: settings.get(Setting::DeadMan) == 1,
            repeated: 0,
            driving: false,
            released: false,
            streams: Streams::default(),
        }
    }

    /// Takes a command. A changed sequence number shows that the operator is present.
    pub fn receive(&mut self, command: OperatorCommand, now_us: u64) -> Option<Event> {
        let before = (self.request(), self.persists());
        let consecutive = command.sequence == self.command.sequence.wrapping_add(1);
        let again = command.sequence == self.command.sequence;
        let mixed = self.streams.receive(command, now_us);
        if self.received_us.is_none() || !again {
            self.received_us = Some(now_us);
        }
        self.command = command;
        let request = self.request();
        self.repeated = match request == before.0 {
            true if consecutive && !self.persists() => self.repeated + 1,
            true if (consecutive || again) && self.repeated > 0 => self.repeated,
            _ => 1,
        };
        self.driving = request.drives() && (self.driving || self.persists());
        self.released |= !request.drives() && self.persists();
        // The second operator must have gone before a reset counts.
        let resets = request == Request::Reset && self.persists() && !self.streams.are_two(now_us);
        if mixed {
            Some(Event::TwoOperators)
        } else {
            (resets && before != (Request::Reset, true)).then_some(Event::Reset)
        }
    }

    pub fn command(&self) -> &OperatorCommand {
        &self.command
    }

    pub fn request(&self) -> Request {
        Request::from_byte(self.command.request)
    }

    /// Returns whether the newest command releases the belts.
    pub fn releases_belts(&self) -> bool {
        self.command.request & BELTS_RELEASED != 0
    }

    /// Returns whether the newest command lets the robot clear obstacles by itself.
    pub fn lets_clear(&self) -> bool {
        self.command.request & CLEARANCE != 0
    }

    /// Returns whether enough commands in a row have made the newest request.
    fn persists(&self) -> bool {
        self.repeated >= PERSISTENT
    }

    /// Returns whether a command with a new sequence number came within `operator_timeout`.
    pub fn present(&self, now_us: u64) -> bool {
        self.received_us
            .is_some_and(|received| now_us.saturating_sub(received) <= self.timeout_us)
    }

    /// Returns whether the operator is present, and holds the dead-man switch if the settings
    /// require one.
    pub fn attends(&self, now_us: u64) -> bool {
        let held = !self.dead_man || self.command.request & DEAD_MAN_HELD != 0;
        self.present(now_us) && held
    }

    /// Returns whether a present operator requests motors off.
    pub fn disarms(&self, now_us: u64) -> bool {
        self.request() == Request::Disarm && self.persists() && self.present(now_us)
    }

    /// Returns whether an operator who attends requests to drive.
    pub fn drives(&self, now_us: u64) -> bool {
        self.driving && self.attends(now_us)
    }

    /// Returns whether the operator requests to drive, and made another request before.
    pub fn arms(&self, now_us: u64) -> bool {
        self.released && self.drives(now_us)
    }

    /// Returns whether the last request wants the robot to stand, though nobody may be there now.
    pub fn stands(&self) -> bool {
        self.received_us.is_some() && self.request() != Request::Disarm
    }

    /// Uses up the request to arm: the next one needs another request before it.
    pub fn require_new_request(&mut self) {
        self.released = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_US: u64 = 20_000;

    /// Lets an operator make each request with as many commands, 20 ms apart. Returns what the last
    /// command brought.
    fn send(operator: &mut Operator, requests: &[(Request, usize)]) -> Option<Event> {
        let mut last = None;
        for (request, count) in requests {
            for _ in 0..*count {
                let command = OperatorCommand {
                    request: *request as u8,
                    sequence: operator.command.sequence.wrapping_add(1),
                    ..OperatorCommand::default()
                };
                let now_us = operator.received_us.map_or(0, |before| before + PERIOD_US);
                last = operator.receive(command, now_us);
            }
        }
        last
    }

    fn operator(requests: &[(Request, usize)]) -> Operator {
        let mut operator = Operator::new(&Settings::default());
        send(&mut operator, requests);
        operator
    }

    #[test]
    fn arming_takes_another_request_before_it_and_both_must_persist() {
        for (others, arms, expected) in [(0, 9, false), (2, 9, false), (3, 2, false), (3, 3, true)]
        {
            for other in [Request::Stop, Request::Disarm, Request::Reset] {
                let mut operator = operator(&[(other, others), (Request::Arm, arms)]);
                assert_eq!(operator.arms(0), expected, "{other:?} {others} {arms}");
                operator.require_new_request();
                assert!(!operator.arms(0));
            }
        }
    }

    #[test]
    fn one_command_of_another_request_stops_at_once_and_releases_nothing() {
        for other in [Request::Reset, Request::Disarm, Request::Stop] {
            let mut operator = operator(&[(Request::Arm, 5)]);
            assert_eq!(send(&mut operator, &[(other, 1)]), None, "{other:?}");
            assert!(!operator.drives(0) && !operator.disarms(0), "{other:?}");
            assert_eq!(send(&mut operator, &[(Request::Arm, 5)]), None);
            assert!(operator.drives(0) && !operator.arms(0), "{other:?}");
        }
    }

    #[test]
    fn a_reset_counts_once_with_its_third_consecutive_command() {
        for (count, expected) in [(2, None), (3, Some(Event::Reset)), (4, None)] {
            let mut operator = Operator::new(&Settings::default());
            let last = send(&mut operator, &[(Request::Reset, count)]);
            assert_eq!(last, expected, "{count}");
        }
        let mut operator = operator(&[(Request::Reset, 2)]);
        for (number, what) in [(2, "the same number again"), (4, "a number is missing")] {
            let command = OperatorCommand {
                request: Request::Reset as u8,
                sequence: number,
                ..OperatorCommand::default()
            };
            assert_eq!(operator.receive(command, 60_000), None, "{what}");
        }
    }

    #[test]
    fn silence_is_no_request_for_motors_off() {
        assert!(!operator(&[]).disarms(0));
        let silent = operator(&[(Request::Disarm, 3)]);
        assert!(silent.disarms(340_000) && !silent.disarms(340_001));
        assert!(!silent.stands());
    }
}
