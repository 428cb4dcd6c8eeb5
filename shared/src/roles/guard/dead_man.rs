//! Dead-man switch that is wired to the guard's board.

use crate::bus::pdo::{DEAD_MAN_HELD, OperatorCommand};

/// The newest state of the switch.
///
/// The operator's command says that the dead-man switch is held only while the wired one is held,
/// too. So the setting `dead_man` decides about both.
#[derive(Default)]
pub(super) struct DeadMan {
    released: bool,
    /// The operator has sent a command.
    commanded: bool,
}

impl DeadMan {
    /// Returns the operator's newest command if it `came` since the last call, or if the switch has
    /// changed since. A command that is repeated for the switch has an old sequence number, so it
    /// does not count as the operator's presence.
    pub fn command(
        &mut self,
        released: bool,
        came: bool,
        newest: impl FnOnce() -> OperatorCommand,
    ) -> Option<OperatorCommand> {
        let changed = released != self.released;
        self.released = released;
        self.commanded |= came;
        (came || changed && self.commanded).then(|| {
            let mut command = newest();
            if released {
                command.request &= !DEAD_MAN_HELD;
            }
            command
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::pdo::Request;

    const ARM: u8 = Request::Arm as u8;

    fn held() -> OperatorCommand {
        OperatorCommand {
            request: ARM | DEAD_MAN_HELD,
            sequence: 7,
            ..OperatorCommand::default()
        }
    }

    #[test]
    fn a_released_switch_changes_the_command_at_once_and_in_every_later_one() {
        let mut switch = DeadMan::default();
        assert_eq!(switch.command(false, true, held), Some(held()));
        assert_eq!(switch.command(false, false, held), None);
        let released = OperatorCommand {
            request: ARM,
            ..held()
        };
        assert_eq!(switch.command(true, false, held), Some(released));
        assert_eq!(switch.command(true, false, held), None);
        assert_eq!(switch.command(true, true, held), Some(released));
        assert_eq!(switch.command(false, false, held), Some(held()));
    }

    #[test]
    fn without_an_operator_the_switch_commands_nothing() {
        let mut switch = DeadMan::default();
        for released in [true, false, true] {
            assert_eq!(switch.command(released, false, held), None);
        }
    }
}
