//! The settings that adapt a node to one robot: one table with key, name, unit, bounds and default
//! of each, and the values of one node.
//!
//! A setting is an integer in a stated unit, so that flash, bus and link carry it exactly. A key
//! never changes its meaning: a new setting gets a new key. An unknown key is an error that names
//! the key. A row ends with its [`Effect`] if a drive uses a new value at once.

mod bounds;
mod units;

pub use bounds::{Bounds, Description, Effect};

use bounds::{Packed, different_numbers};
use core::fmt;

/// Index of the bus object of the setting with key 0. A key is at most 0xff, so that each setting
/// has the object `FIRST_OBJECT` + key.
pub const FIRST_OBJECT: u16 = 0x2200;

/// Version of the table. It rises if a setting gets another key (`store::Move`).
pub const SCHEMA_VERSION: u16 = 1;

/// Error of [`Settings::set`]: why a value was not stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SettingError {
    /// No setting has this key.
    UnknownKey(u16),
    /// The value is outside the bounds of its row.
    OutOfRange {
        /// The setting.
        setting: Setting,
        /// The value that was refused.
        got: i32,
    },
}

impl fmt::Display for SettingError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownKey(key) => write!(out, "no setting has the key {key:#06x}"),
            Self::OutOfRange { setting, got } => {
                let row = setting.description();
                write!(
                    out,
                    "{} = {got} {}, allowed {} to {}",
                    row.name, row.unit, row.minimum, row.maximum
                )
            }
        }
    }
}

