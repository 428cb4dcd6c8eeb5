//! The one table of faults: code on the bus, cause, reaction, how it clears and what the user does about it.

/// What an axle does by itself when a fault is raised.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// Ramps to standstill and holds the position there with the hold current.
    Hold,
    /// Shorts the motor's windings: it resists motion without supply.
    Brake,
}

/// One row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Description {
    /// Error code in object 0x603F and in EMCY (`CiA` 301 and 402 where they have one, else 0xFFxx).
    pub code: u16,
    /// Short name, as logs and reports show it.
    pub name: &'static str,
    /// What happened.
    pub cause: &'static str,
    /// What the axle does.
    pub reaction: Reaction,
    /// What clears it. Nothing re-enables an axle by itself.
    pub clears: &'static str,
    /// What the user does about it.
    pub remedy: &'static str,
}

macro_rules! faults {
    ($($variant:ident = $code:literal, $name:literal, $reaction:ident, $cause:literal, $clears:literal, $remedy:literal;)*) => {
        /// A fault; its row is [`Fault::description`].
        #[allow(clippy::doc_markdown)] // the causes are sentences for people
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Fault { $(#[doc = $cause] $variant,)* }

        /// All faults, in the order of [`TABLE`].
        pub const ALL: &[Fault] = &[$(Fault::$variant,)*];

        /// All rows.
        pub const TABLE: &[Description] = &[$(Description {
            code: $code, name: $name, cause: $cause, reaction: Reaction::$reaction, clears: $clears, remedy: $remedy,
        },)*];
    };
}

faults! {
    OverCurrent = 0x2310, "over-current", Brake,
        "The measured current stayed above 125 % of the limit for 5 ms.", "fault reset",
        "Look for a blocked axle or a short circuit; check resistance and inductance in the settings.";
    OverVoltage = 0x3210, "over-voltage", Brake,
        "The supply stayed above 32 V for 5 ms.", "fault reset, once the supply is back",
        "The supply cannot take the energy of braking: lower the deceleration or add a brake chopper.";
    UnderVoltage = 0x3220, "under-voltage", Brake,
        "The supply stayed below 12 V for 5 ms.", "fault reset, once the supply is back",
        "Charge the battery; check its wiring and connectors under load.";
    Blocked = 0x7121, "blocked or encoder frozen", Brake,
        "Nearly the largest current was asked for during 60 ms while the encoder counted next to nothing.", "fault reset",
        "Free the axle; if it moves freely, check the encoder and its cable.";
    InvalidReading = 0x7300, "invalid sensor reading", Brake,
        "A current or voltage reading was not a finite number.", "fault reset",
        "Check the analogue inputs and their wiring.";
    GuardLost = 0x8130, "guard lost", Hold,
        "The guard's heartbeat stayed out longer than heartbeat_timeout.", "fault reset by the guard",
        "Look at the guard's supply and at the bus; its heartbeat comes every heartbeat_period.";
    CommandLost = 0x8250, "command lost", Hold,
        "No set-point came for longer than command_timeout.", "fault reset by the guard",
        "Look at bus load and wiring; set-points come with every SYNC.";
    JointLost = 0xff01, "chassis joint lost", Hold,
        "The chassis joint's state stayed out longer than joint_timeout, so that the belt's length is not known.",
        "fault reset by the guard", "Look at the chassis joint's node.";
    NodeLost = 0xff02, "node lost", Hold,
        "The guard no longer hears a drive: its heartbeat or its state stayed out.", "the operator's reset",
        "Look at that node's supply, its wiring, and its last log lines.";
    SecondMaster = 0xff03, "second master", Hold,
        "A frame with an identifier that only the guard sends came from another node.", "the operator's reset",
        "Disconnect the other program or guard; a client commands the robot through the guard's objects.";
    UnexpectedState = 0xff04, "drive left the commanded state", Hold,
        "A drive did not reach the commanded state within 200 ms, or left it for 20 ms.", "the operator's reset",
        "Look at that drive's statusword, at its log, and at who else writes its controlword.";
    ScaleMismatch = 0xff05, "position scale differs", Hold,
        "A drive's position scale (object 2010) is not the one that the guard counts in; object 400A has both.",
        "the same scale in both nodes, and a restart of the drive",
        "Set position_bits of that drive to the value that the guard expects.";
    FollowingError = 0x8611, "following error", Hold,
        "The position stayed more than following_limit away from its set-point for 100 ms.", "fault reset",
        "The axle is too weak for its load or its gains are wrong.";
    ReferenceFailed = 0x8613, "reference failed", Hold,
        "The reference switch was not found within 20 s.", "a new reference run",
        "Check the switch, its wiring and reference_direction.";
}

impl Fault {
    /// Its row of [`TABLE`].
    pub fn description(self) -> &'static Description {
        &TABLE[self as usize]
    }

    /// The fault with this error code.
    pub fn from_code(code: u16) -> Option<Self> {
        ALL.iter()
            .copied()
            .find(|fault| fault.description().code == code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_fault_lacks_a_code_of_its_own_or_a_text() {
        for (index, row) in TABLE.iter().enumerate() {
            assert!(
                row.code != 0 && !TABLE[..index].iter().any(|other| other.code == row.code),
                "{row:?}"
            );
            for text in [row.name, row.cause, row.clears, row.remedy] {
                assert!(text.len() > 5, "{row:?}");
            }
            assert_eq!(Fault::from_code(row.code), Some(ALL[index]));
        }
    }
}
