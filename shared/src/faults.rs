//! The table of all faults: code on the bus, name, cause, reaction, what clears the fault, and the
//! remedy. docs/faults.md is generated from it. [`Faults`] is a set of faults.

/// What a drive does by itself when a fault is raised, weakest reaction first. Of several faults
/// the strongest reaction counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Reaction {
    /// Ramps to standstill and holds the position there with the hold current.
    Hold,
    /// Opens the bridge, or shorts the windings if the back-EMF exceeds the supply and the bridge
    /// bears it ([`BridgeDemand::Brake`](crate::motor::current::BridgeDemand::Brake)).
    Brake,
    /// Opens all transistors of the bridge: the motor turns freely.
    Off,
}

/// One row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Description {
    /// Error code in object 0x603F and in the emergency frame: the code of `CiA` 301 or 402 if
    /// there is one, else 0xFFxx.
    pub code: u16,
    /// Short name that logs and reports show.
    pub name: &'static str,
    /// Condition that raises the fault: one or two sentences.
    pub cause: &'static str,
    /// What the drive does.
    pub reaction: Reaction,
    /// Longest time that was seen until the drive reacts, ms, with default settings on the motor
    /// model. A test provokes each fault and measures it.
    pub longest_ms: u16,
    /// From when this time counts.
    pub from: &'static str,
    /// What clears the fault. No drive enables itself again.
    pub clears: &'static str,
    /// What the user can check and do.
    pub remedy: &'static str,
}