macro_rules! settings {
    ($($(#[doc = $doc:literal])* $variant:ident = $key:literal, $name:literal, $unit:literal, $range:expr, $default:literal $(, $effect:ident)?;)*) => {
        /// A setting; [`Setting::description`] returns its row of the table.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Setting { $($(#[doc = $doc])* $variant,)* }

        /// All rows, in the order of [`Setting`].
        pub const TABLE: &[Description] = &[$({
            let range: core::ops::RangeInclusive<i32> = $range;
            let effects: &[Effect] = &[$(Effect::$effect,)? Effect::Restart];
            Description { key: $key, name: $name, unit: $unit, minimum: *range.start(), maximum: *range.end(), default: $default, effect: effects[0] }
        },)*];

        const ALL: &[Setting] = &[$(Setting::$variant,)*];

        /// Meaning of each row, in the order of [`TABLE`]. It is a table of its own, so that the
        /// program of a node does not contain these texts.
        pub const MEANINGS: &[&str] = &[$(concat!($($doc),*),)*];
    };
}

settings! {
    /// Node id of this node on the CAN bus.
    NodeId = 0x0001, "node_id", "1", 1..=127, 127;
    /// Node id of the guard. Outside bench mode, a drive can be enabled only while it receives the
    /// guard's heartbeat.
    GuardId = 0x0002, "guard_id", "1", 1..=127, 1;
    /// Period of this node's heartbeat.
    HeartbeatPeriod = 0x0003, "heartbeat_period", "ms", 10..=1_000, 50;
    /// Time without a heartbeat after which a watched node counts as lost.
    HeartbeatTimeout = 0x0004, "heartbeat_timeout", "ms", 20..=5_000, 120;
    /// Time without a set-point after which an enabled drive ramps to standstill and holds.
    CommandTimeout = 0x0005, "command_timeout", "ms", 5..=1_000, 60;
    /// Period at which the guard sends SYNC and set-points.
    SyncPeriod = 0x0006, "sync_period", "us", 1_000..=100_000, 4_000;

    /// Turns of the rotor for one turn of the output shaft.
    GearRatio = 0x0010, "gear_ratio", "1e-3", 100..=2_000_000, 60_000;
    /// Encoder counts for one turn of the rotor.
    EncoderCounts = 0x0011, "encoder_counts", "1", 4..=1_048_576, 4_096;
    /// Torque constant of the motor, at the rotor. The current of a three-phase motor is the
    /// amplitude of its phase currents.
    TorqueConstant = 0x0012, "torque_constant", "uN m/A", 100..=10_000_000, 40_000;
    /// Resistance of the motor's winding; of a three-phase motor, that of one phase.
    Resistance = 0x0013, "resistance", "mOhm", 1..=100_000, 600;
    /// Inductance of the motor's winding; of a three-phase motor, that of one phase in the axis d.
    Inductance = 0x0014, "inductance", "uH", 1..=100_000, 300;
    /// Maximum motor current.
    CurrentLimit = 0x0015, "current_limit", "mA", 10..=100_000, 10_000, Limit;
    /// Maximum motor current with which a drive should hold its position after a stop or a fault.
    /// More for 32 ms is a fault report; the drive goes on holding.
    HoldCurrent = 0x0016, "hold_current", "mA", 0..=100_000, 6_000, Limit;
    /// Maximum speed of the output shaft.
    VelocityLimit = 0x0017, "velocity_limit", "mrad/s", 1..=2_000_000, 6_000, Limit;
    /// Maximum acceleration of the output shaft, and its deceleration but in quick stops
    /// (`quick_stop_deceleration`).
    AccelerationLimit = 0x0018, "acceleration_limit", "mrad/s^2", 1..=100_000_000, 20_000, Disarmed;
    /// Gain of the position loop: velocity per position error.
    PositionGain = 0x0019, "position_gain", "1e-3/s", 0..=1_000_000, 20_000, Gain;
    /// Gain of the velocity loop: motor current per velocity error of the output shaft.
    VelocityGain = 0x001a, "velocity_gain", "mA s/rad", 0..=1_000_000, 3_000, Gain;
    /// Integral time of the velocity loop.
    VelocityIntegralTime = 0x001b, "velocity_integral_time", "us", 1_000..=10_000_000, 50_000, Gain;
    /// Acceleration feed-forward: motor current per acceleration of the output shaft.
    AccelerationFeedForward = 0x001c, "acceleration_feed_forward", "uA s^2/rad", 0..=1_000_000_000, 0, Gain;
    /// Bandwidth of the current loop.
    CurrentBandwidth = 0x001d, "current_bandwidth", "rad/s", 100..=20_000, 4_000;
    /// Fraction bits of a turn in objects 0x6064 and 0x607A of an axle: their unit is
    /// 2^-`position_bits` turn of the output shaft. The screw does not use it.
    PositionBits = 0x001e, "position_bits", "1", 8..=32, 16;
    /// Maximum distance between set-point and position. Above it, the drive raises the fault
    /// "following error".
    FollowingLimit = 0x001f, "following_limit", "mrad", 10..=100_000, 350;
    /// Lower end of travel of the output shaft. If it is not below `position_maximum`, travel is
    /// not limited.
    PositionMinimum = 0x0020, "position_minimum", "mrad", -2_000_000_000..=2_000_000_000, 0;
    /// Upper end of travel of the output shaft.
    PositionMaximum = 0x0021, "position_maximum", "mrad", -2_000_000_000..=2_000_000_000, 0;
    /// Direction in which homing searches for the home switch: 1 or -1; 0 for an axle that needs no
    /// homing.
    HomingDirection = 0x0022, "homing_direction", "1", -1..=1, 0;
    /// Position of the output shaft at which the home switch closes when the axle moves in
    /// `homing_direction`.
    HomePosition = 0x0023, "home_position", "urad", i32::MIN..=i32::MAX, 0;
    /// Speed of the output shaft while homing searches for the home switch.
    HomingSpeed = 0x0024, "homing_speed", "mrad/s", 1..=1_000_000, 300;
    /// Maximum motor current during homing.
    HomingCurrent = 0x0025, "homing_current", "mA", 10..=100_000, 6_000;
    /// Speed of the second approach to the home switch, as a fraction of `homing_speed`.
    HomingApproach = 0x0026, "homing_approach", "1e-3", 20..=1_000, 200;
    /// Maximum distance between the positions at which the two approaches find the home switch.
    /// Above it (plus the travel of 3 ms at `homing_speed`), homing fails.
    HomingTolerance = 0x0027, "homing_tolerance", "mrad", 1..=100_000, 10;
    /// Maximum motor current in bench mode.
    BenchCurrent = 0x0028, "bench_current", "mA", 10..=100_000, 2_000, Limit;
    /// Maximum speed of the output shaft in bench mode.
    BenchSpeed = 0x0029, "bench_speed", "mrad/s", 1..=2_000_000, 1_000, Limit;

    /// Absolute angle sensor at the output shaft of an axle: 0 none; 1 AS5600; 2 AS5048B. It gives
    /// the position at power-up, so that the axle needs no homing. The motor board has it instead
    /// of limit switches. A screw has none.
    ShaftSensor = 0x002a, "shaft_sensor", "1", 0..=2, 0;
    /// Angle that the shaft sensor shows at the position 0. The position at power-up is within half
    /// a turn of the middle between `position_minimum` and `position_maximum`.
    ShaftZero = 0x002b, "shaft_zero", "1e-3 degree", -180_000..=180_000, 0;
    /// 1: the angle of the shaft sensor rises with the position. -1: it falls.
    ShaftDirection = 0x002c, "shaft_direction", "1", -1..=1, 1;

    /// Kind of the motor: 0 brushed, between half bridges a and b; 1 three-phase, with permanent
    /// magnets.
    MotorKind = 0x00c0, "motor_kind", "1", 0..=1, 0;
    /// Pole pairs of a three-phase motor.
    PolePairs = 0x00c1, "pole_pairs", "1", 1..=64, 7;
    /// Inductance of one phase of a three-phase motor in the axis q; 0: equal to `inductance`.
    InductanceQ = 0x00c2, "inductance_q", "uH", 0..=100_000, 0;
    /// Electrical angle of the rotor where its sensor reads 0, or at the pulse of its index.
    ElectricalOffset = 0x00c3, "electrical_offset", "1e-3 degree", -180_000..=180_000, 0;
    /// 1: the electrical angle rises with the counts of the rotor sensor. -1: it falls, because two
    /// leads of the motor are swapped.
    PhaseOrder = 0x00c4, "phase_order", "1", -1..=1, 1;
    /// Time for which both transistors of a half bridge are off at each edge. The current control
    /// compensates it.
    DeadTime = 0x00c5, "dead_time", "ns", 0..=2_000, 600;
    /// Code of the current converter at which no current flows out of half bridge a.
    CurrentZeroA = 0x00c6, "current_zero_a", "2^-16", 16_384..=49_152, 32_768;
    /// Code of the current converter at which no current flows out of half bridge b.
    CurrentZeroB = 0x00c7, "current_zero_b", "2^-16", 16_384..=49_152, 32_768;
    /// Correction of the current in half bridge a minus that in half bridge b, as a fraction of the
    /// current. It makes both converters measure alike.
    CurrentBalance = 0x00c8, "current_balance", "1e-4", -1_000..=1_000, 0;
    /// Maximum motor current during a calibration. `current_limit` limits it, too.
    CalibrationCurrent = 0x00c9, "calibration_current", "mA", 10..=100_000, 2_000;
    /// Maximum speed of the output shaft during a calibration.
    CalibrationSpeed = 0x00ca, "calibration_speed", "mrad/s", 1..=2_000_000, 3_000;
    /// Maximum distance of the output shaft from its position at the start of a calibration. The
    /// measurement of the torque constant of a three-phase motor, whose shaft must be free, has no
    /// such bound.
    CalibrationTravel = 0x00cb, "calibration_travel", "mrad", 1..=1_000_000, 15_000;
    /// 1: between two counts of the encoder, the velocity is at most one count per elapsed time. So
    /// it is right down to one count in ten seconds. 0: the velocity has a pulse at each count.
    CountTiming = 0x00cc, "count_timing", "1", 0..=1, 0;

    /// Rotor sensor of a three-phase motor: 0 absolute within a turn; 1 incremental encoder; 2
    /// absolute within a turn, checked; 3 incremental encoder with an index; 4 Hall sensors; 5 Hall
    /// sensors, checked. With 1, 2, 3 and 5, arming aligns the rotor once after power-up. With 1,
    /// `electrical_offset` does not count; with 2 and 3, it must be right within 20 degrees, with 5
    /// within 30 degrees. With 4 and 5, `encoder_counts` must be 384 times `pole_pairs`.
    RotorSensor = 0x00cd, "rotor_sensor", "1", 0..=5, 0;
    /// Maximum motor current of an alignment. `current_limit` limits it, too. It must turn the
    /// shaft against its friction and its load.
    AlignmentCurrent = 0x00ce, "alignment_current", "mA", 10..=100_000, 3_000;
    /// Maximum distance of the output shaft from its position at the start of an alignment. The
    /// alignment turns the rotor by up to 0.78 electrical turns in each direction.
    AlignmentTravel = 0x00cf, "alignment_travel", "mrad", 1..=100_000, 200;

    /// Deceleration of a quick stop, of a hold by the guard, and of a fault that holds; 0: equal to
    /// `acceleration_limit`.
    QuickStopDeceleration = 0x00e0, "quick_stop_deceleration", "mrad/s^2", 0..=100_000_000, 0;
    /// Maximum change of the current in torque mode (start value of object 0x6087).
    TorqueModeSlope = 0x00e1, "torque_mode_slope", "A/s", 1..=1_000_000, 1_000;
    /// Distance to the target within which the target counts as reached (start value of object
    /// 0x6067).
    PositionWindow = 0x00e2, "position_window", "mrad", 0..=100_000, 10;
    /// Time for which the position must be within `position_window` (start value of object 0x6068).
    PositionWindowTime = 0x00e3, "position_window_time", "ms", 0..=60_000, 20;

    /// Time in which the holding brake releases; 0 for a drive without a brake. The drive holds its
    /// position meanwhile.
    BrakeReleaseTime = 0x00e8, "brake_release_time", "ms", 0..=150, 0;
    /// Time in which the holding brake engages; 0 for a drive without a brake. A drive that stands
    /// holds its position meanwhile, before its bridge goes off.
    BrakeEngageTime = 0x00e9, "brake_engage_time", "ms", 0..=150, 0;

    /// Maximum motor current after power is enabled, until the shaft has turned the way of its
    /// torque. 0: `current_limit` from the beginning, as a drive needs it that carries a load at
    /// once.
    ProbeCurrent = 0x00ea, "probe_current", "mA", 0..=100_000, 0;

    /// Periods of the cogging torque in an electrical turn: the least common multiple of slots and
    /// poles, divided by the pole pairs. 0: the cogging torque is not compensated.
    CoggingPeriods = 0x00eb, "cogging_periods", "1", 0..=64, 0;
    /// Current that cancels the cogging torque, as an amplitude of the cosine of the cogging's
    /// angle, which is `cogging_periods` times the electrical angle.
    CoggingCosine = 0x00ec, "cogging_cosine", "mA", -20_000..=20_000, 0;
    /// The same for the sine.
    CoggingSine = 0x00ed, "cogging_sine", "mA", -20_000..=20_000, 0;

    /// Maximum current in d that weakens the field of a three-phase motor, so that it drives faster
    /// than the supply's voltage allows otherwise. Above that speed, a bridge that opens passes the
    /// back-EMF on to the supply. 0: no such current, but a motor that is driven faster keeps its
    /// current under control with one.
    FieldWeakeningCurrent = 0x00ee, "field_weakening_current", "mA", 0..=100_000, 0;

    /// 1: an axle with a three-phase motor watches the rotor's angle at low speed, with currents in
    /// d and by its alternating back-EMF. The bounds of both were tuned on this project's motor
    /// model, and nobody has tried them on a motor. 0: it does not. A screw has no such watch.
    AngleWatch = 0x00ef, "angle_watch", "1", 0..=1, 0;

    /// Supply voltage at which the fault "under-voltage" begins. No current is left there that
    /// draws power from the supply.
    UnderVoltage = 0x00d0, "under_voltage", "mV", 5_000..=60_000, 12_000;
    /// Supply voltage below which the power that a drive takes from the supply is reduced. After
    /// three quarters of the way to `under_voltage` it is 0. If it is not above `under_voltage`,
    /// nothing is reduced before the fault.
    MotoringVoltage = 0x00d1, "motoring_voltage", "mV", 5_000..=60_000, 14_000;
    /// Supply voltage above which the power that a braking drive returns to the supply is reduced.
    /// After three quarters of the way to `over_voltage` it is 0. If it is not below
    /// `over_voltage`, nothing is reduced before the fault.
    RegenerationVoltage = 0x00d2, "regeneration_voltage", "mV", 5_000..=60_000, 30_000;
    /// Supply voltage at which the fault "over-voltage" begins.
    OverVoltage = 0x00d3, "over_voltage", "mV", 6_000..=60_000, 32_000;
    /// Maximum current that a drive takes from the supply.
    SupplyCurrentLimit = 0x00d4, "supply_current_limit", "mA", 100..=200_000, 200_000, Disarmed;
    /// Maximum current that a braking drive returns to the supply.
    RegenerationCurrentLimit = 0x00d5, "regeneration_current_limit", "mA", 0..=200_000, 200_000, Disarmed;
    /// Maximum electrical power of the motor: mechanical power plus the losses of the winding.
    PowerLimit = 0x00d6, "power_limit", "W", 1..=20_000, 20_000, Disarmed;
    /// Speed, as a fraction of `velocity_limit`, above which the current that accelerates the axle
    /// is reduced. At 120 % of `velocity_limit`, where the fault "overspeed" begins, it is 0. The
    /// current that brakes is not reduced.
    VelocityDerating = 0x00d7, "velocity_derating", "1e-3", 1_000..=1_190, 1_100;
    /// Maximum change of the motor current, and so of the torque, per time.
    CurrentSlope = 0x00d8, "current_slope", "A/s", 1..=200_000, 200_000, Disarmed;
    /// Current that the motor's winding carries for ever. 0: every current up to `current_limit`.
    WindingCurrent = 0x00d9, "winding_current", "mA", 0..=100_000, 0;
    /// Thermal time constant of the motor's winding.
    WindingTime = 0x00da, "winding_time", "ms", 10..=100_000, 30_000;
    /// Current that the bridge carries for ever. 0: every current up to `current_limit`.
    BridgeCurrent = 0x00db, "bridge_current", "mA", 0..=100_000, 0;
    /// Thermal time constant of the bridge.
    BridgeTime = 0x00dc, "bridge_time", "ms", 10..=100_000, 2_000;
    /// Temperature of the bridge at which the fault "over-temperature" begins. 0: the board has no
    /// sensor for it.
    BridgeTemperature = 0x00dd, "bridge_temperature", "0.1 degree C", 0..=2_000, 0;
    /// Temperature of the motor at which the fault "over-temperature" begins. 0: the motor has no
    /// sensor.
    MotorTemperature = 0x00de, "motor_temperature", "0.1 degree C", 0..=2_000, 0;
    /// How far below these temperatures the current begins to be reduced. At the temperature of the
    /// fault it is 0.
    TemperatureDerating = 0x00df, "temperature_derating", "0.1 K", 1..=1_000, 200;

    /// Travel of the screw's nut for one turn of the output shaft.
    ScrewLead = 0x0030, "screw_lead", "um", 100..=100_000, 5_000;
    /// Distance between axles 1 and 2 of B2P2, `L1`.
    LengthL1 = 0x0031, "l1", "um", 1_000..=2_000_000, 320_000;
    /// Length of the fixed part of B2P2's front, `L2`. The screw adds its extension `L3`.
    LengthL2 = 0x0032, "l2", "um", 1_000..=2_000_000, 230_000;
    /// Sum `K` = `L` + `L2` + `L3` that keeps the belt taut, with the distance `L` between axles 1
    /// and 3 (Paillat et al., eq. 1).
    LengthK = 0x0033, "k", "um", 1_000..=4_000_000, 1_232_000;
    /// Node id of the chassis joint.
    JointId = 0x0034, "joint_id", "1", 1..=127, 4;
    /// Age of the newest motion of the chassis joint above which the screw ramps to standstill and
    /// holds.
    JointTimeout = 0x0035, "joint_timeout", "ms", 2..=1_000, 24;
    /// How far below the released length the screw's home switch closes. The released length is
    /// `(K - L1) / 2 - L2`. There the belt is just taut at chassis angle 0, and slack at any other.
    HomingRetreat = 0x0036, "homing_retreat", "um", 1_000..=100_000, 6_000;
    /// Speed at which the screw takes up a slack belt, and at which the slack of a belt changes
    /// that is released or tightened.
    EngageSpeed = 0x0037, "engage_speed", "um/s", 100..=500_000, 20_000;
    /// Largest slack that the screw gives the belt. A larger commanded one counts as this, and
    /// object `2000` says so.
    SlackLimit = 0x0038, "slack_limit", "um", 0..=500_000, 200_000;
    /// Slack that the guard gives the belts while the operator releases them. With the default
    /// B2P2's screw draws back to its released length at every chassis angle up to 66 degrees.
    ReleaseSlack = 0x0039, "release_slack", "um", 0..=500_000, 120_000;
    /// Tension up to which the screw tightens a released belt, for each belt. Above it the belt
    /// yields. With the default the belts haul B2P2 over a curb.
    TightenTension = 0x003a, "tighten_tension", "N", 1..=2_000, 40;
    /// Estimated tension above which the screw reports `belt overload`. The default is eight times
    /// the tension of B2P2's taut belts.
    TensionLimit = 0x003b, "tension_limit", "N", 1..=10_000, 400;
    /// Estimated tension below which the screw reports `belt lost`, if its belts are taut and had
    /// twice this tension before; 0: never.
    TensionMinimum = 0x003c, "tension_minimum", "N", 0..=2_000, 10;

    /// Node id of the left track.
    LeftId = 0x0040, "left_id", "1", 1..=127, 2;
    /// Node id of the right track.
    RightId = 0x0041, "right_id", "1", 1..=127, 3;
    /// Node id of the screw.
    ScrewId = 0x0042, "screw_id", "1", 1..=127, 5;
    /// Radius of the pulleys, including the belt on them.
    PulleyRadius = 0x0043, "pulley_radius", "um", 5_000..=500_000, 50_000;
    /// Distance between the centre lines of the two belts.
    TrackGauge = 0x0044, "track_gauge", "um", 50_000..=2_000_000, 320_000;
    /// Height of the centre of mass of B2P2's body 1 above the line through axles 1 and 2.
    BodyHeight = 0x0045, "body_height", "um", -500_000..=500_000, 0;
    /// Mass of B2P2's body 1, which carries axles 1 and 2, without payload.
    Body1Mass = 0x00b0, "body_1_mass", "mg", 1_000..=1_000_000_000, 6_356_067;
    /// Distance of body 1's centre of mass forward of axle 1.
    Body1Forward = 0x00b1, "body_1_forward", "um", -1_000_000..=1_000_000, 160_894;
    /// Distance of body 1's centre of mass to the left of the robot's middle.
    Body1Left = 0x00b2, "body_1_left", "um", -1_000_000..=1_000_000, 2_784;
    /// Mass of B2P2's body 2, the fixed part of the front.
    Body2Mass = 0x00b3, "body_2_mass", "mg", 1_000..=1_000_000_000, 897_066;
    /// Distance of body 2's centre of mass from axle 2, along the front part.
    Body2Forward = 0x00b4, "body_2_forward", "um", -1_000_000..=1_000_000, 104_083;
    /// Distance of body 2's centre of mass to the left of the robot's middle.
    Body2Left = 0x00b5, "body_2_left", "um", -1_000_000..=1_000_000, -14_127;
    /// Height of body 2's centre of mass above the line through axles 2 and 3.
    Body2Up = 0x00b6, "body_2_up", "um", -1_000_000..=1_000_000, -723;
    /// Moment of inertia of body 2 about the transverse axis through its centre of mass.
    Body2Inertia = 0x00b7, "body_2_inertia", "ug m^2", 0..=2_000_000_000, 3_144_372;
    /// Mass of B2P2's body 3, the sliding part of the front.
    Body3Mass = 0x00b8, "body_3_mass", "mg", 1_000..=1_000_000_000, 1_062_150;
    /// Distance of body 3's centre of mass from the rear end of body 3, along the front part.
    Body3Forward = 0x00b9, "body_3_forward", "um", -1_000_000..=1_000_000, 152_680;
    /// Distance of body 3's centre of mass to the left of the robot's middle.
    Body3Left = 0x00ba, "body_3_left", "um", -1_000_000..=1_000_000, 10;
    /// Height of body 3's centre of mass above the line through axles 2 and 3.
    Body3Up = 0x00bb, "body_3_up", "um", -1_000_000..=1_000_000, 90;
    /// Moment of inertia of body 3 about the transverse axis through its centre of mass.
    Body3Inertia = 0x00bc, "body_3_inertia", "ug m^2", 0..=2_000_000_000, 4_880_019;
    /// Mass of the declared payload; B2P2 carries it on body 1.
    PayloadMass = 0x0046, "payload_mass", "g", 0..=100_000, 0;
    /// Distance of the payload forward of axle 1 (crawler: of the point midway between the tracks;
    /// RT-Mover: of the middle of the body).
    PayloadForward = 0x0047, "payload_forward", "um", -1_000_000..=1_000_000, 0;
    /// Distance of the payload to the left of the robot's middle.
    PayloadLeft = 0x0048, "payload_left", "um", -1_000_000..=1_000_000, 0;
    /// Height of the payload above the line through axles 1 and 2 (crawler: above the ground;
    /// RT-Mover: above the middle of the body).
    PayloadUp = 0x0049, "payload_up", "um", -1_000_000..=1_000_000, 0;
    /// Maximum speed over ground that the guard passes on. For B2P2, the crawler and Hylos it also
    /// limits each side in a turn.
    SpeedLimit = 0x004a, "speed_limit", "um/s", 1_000..=2_000_000, 450_000;
    /// Acceleration and deceleration over ground with which the robot follows the operator.
    DriveAcceleration = 0x0051, "drive_acceleration", "um/s^2", 10_000..=10_000_000, 400_000;
    /// Maximum deceleration of the guard's own stops, as far as the margins allow. If it is below
    /// `drive_acceleration`, `drive_acceleration` counts.
    GuardDeceleration = 0x007c, "guard_deceleration", "um/s^2", 10_000..=10_000_000, 1_500_000;
    /// Maximum speed at which the guard moves the chassis joint.
    ChassisSpeed = 0x004b, "chassis_speed", "mrad/s", 10..=5_000, 500;
    /// Margin below which the guard scales commands down.
    CautionMargin = 0x004c, "caution_margin", "um", 1_000..=1_000_000, 90_000;
    /// Margin below which the guard refuses commands that lead towards the edge.
    StopMargin = 0x004d, "stop_margin", "um", 1_000..=1_000_000, 50_000;
    /// How far ahead the guard predicts the margins, in addition to the time that a stop takes.
    PredictionHorizon = 0x004e, "prediction_horizon", "ms", 0..=2_000, 150;
    /// 1: the filter limits the operator's commands. 0: every command passes.
    FilterActive = 0x004f, "filter_active", "1", 0..=1, 1;
    /// 1: the guard sends torque feed-forward (object 0x60B2) to the drives. 0: it sends none.
    FeedForward = 0x0058, "feed_forward", "1", 0..=1, 1;
    /// Time without a new command of the operator after which the robot stops.
    OperatorTimeout = 0x0050, "operator_timeout", "ms", 20..=5_000, 300;

    /// Height of the crawler's centre of gravity, without payload, above the ground under its
    /// tracks.
    CogHeight = 0x0080, "cog_height", "um", 0..=1_000_000, 45_000;
    /// Length of a track on the ground.
    ContactLength = 0x0081, "contact_length", "um", 1_000..=2_000_000, 127_000;
    /// Width of a track.
    TrackWidth = 0x0082, "track_width", "um", 1_000..=500_000, 40_000;
    /// Cohesion of the ground, `c`.
    SoilCohesion = 0x0083, "soil_cohesion", "Pa", 0..=10_000_000, 1_000;
    /// Angle of internal friction of the ground, `rho`.
    SoilFrictionAngle = 0x0084, "soil_friction_angle", "mrad", 0..=1_400, 436;
    /// Rate at which the shear stress of the ground rises with its deformation, `K1`.
    SoilK1 = 0x0085, "soil_k1", "1e-3/m", 100..=100_000_000, 40_200;
    /// Shape of the curve of the ground's shear stress over its deformation, `K2`.
    SoilK2 = 0x0086, "soil_k2", "1e-3", 1_000..=100_000, 1_000;
    /// Compensation of the slip of the tracks: 0 none, 1 by the model of the soil, 2 by this model,
    /// corrected with the speed that the GNSS receiver measures.
    SlipCompensation = 0x0087, "slip_compensation", "1", 0..=2, 1;

    /// Node id of the first drive, for a robot whose drives have consecutive ids.
    FirstDriveId = 0x0090, "first_drive_id", "1", 1..=112, 2;
    /// 1: Hylos' legs move the body away from postures in which it is close to toppling. 0: they do
    /// not.
    PostureControl = 0x0091, "posture_control", "1", 0..=1, 1;

    /// Magnetic declination: the angle of magnetic north from true north, positive to the east.
    Declination = 0x0060, "declination", "1e-3 degree", -180_000..=180_000, 0;
    /// Magnetic field of the robot itself (hard iron) at the magnetometer, forward component.
    HardIronForward = 0x0061, "hard_iron_forward", "nT", -500_000..=500_000, 0;
    /// Magnetic field of the robot itself (hard iron) at the magnetometer, component to the left.
    HardIronLeft = 0x0062, "hard_iron_left", "nT", -500_000..=500_000, 0;
    /// Magnetic field of the robot itself (hard iron) at the magnetometer, upward component.
    HardIronUp = 0x0063, "hard_iron_up", "nT", -500_000..=500_000, 0;
    /// Correction of the magnetometer for iron of the robot that the earth magnetizes (soft iron):
    /// factor from the forward component to itself.
    SoftIronForward = 0x0064, "soft_iron_forward", "1e-4", 3_000..=30_000, 10_000;
    /// Correction for soft iron: factor from the component to the left to itself.
    SoftIronLeft = 0x0065, "soft_iron_left", "1e-4", 3_000..=30_000, 10_000;
    /// Correction for soft iron: factor from each horizontal component to the other.
    SoftIronCross = 0x0066, "soft_iron_cross", "1e-4", -20_000..=20_000, 0;

    /// Margin below which the guard trips. It must be below `stop_margin`.
    TripMargin = 0x0070, "trip_margin", "um", 0..=1_000_000, 10_000;
    /// How far a margin must be above the upper limit of its band before the guard selects a better
    /// band.
    BandHysteresis = 0x0071, "band_hysteresis", "um", 0..=1_000_000, 10_000;
    /// How long the narrowest margin must stay in another band before the guard changes to it.
    /// Outside the support, two samples are enough.
    BandDwell = 0x0072, "band_dwell", "ms", 0..=5_000, 100;
    /// Force-angle that counts as the stop margin while the robot is fast. The force-angle lies
    /// between the measured force and the line from the centre of gravity to the edge (Papadopoulos
    /// and Rey).
    StopAngle = 0x0073, "stop_angle", "mrad", 0..=1_500, 100;
    /// Maximum distance between the centre of gravity and its place in the model. Every margin is
    /// reduced by it.
    CogUncertainty = 0x0074, "cog_uncertainty", "um", 0..=1_000_000, 0;
    /// Maximum load that may be on the robot without being declared. It reduces every margin.
    MassUncertainty = 0x0075, "mass_uncertainty", "g", 0..=100_000, 0;
    /// Maximum distance of the undeclared load from the centre of gravity.
    MassUncertaintyReach = 0x0076, "mass_uncertainty_reach", "um", 0..=2_000_000, 300_000;
    /// Mass of the robot without payload. B2P2 does not use it, because its bodies have masses of
    /// their own.
    RobotMass = 0x0077, "robot_mass", "g", 100..=1_000_000, 8_315;
    /// Height of the highest step off which B2P2 may fall. It limits backing up, folding the front
    /// down, and after a climb driving forward with the front raised. 0: no step.
    StepBehind = 0x007d, "step_behind", "um", 0..=1_000_000, 150_000;
    /// Maximum speed over ground while the sensors are doubted, in a supervised override and while
    /// backing off.
    CrawlSpeed = 0x0078, "crawl_speed", "um/s", 1_000..=1_000_000, 50_000;
    /// 1: a tripped robot backs off on request. 0: it does not.
    BackOff = 0x0079, "back_off", "1", 0..=1, 0;
    /// 1: commands pass only while the operator reports that the dead-man switch is held. 0: no
    /// switch is needed.
    DeadMan = 0x007a, "dead_man", "1", 0..=1, 0;
    /// Number of equal readings in a row after which an axis of the accelerometer or of the
    /// gyroscope is doubted; after twice as many it is not believed. 0: never, for a sensor whose
    /// noise is below its resolution.
    StuckReadings = 0x007b, "stuck_readings", "1", 0..=60_000, 200;

    /// Rate at which the inertial unit (accelerometer and gyroscope) measures. The guard derives
    /// from it when a reading is late, and how much the margins shrink between two readings.
    InertialRate = 0x00a0, "inertial_rate", "Hz", 20..=1_000, 1_000;
    /// Rate at which the inclinometer measures.
    InclinometerRate = 0x00a1, "inclinometer_rate", "Hz", 10..=1_000, 100;
    /// Rate at which the magnetometer measures.
    CompassRate = 0x00a2, "compass_rate", "Hz", 5..=1_000, 10;
    /// Rate at which the GNSS receiver sends fixes.
    FixRate = 0x00a3, "fix_rate", "Hz", 1..=20, 5;
    /// Mounting of the sensor board: angle of its rotation about the forward axis of the body. The
    /// board is turned about x, then about y, then about z of the body.
    MountingX = 0x00a4, "mounting_x", "1e-3 degree", -180_000..=180_000, 0;
    /// Mounting of the sensor board: angle of its rotation about the axis of the body to the left.
    MountingY = 0x00a5, "mounting_y", "1e-3 degree", -90_000..=90_000, 0;
    /// Mounting of the sensor board: angle of its rotation about the upward axis of the body.
    MountingZ = 0x00a6, "mounting_z", "1e-3 degree", -180_000..=180_000, 0;
    /// Reading of the gyroscope at rest about the forward axis of the body.
    RateAtRestX = 0x00a7, "rate_at_rest_x", "1e-3 degree/s", -20_000..=20_000, 0;
    /// Reading of the gyroscope at rest about the axis of the body to the left.
    RateAtRestY = 0x00a8, "rate_at_rest_y", "1e-3 degree/s", -20_000..=20_000, 0;
    /// Reading of the gyroscope at rest about the upward axis of the body.
    RateAtRestZ = 0x00a9, "rate_at_rest_z", "1e-3 degree/s", -20_000..=20_000, 0;
    /// Pitch that the inclinometer shows on level ground, after the mounting is accounted for.
    LevelPitch = 0x00aa, "level_pitch", "1e-3 degree", -45_000..=45_000, 0;
    /// Roll that the inclinometer shows on level ground, after the mounting is accounted for.
    LevelRoll = 0x00ab, "level_roll", "1e-3 degree", -45_000..=45_000, 0;
    /// Axes of the sensors whose signs are checked: 1 about x, 2 about y, 4 about z. The guard arms
    /// the robot only if all are (7). Set it to 0 when a sensor board is mounted.
    SensorAxes = 0x00ac, "sensor_axes", "1", 0..=7, 7;
}

/// The table without names and units, as the program of a node has it.
static PACKED: Packed<{ TABLE.len() }, { different_numbers(TABLE) }> = Packed::new(TABLE);

/// Limits of a node that has got nothing but a node id: safe for an unknown motor. The defaults
/// suit the simulated robots.
pub const UNKNOWN_MOTOR: &[(Setting, i32)] = &[
    (Setting::CurrentLimit, 1_000),
    (Setting::HoldCurrent, 500),
    (Setting::HomingCurrent, 500),
    (Setting::BenchCurrent, 500),
    (Setting::VelocityLimit, 500),
    (Setting::HomingSpeed, 100),
    (Setting::BenchSpeed, 200),
    (Setting::AccelerationLimit, 1_000),
];

/// Returns the numbers of the row of [`TABLE`] with this index; `None` behind its end.
pub fn bounds_of_row(index: usize) -> Option<Bounds> {
    ALL.get(index).map(|setting| setting.bounds())
}

impl Setting {
    /// Returns the setting with this key.
    pub fn from_key(key: u16) -> Option<Self> {
        ALL.get(PACKED.row_of(key)?).copied()
    }

    /// Returns the setting with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        ALL.iter()
            .copied()
            .find(|setting| setting.description().name == name)
    }

    /// Returns the numbers of this setting.
    pub fn bounds(self) -> Bounds {
        PACKED.bounds(self as usize)
    }

    /// Returns when a written value of this setting takes effect in a drive.
    pub fn effect(self) -> Effect {
        PACKED.effect(self as usize)
    }

    /// Returns the settings that take effect in a drive at once.
    pub fn live() -> impl Iterator<Item = Self> {
        let all = ALL.iter().copied();
        all.filter(|setting| setting.effect() != Effect::Restart)
    }

    /// Returns the row of this setting in [`TABLE`].
    pub fn description(self) -> &'static Description {
        &TABLE[self as usize]
    }
}

