//! The one table of faults: code on the bus, cause, reaction, how it clears and what the user does about it.

/// What an axle does by itself when a fault is raised, weakest first. Of several faults the
/// strongest reaction wins.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Reaction {
    /// Ramps to standstill and holds the position there with the hold current.
    Hold,
    /// Shorts the motor's windings: it resists motion without supply.
    Brake,
    /// Opens all transistors of the bridge: the motor turns freely.
    Off,
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

// Strongest reaction first: `Faults` relies on it.
faults! {
    OverCurrent = 0x2310, "over-current", Off,
        "The measured current stayed above 125 % of the limit for 5 ms.", "fault reset",
        "Look for a blocked axle or a short circuit; check resistance and inductance in the settings.";
    Overspeed = 0x7310, "overspeed", Off,
        "The measured velocity stayed above 120 % of velocity_limit for 3 ms while the current loop was on.",
        "fault reset",
        "Check the order of the encoder's channels and of the motor's leads, then encoder_counts, gear_ratio and the gains.";
    VelocityDeviation = 0x8400, "velocity deviation", Off,
        "The axle gathered speed away from its set-point, against more than half of the largest current, for 3 ms.",
        "fault reset",
        "Check the order of the encoder's channels and of the motor's leads: two are swapped.";
    InvalidReading = 0x7300, "invalid sensor reading", Brake,
        "For 3 ms a current or voltage reading was not a finite number, or the PWM interrupt took no current sample.",
        "fault reset", "Check the analogue inputs and their wiring.";
    OverVoltage = 0x3210, "over-voltage", Brake,
        "The supply stayed above 32 V for 5 ms.", "fault reset, once the supply is back",
        "The supply cannot take the energy of braking: lower the deceleration or add a brake chopper.";
    UnderVoltage = 0x3220, "under-voltage", Brake,
        "The supply stayed below 12 V for 5 ms.", "fault reset, once the supply is back",
        "Charge the battery; check its wiring and connectors under load.";
    Blocked = 0x7121, "blocked or encoder frozen", Brake,
        "Nearly the largest current was commanded for 60 ms while the encoder counted next to nothing.",
        "fault reset",
        "Free the axle; if it moves freely, check the encoder and its cable.";
    FollowingError = 0x8611, "following error", Hold,
        "The position stayed more than following_limit away from its set-point for 100 ms.",
        "fault reset",
        "The axle is too weak for its load or its gains are wrong.";
    GuardLost = 0x8130, "guard lost", Hold,
        "The guard's heartbeat stayed out longer than heartbeat_timeout.",
        "fault reset by the guard",
        "Look at the guard's supply and at the bus; its heartbeat comes every heartbeat_period.";
    CommandLost = 0x8250, "command lost", Hold,
        "No set-point came for longer than command_timeout.", "fault reset by the guard",
        "Look at bus load and wiring; set-points come with every SYNC.";
    JointLost = 0xff01, "chassis joint lost", Hold,
        "The chassis joint's state stayed out longer than joint_timeout, so that the belt's length is not known.",
        "fault reset by the guard", "Look at the chassis joint's node.";
    HomingFailed = 0x8613, "homing failed", Hold,
        "The home switch was not found within 20 s.", "fault reset, then homing again",
        "Check the switch, its wiring and homing_direction.";
    HomingMismatch = 0xff06, "homing mismatch", Hold,
        "The two approaches of homing found the home switch at places farther apart than homing_tolerance.",
        "fault reset, then homing again",
        "Check the switch for bouncing and its wiring for interference; object 0x2002 has the distance.";
    NodeLost = 0xff02, "node lost", Hold,
        "The guard no longer receives a drive: its heartbeat or its state stayed out.",
        "the operator's reset",
        "Look at that node's supply, its wiring, and its last log lines.";
    SecondMaster = 0xff03, "second master", Hold,
        "A frame with an identifier that only the guard sends came from another node.",
        "the operator's reset",
        "Disconnect the other program or guard; a client commands the robot through the guard's objects.";
    UnexpectedState = 0xff04, "drive left the commanded state", Hold,
        "A drive did not reach the commanded state within 200 ms (25 SYNC periods, if longer), or left it.",
        "the operator's reset",
        "Look at that drive's statusword, at its log, and at who else writes its controlword.";
    ScaleMismatch = 0xff05, "position scale differs", Hold,
        "A drive's position scale (object 2010) is not the one of the guard; object 400A has both.",
        "the same scale in both nodes, a restart of the drive, then the operator's reset",
        "Set position_bits of that drive to the value that the guard expects.";
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

/// A set of faults.
///
/// One bit for each, in the order of [`TABLE`], so that the lowest bit is a fault of the strongest
/// reaction.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Faults(u32);

impl Faults {
    /// The empty set.
    pub const NONE: Self = Self(0);

    const OFF: u32 = with_reaction(Reaction::Off);
    const BRAKE: u32 = with_reaction(Reaction::Brake);

    /// The set of one fault.
    pub const fn of(fault: Fault) -> Self {
        Self(1 << fault as u32)
    }

    /// The set of the first faults of [`TABLE`] whose bits are given, lowest first.
    pub(crate) const fn from_bits(bits: u32) -> Self {
        Self(bits & ((1 << TABLE.len()) - 1))
    }

    /// Whether no fault is in the set.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `fault` is in the set.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::of(fault).0 != 0
    }

    /// Adds `fault` if `present`.
    #[inline]
    pub fn insert_if(&mut self, fault: Fault, present: bool) {
        self.0 |= u32::from(present) << fault as u32;
    }

    /// Faults that are in either set.
    #[inline]
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Faults that are in both sets.
    #[inline]
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Faults that are in this set and not in the other.
    #[inline]
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// A fault of the strongest reaction, the first one in [`TABLE`].
    #[inline]
    pub fn strongest(self) -> Option<Fault> {
        ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// The strongest reaction.
    #[inline]
    pub const fn reaction(self) -> Option<Reaction> {
        if self.0 & Self::OFF != 0 {
            Some(Reaction::Off)
        } else if self.0 & Self::BRAKE != 0 {
            Some(Reaction::Brake)
        } else if self.0 != 0 {
            Some(Reaction::Hold)
        } else {
            None
        }
    }
}

/// Bits of the faults with this reaction.
const fn with_reaction(reaction: Reaction) -> u32 {
    let (mut bits, mut row) = (0, 0);
    while row < TABLE.len() {
        if TABLE[row].reaction as u32 == reaction as u32 {
            bits |= 1 << row;
        }
        row += 1;
    }
    bits
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

    #[test]
    fn the_table_goes_from_the_strongest_reaction_to_the_weakest() {
        assert!(TABLE.is_sorted_by(|first, second| first.reaction >= second.reaction));
    }

    #[test]
    fn the_reaction_of_a_set_is_the_strongest_of_its_faults() {
        for bits in 0..1 << TABLE.len() {
            let faults = Faults::from_bits(bits);
            let members = ALL.iter().filter(|fault| faults.contains(**fault));
            let reactions = members.map(|fault| fault.description().reaction);
            assert_eq!(faults.reaction(), reactions.max(), "{faults:?}");
            let strongest = faults.strongest().map(|fault| fault.description().reaction);
            assert_eq!(strongest, faults.reaction(), "{faults:?}");
        }
    }
}