macro_rules! faults {
    ($($variant:ident = $code:literal, $name:literal, $reaction:ident, $cause:literal, $longest:literal $from:literal, $clears:literal, $remedy:literal;)*) => {
        /// A fault; [`Fault::description`] returns its row of the table.
        #[allow(clippy::doc_markdown)] // the causes are sentences for readers of docs/faults.md
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Fault { $(#[doc = $cause] $variant,)* }

        /// All faults, in the order of [`TABLE`].
        pub const ALL: &[Fault] = &[$(Fault::$variant,)*];

        /// The codes alone, so that the program of a node does not contain the texts.
        const CODES: &[u16] = &[$($code),*];

        /// All rows.
        pub const TABLE: &[Description] = &[$(Description {
            code: $code, name: $name, cause: $cause, reaction: Reaction::$reaction,
            longest_ms: $longest, from: $from, clears: $clears, remedy: $remedy,
        },)*];
    };
}

// Strongest reaction first: `Faults` relies on this order.
faults! {
    SafeTorqueOff = 0xff20, "safe torque off", Off,
        "The input \"safe torque off\" is open, and the drive has power or is to get it. The input opens the bridge without software.",
        1 "the opening of the input",
        "fault reset, once the input is closed",
        "Close the emergency stop. If it is closed, measure its line.";
    ShortCircuit = 0x2340, "short circuit", Off,
        "A comparator of the bridge has seen a current of 150 % of `current_limit` plus 8 A, and opened the bridge without software.",
        1 "the current",
        "fault reset",
        "Switch the supply off. Measure the resistance between the phases and to ground. Check `resistance` and `inductance`.";
    ProcessorEvent = 0x5220, "event of the processor", Off,
        "The processor has opened the bridge without software: its supply of 3.3 V is low, its flash memory has an error of two bits, or its core has locked up. Or, after the reset that follows: its crystal has failed, its stack has overflowed, or its program has panicked or hung.",
        1 "the event",
        "fault reset",
        "Read the log: it names the event. Check the board's 3.3 V under load, and flash the board again.";
    OverCurrent = 0x2310, "over-current", Off,
        "The measured current stayed above 125 % of `current_limit` for 5 ms, or a phase current exceeded 150 % of it in two PWM periods of one millisecond. In the second case the PWM interrupt opens the bridge at once.",
        1 "the first current at the end of the converter",
        "fault reset",
        "Look for a blocked axle or a short circuit. Check resistance and inductance in the settings.";
    Overspeed = 0x7310, "overspeed", Off,
        "The measured speed stayed above 120 % of `velocity_limit` for 3 ms while the current loop was on.",
        2 "the first speed above the bound",
        "fault reset",
        "Check the order of the encoder's channels and of the motor's leads. Then check `encoder_counts`, `gear_ratio` and the gains.";
    VelocityDeviation = 0x8400, "velocity deviation", Off,
        "For 25 ms the drive gathered speed away from its set-point, against a commanded current of more than half of `current_limit`, and gave no energy back to the supply.",
        35 "the moment in which a brushed motor with swapped leads and a heavy load exceeds 20 % of `velocity_limit` in the wrong direction",
        "fault reset",
        "Two channels of the encoder or two leads of the motor are swapped: check their order.";
    OpenPhase = 0x3130, "motor lead open", Off,
        "For 8 ms the bridge gave a voltage that should drive the demanded current, and less than half of this current flowed, or a current in d as large as that flowed.",
        19 "the moment in which the lead opens, at 0.3 to 3 rad/s under 8 N m",
        "fault reset",
        "Check the leads of the motor, its connector and the bridge.";
    EncoderMismatch = 0x7320, "encoder disagrees with back-EMF", Off,
        "For 8 ms the voltage of the motor did not fit to the speed of the encoder, by more than a quarter of the back-EMF at `velocity_limit` (6 % while the encoder shows less than 1 % of `velocity_limit`), 60 % of the resistive voltage and 2 % of the supply voltage.",
        16 "the moment in which the encoder of a brushed motor, at 1.2 to 5.5 rad/s, stands still or counts backwards",
        "fault reset",
        "The encoder stands still, counts backwards or slips, or a lead of the motor is open, or `electrical_offset` or `phase_order` is wrong. If the motor runs well, check `torque_constant` and `resistance`.";
    RotorAngle = 0x7122, "rotor angle slipped", Off,
        "Above 8 % of `velocity_limit`, the back-EMF of a three-phase motor pointed more than 17 degrees away from the rotor's angle for 200 ms, or more than 37 degrees for 40 ms. Or, with `angle_watch` = 1, the back-EMF differed in 4 control periods from that of the rotor's angle by more than what the settings may be wrong by: by more than 2 % of the supply voltage, or 1 % if it alternates. Or, with `angle_watch` = 1, a current in d turned the rotor: below 20 % of `velocity_limit`, the drive adds one for 20 ms while the current rises and the shaft gains no speed.",
        4 "the moment in which the sensor slips by 30 or 60 degrees, at 1.2 to 5.5 rad/s, with `angle_watch` = 1",
        "fault reset",
        "The rotor sensor or its magnet has turned on the shaft, or `electrical_offset` is wrong: measure it anew. Or the encoder stands still or counts backwards: check its cable. Or a lead of the motor is open, while the drive needs less than 10 % of `current_limit`.";
    EncoderNoise = 0x7305, "encoder noise", Off,
        "The encoder made three steps within a few milliseconds that exceed twice `velocity_limit`. Or the index of the encoder came more than 5 counts from where it came before, or did not come in a turn of the rotor. Or the code of Hall sensors does not exist, or skipped a sector, ten times in a row, or in one PWM period of six for 80 periods, or stayed in the opposite sector for three periods, also without power. A drive that needs homing is then no longer homed.",
        6 "the first noise of 800 counts, at 1.2 to 5.5 rad/s",
        "fault reset",
        "Check the cable and the shield of the encoder, with its index, or of each Hall sensor, and `encoder_counts`.";
    Misaligned = 0x7120, "rotor not aligned", Off,
        "At arming, the rotor did not follow the turning current of the alignment, followed it in the wrong direction, or moved farther than `alignment_travel`. Or the current of the alignment took more than twice, or less than half, the voltage that `resistance` explains. Or a checked absolute sensor showed an angle that is wrong by more than 20 degrees (Hall sensors: 30 degrees), or the first pulse of an index did. Or the shaft turned against its torque, or the encoder jumped, while `probe_current` limited it.",
        23 "the set-point that turns the shaft, with a reversed encoder and a sign probe",
        "fault reset; the next arming aligns the rotor again",
        "Free the shaft. Check the order of the encoder's channels and of the motor's leads, `phase_order`, `pole_pairs`, `encoder_counts` and `resistance`. Raise `alignment_current`, or `alignment_travel`.";
    InvalidReading = 0x7300, "invalid sensor reading", Brake,
        "For 3 ms a current or voltage reading was not finite, or the PWM interrupt took no current sample, or a temperature sensor that the settings require gave no reading, or the measured currents of all half bridges did not add up to 0 within 20 % of `current_limit` and 2 % of the full scale. Or, at arming, a current reading had been above 2 % of `current_limit` plus 0.1 % of the full scale for 20 ms while the bridge was open, and the back-EMF was less than half of the supply voltage.",
        3 "the first such reading",
        "fault reset",
        "Check the analogue inputs and their wiring. If the zero of a current converter has drifted, calibrate the drive.";
    OverVoltage = 0x3210, "over-voltage", Brake,
        "The supply voltage stayed above `over_voltage` for 5 ms, or in two PWM periods of one millisecond. In the second case the PWM interrupt opens the bridge at once.",
        5 "the first voltage above the bound",
        "fault reset, once the supply voltage is back within its limits",
        "The supply cannot absorb the energy of braking: lower the deceleration or add a brake chopper.";
    UnderVoltage = 0x3220, "under-voltage", Brake,
        "The supply voltage stayed below `under_voltage` for 5 ms.",
        5 "the first voltage below the bound",
        "fault reset, once the supply voltage is back within its limits",
        "Charge the battery. Check its wiring and connectors under load.";
    OverTemperature = 0x4310, "over-temperature", Brake,
        "The temperature of the bridge stayed above `bridge_temperature`, or that of the motor above `motor_temperature`, for 20 ms.",
        20 "the first temperature above its bound",
        "fault reset, once the temperature is below its limit",
        "Let it cool down. Then lower the load, `winding_current` or `bridge_current`, or improve the cooling.";
    ControlOverrun = 0x6100, "control overrun", Brake,
        "For 3 ms the PWM interrupt ran less than half as often, or more than twice as often, as it must in a control period.",
        3 "the first missed interrupt, if two of three are missed",
        "fault reset",
        "The node is overloaded, or its firmware is wrong: look for other interrupts, and report it.";
    Blocked = 0x7121, "blocked or encoder frozen", Brake,
        "For 40 ms more than 90 % of the current limit was commanded while the measured speed stayed below 1 % of the velocity limit. Or, while `probe_current` limits, half of that current turned the rotor by less than 2.25 electrical degrees (brushed: 0.6 degrees of the rotor) in 25 ms.",
        125 "the set-point, with a shaft that cannot turn",
        "fault reset",
        "Free the axle. If it moves freely, check the encoder and its cable.";
    FollowingError = 0x8611, "following error", Hold,
        "The position stayed farther than `following_limit` from its set-point for 100 ms.",
        99 "the first position beyond the bound",
        "fault reset",
        "The drive is too weak for its load, or its gains are wrong: check both.";
    ShaftMismatch = 0x7306, "shaft sensor disagrees with encoder", Hold,
        "The shaft sensor has given the position, and since then eight of its angles in a row, 10 ms apart, differed from the encoder's position by more than 5 degrees plus the travel of 13 ms.",
        80 "the jump of the sensor by 6 degrees",
        "fault reset, once both agree, or a restart of the node",
        "The magnet has turned on the shaft, the gear slips, or the encoder has lost counts: check the mounting of both, and the cable of the encoder. A restart takes the position of the shaft sensor: check `shaft_zero` before.";
    HoldOverload = 0x8321, "hold overloaded", Hold,
        "A drive that holds after a stop needed more than `hold_current` for 32 ms. It goes on holding, with up to `current_limit`.",
        45 "the load, of 18 N m",
        "fault reset",
        "Take the load off the drive, or raise `hold_current`.";
    GuardLost = 0x8130, "guard lost", Hold,
        "The drive was under power and received no heartbeat of the guard for longer than `heartbeat_timeout`.",
        121 "the last heartbeat",
        "fault reset by the guard",
        "Check the guard's supply and the bus. The guard sends a heartbeat every `heartbeat_period`.";
    CommandLost = 0x8250, "command lost", Hold,
        "The drive was under power and received no set-point for longer than `command_timeout`.",
        61 "the last set-point",
        "fault reset by the guard",
        "Check bus load and wiring. The guard sends set-points with every SYNC.";
    JointLost = 0xff01, "chassis joint lost", Hold,
        "The screw received no motion of the chassis joint for longer than `joint_timeout`, so it cannot compute the extension that keeps the belt taut.",
        25 "the last motion",
        "fault reset by the guard",
        "Check the chassis joint's node.";
    BeltOverload = 0xff07, "belt overload", Hold,
        "The estimated tension of the belts (object `2101`) stayed above `tension_limit` for 50 ms.",
        69 "the load of a tension of 600 N",
        "fault reset",
        "Look for a stone between a belt and a pulley. Check `k`, and the homing of screw and chassis joint. If the robot is to press harder on its belts, raise `tension_limit`.";
    BeltLost = 0xff08, "belt lost", Hold,
        "The screw keeps the belts taut, they had a tension, and the estimate stayed below `tension_minimum` for 200 ms.",
        231 "the loss of a tension of 50 N",
        "fault reset",
        "Look whether a belt is broken or off its pulleys. The belts are not watched again before they have had twice `tension_minimum`.";
    HomingFailed = 0x8613, "homing failed", Hold,
        "A stage of homing did not find the edge of the home switch within 20 s, or homing moved farther from its start than the travel is wide.",
        20005 "the start of homing",
        "fault reset, then homing again",
        "Check the switch, its wiring and `homing_direction`.";
    HomingMismatch = 0xff06, "homing mismatch", Hold,
        "The two approaches of homing found the home switch at positions farther apart than `homing_tolerance`.",
        6 "the second closing of the switch",
        "fault reset, then homing again",
        "Check the switch for bouncing and its wiring for interference. Object `2002` holds the distance.";
    DuplicateId = 0x8150, "identifier sent twice", Hold,
        "The drive received a frame that only itself may send. Or the screw received the motion of the chassis joint more often than with each SYNC, or one that would move it, within a control period, 0.5 mm farther than `velocity_limit` allows.",
        1 "the frame",
        "fault reset by the guard",
        "Two nodes have the same node id, or another program sends in the name of one: give each node an id of its own.";
    NodeLost = 0xff02, "node lost", Hold,
        "The guard received no heartbeat of a drive for longer than `heartbeat_timeout`. Or, while the robot was under power, it received no motion or no status of a drive for longer than 60 ms (15 SYNC periods, if that is longer), or a drive restarted.",
        61 "the drive's last frames",
        "the operator's reset",
        "Check that node's supply, its wiring and its last log lines.";
    SecondMaster = 0xff03, "second master", Hold,
        "Another node sent a frame with an identifier that only the guard may use. A drive, while the guard's heartbeat is alive: set-points came more often than the guard sends them, once per SYNC.",
        1 "the frame",
        "the operator's reset",
        "Disconnect the other program or guard. A client commands the robot through the guard's objects.";
    UnexpectedState = 0xff04, "drive left the commanded state", Hold,
        "A drive did not reach the commanded state within 200 ms (25 SYNC periods, if that is longer), or it left this state.",
        4 "the moment in which the drive leaves the state",
        "the operator's reset",
        "Check that drive's statusword and its log. Find out which other client writes its controlword.";
    ScaleMismatch = 0xff05, "position scale differs", Hold,
        "The position scale of a drive (object `2010`) differs from the scale that the guard uses, the drive has another version of the table of settings, it has no settings besides its node id, it refused values in flash, or a save of its settings was interrupted. Object `400A` holds both codes.",
        53 "the start of the guard",
        "the same scale and table in both nodes, a restart of the drive, then the operator's reset",
        "If bit 15 of the code found is set, write the settings of that drive (object `2020` has the first refused one) and save them. If bits 12 to 14 differ, install the same version of the program in both nodes. Else set `position_bits` of that drive to the value that the guard expects.";
    TwoOperators = 0xff10, "two operators", Hold,
        "Commands came whose sequence numbers jump forth and back, as those of two operators do.",
        1 "the second jump back within 1 s",
        "the operator's reset",
        "Let only one program send `OperatorCommand` to the guard, and number its commands one by one.";
    DuplicateNode = 0xff11, "two nodes with one id", Hold,
        "Two nodes seem to send with the identifiers of one drive: three motions came within two SYNC periods, or the position jumped by more than its velocity explains, or a heartbeat came within 60 % of `heartbeat_period`.",
        1 "the third motion, the jump or the heartbeat",
        "the operator's reset",
        "Give each drive a node id of its own, and the same `heartbeat_period` as the guard's. Look for a program that sends frames of a drive.";
}

impl Fault {
    /// Returns the row of this fault in [`TABLE`].
    pub fn description(self) -> &'static Description {
        &TABLE[self as usize]
    }

    /// Returns its error code.
    pub fn code(self) -> u16 {
        CODES[self as usize]
    }

    /// Returns the fault with this error code.
    pub fn from_code(code: u16) -> Option<Self> {
        ALL.iter().copied().find(|fault| fault.code() == code)
    }
}

/// A set of faults.
///
/// It holds one bit for each fault, in the order of [`TABLE`]. So the lowest bit in the set is a
/// fault with the strongest reaction.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Faults(u64);

impl Faults {
    /// The empty set.
    pub const NONE: Self = Self(0);

    const OFF: u64 = with_reaction(Reaction::Off);
    const BRAKE: u64 = with_reaction(Reaction::Brake);

    /// The set that contains only `fault`.
    pub const fn of(fault: Fault) -> Self {
        Self(1 << fault as u64)
    }

    /// Returns true if the set contains no fault.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns true if the set contains `fault`.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::of(fault).0 != 0
    }

    /// Adds `fault` to the set if `present` is true.
    #[inline]
    pub fn insert_if(&mut self, fault: Fault, present: bool) {
        self.0 |= u64::from(present) << fault as u64;
    }

    /// Faults that are in at least one of the two sets.
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

    /// Returns the fault of the set that is first in [`TABLE`]; it has the strongest reaction.
    #[inline]
    pub fn strongest(self) -> Option<Fault> {
        ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// Returns the strongest reaction of the faults in the set.
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

/// Returns the bits of all faults with this reaction.
const fn with_reaction(reaction: Reaction) -> u64 {
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
        // Every set of up to three faults, and sets of many.
        let single = || (0..TABLE.len()).map(|row| 1_u64 << row);
        let pairs = single().flat_map(|one| single().map(move |other| one | other));
        let few = pairs.flat_map(|pair| single().map(move |one| pair | one));
        let many = (0..1 << 16)
            .map(|seed: u64| seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) % (1 << TABLE.len()));
        for bits in few.chain(many) {
            let faults = Faults(bits);
            let members = ALL.iter().filter(|fault| faults.contains(**fault));
            let reactions = members.map(|fault| fault.description().reaction);
            assert_eq!(faults.reaction(), reactions.max(), "{faults:?}");
            let strongest = faults.strongest().map(|fault| fault.description().reaction);
            assert_eq!(strongest, faults.reaction(), "{faults:?}");
        }
    }

    #[test]
    fn sets_are_united_intersected_and_subtracted_fault_by_fault() {
        let sets = |random: u64| {
            Faults(random.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 3 & ((1 << TABLE.len()) - 1))
        };
        for seed in 1..200 {
            let (first, second) = (sets(seed), sets(seed + 777));
            for fault in ALL {
                let (one, other) = (first.contains(*fault), second.contains(*fault));
                assert_eq!(first.or(second).contains(*fault), one || other);
                assert_eq!(first.and(second).contains(*fault), one && other);
                assert_eq!(first.without(second).contains(*fault), one && !other);
                let mut inserted = first;
                inserted.insert_if(*fault, false);
                assert_eq!(inserted, first);
                inserted.insert_if(*fault, true);
                assert_eq!(inserted, first.or(Faults::of(*fault)));
            }
        }
        assert!(Faults::NONE.is_empty() && !Faults::of(ALL[0]).is_empty());
    }
}