/// The settings of one node. Every value is within the bounds of its setting.
#[derive(Clone, Debug)]
pub struct Settings {
    values: [i32; TABLE.len()],
}

impl Default for Settings {
    fn default() -> Self {
        let mut values = [0; TABLE.len()];
        for (value, setting) in values.iter_mut().zip(ALL) {
            *value = setting.bounds().default;
        }
        Self { values }
    }
}

impl Settings {
    /// Stores the value of the setting with this key.
    ///
    /// # Errors
    /// [`SettingError`] with the unknown key, or with the setting and the value that is out of
    /// bounds. In both cases nothing is stored.
    pub fn set(&mut self, key: u16, value: i32) -> Result<(), SettingError> {
        let setting = Setting::from_key(key).ok_or(SettingError::UnknownKey(key))?;
        let row = setting.bounds();
        if value < row.minimum || value > row.maximum {
            return Err(SettingError::OutOfRange {
                setting,
                got: value,
            });
        }
        self.values[setting as usize] = value;
        Ok(())
    }

    /// Whether these are the settings of a node that has got nothing but a node id: the defaults,
    /// with the limits of [`UNKNOWN_MOTOR`].
    pub fn is_unconfigured(&self) -> bool {
        ALL.iter().zip(self.values).all(|(setting, value)| {
            let mut limits = UNKNOWN_MOTOR
                .iter()
                .filter(|(limited, _)| limited == setting);
            let default = setting.bounds().default;
            *setting == Setting::NodeId || value == limits.next().map_or(default, |limit| limit.1)
        })
    }

