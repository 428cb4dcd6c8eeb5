//! The operator as the guard receives it: the newest command, its age, and the edges of its
//! requests.

use crate::bus::pdo::{DEAD_MAN_HELD, OperatorCommand, Request};
use crate::settings::{Setting, Settings};

/// The newest command, and whether the operator is still present.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    command: OperatorCommand,
    /// When the sequence number last changed, us.
    received_us: Option<u64>,
    timeout_us: u64,
    dead_man: bool,
    /// A request other than "arm" came since the guard started, began to arm, or last held the
    /// robot.
    released: bool,
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
            released: false,
        }
    }

    /// Takes a command. A changed sequence number shows that the operator is present. Returns true
    /// when the request has changed to [`Request::Reset`].
    pub fn receive(&mut self, command: OperatorCommand, now_us: u64) -> bool {
        let first = self.received_us.is_none();
        if first || command.sequence != self.command.sequence {
            self.received_us = Some(now_us);
        }
        let before = self.request();
        self.command = command;
        let request = self.request();
        self.released |= request != Request::Arm;
        request == Request::Reset && (first || before != Request::Reset)
    }

    pub fn command(&self) -> &OperatorCommand {
        &self.command
    }

    pub fn request(&self) -> Request {
        Request::from_byte(self.command.request)
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
        self.request() == Request::Disarm && self.present(now_us)
    }

    /// Returns whether the operator requests to arm, attends, and made another request before.
    pub fn arms(&self, now_us: u64) -> bool {
        self.request() == Request::Arm && self.released && self.attends(now_us)
    }

    /// Uses up the request to arm: the next one needs another request before it.
    pub fn require_new_request(&mut self) {
        self.released = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn operator(requests: &[Request]) -> Operator {
        let mut operator = Operator::new(&Settings::default());
        for (number, request) in requests.iter().enumerate() {
            let command = OperatorCommand {
                request: *request as u8,
                sequence: number as u8,
                ..OperatorCommand::default()
            };
            operator.receive(command, 0);
        }
        operator
    }

    #[test]
    fn arming_takes_another_request_before_it() {
        assert!(!operator(&[Request::Arm, Request::Arm]).arms(0));
        assert!(operator(&[Request::Stop, Request::Arm]).arms(0));
        let mut used = operator(&[Request::Disarm, Request::Arm]);
        used.require_new_request();
        assert!(!used.arms(0));
    }

    #[test]
    fn silence_is_no_request_for_motors_off() {
        assert!(!operator(&[]).disarms(0));
        let silent = operator(&[Request::Disarm]);
        assert!(silent.disarms(300_000) && !silent.disarms(300_001));
    }
}