    /// Returns the value in the unit of its row.
    pub fn get(&self, setting: Setting) -> i32 {
        self.values[setting as usize]
    }

    /// Returns the value of the setting with this key.
    pub fn of_key(&self, key: u16) -> Option<i32> {
        Setting::from_key(key).map(|setting| self.get(setting))
    }

    /// Returns the value in the SI unit, which is its integer times the scale of its unit. Angles
    /// that the table has in degrees are in degrees, and magnetic fields are in uT.
    #[inline(never)] // an inlined copy is longer than a call, and there are some 80
    pub fn si(&self, setting: Setting) -> f32 {
        self.get(setting) as f32 * units::single(PACKED.scale(setting as usize))
    }

    /// Returns [`Self::si`]; that of `other` if the value is 0.
    pub fn si_or(&self, setting: Setting, other: Setting) -> f32 {
        self.si(match self.get(setting) {
            0 => other,
            _ => setting,
        })
    }

    /// Returns [`Self::si`] in double precision.
    pub fn si_f64(&self, setting: Setting) -> f64 {
        f64::from(self.get(setting)) * units::SCALES[PACKED.scale(setting as usize)]
    }

    /// Returns the value of a setting that is a node id.
    pub fn id(&self, setting: Setting) -> u8 {
        self.get(setting) as u8
    }

    /// Returns the value of a setting in ms as microseconds.
    pub fn milliseconds(&self, setting: Setting) -> u64 {
        self.get(setting) as u64 * 1_000
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_its_own_key_and_name_and_a_default_within_its_bounds() {
        for (index, row) in TABLE.iter().enumerate() {
            assert!(
                row.minimum <= row.default && row.default <= row.maximum,
                "{}",
                row.name
            );
            assert!((1..=0xff).contains(&row.key), "{} has no object", row.name);
            for other in &TABLE[..index] {
                assert!(
                    row.key != other.key && row.name != other.name,
                    "{} and {}",
                    row.name,
                    other.name
                );
            }
        }
    }

    /// The scale that the text of a unit states: its number or the prefix of its first letter.
    fn stated_scale(unit: &str) -> f64 {
        let digits = unit
            .bytes()
            .take_while(|byte| b"0123456789.e^-".contains(byte));
        let (number, base) = unit.split_at(digits.count());
        match (number, base.chars().next()) {
            ("2^-16", None) => 2f64.powi(-16),
            ("", Some('m' | 'u' | 'n')) if base.as_bytes()[1].is_ascii_alphabetic() => {
                // The SI unit of mass has a prefix itself, and the nodes compute in uT.
                let shift = match &base[1..] {
                    "T" => 6,
                    mass if mass.starts_with('g') => -3,
                    _ => 0,
                };
                let prefix = "mun".find(&base[..1]).unwrap() as i32;
                10f64.powi(shift - 3 * (prefix + 1))
            }
            ("", Some('g')) => 1e-3,
            ("", _) => 1.0,
            (number, _) => number.parse().unwrap(),
        }
    }

    #[test]
    fn the_scale_of_each_row_is_the_one_that_its_unit_states() {
        let mut settings = Settings::default();
        for (row, setting) in TABLE.iter().zip(ALL) {
            let scale = stated_scale(row.unit);
            for value in [row.minimum, row.default, row.maximum] {
                settings.set(row.key, value).unwrap();
                let expected = f64::from(value) * scale;
                let error = (settings.si_f64(*setting) - expected).abs();
                assert!(
                    error <= 1e-15 * expected.abs(),
                    "{} in {}",
                    row.name,
                    row.unit
                );
                // The bits of a product in single precision.
                let single = value as f32 * scale as f32;
                assert_eq!(
                    settings.si(*setting).to_bits(),
                    single.to_bits(),
                    "{}",
                    row.name
                );
            }
        }
    }

    #[test]
    fn a_node_is_unconfigured_until_a_setting_besides_its_id_is_set() {
        let mut settings = Settings::default();
        assert!(!settings.is_unconfigured());
        let id = (Setting::NodeId, 9);
        for (setting, value) in core::iter::once(&id).chain(UNKNOWN_MOTOR) {
            settings.set(setting.description().key, *value).unwrap();
        }
        assert!(settings.is_unconfigured());
        settings
            .set(Setting::GearRatio.description().key, 1_000)
            .unwrap();
        assert!(!settings.is_unconfigured());
    }

    #[test]
    fn a_refused_value_leaves_the_old_one() {
        let mut settings = Settings::default();
        let refusal = settings.set(0x0033, -1);
        assert_eq!(
            refusal,
            Err(SettingError::OutOfRange {
                setting: Setting::LengthK,
                got: -1
            })
        );
        assert_eq!(settings.get(Setting::LengthK), 1_232_000);
        assert_eq!(
            settings.set(0xffff, 0),
            Err(SettingError::UnknownKey(0xffff))
        );
    }
}
