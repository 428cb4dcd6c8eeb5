//! What makes a node belong to one robot: every setting with its key, unit, bounds and default, in one table.
//!
//! A setting is an integer in a stated unit, so that flash, bus and link carry it exactly. Keys never change their
//! meaning; a new setting gets a new key, an old one that is unknown is refused by name.

use core::fmt;

/// One row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Description {
    /// Key on the link and in flash.
    pub key: u16,
    /// Name in files and errors.
    pub name: &'static str,
    /// Unit of the integer.
    pub unit: &'static str,
    /// Smallest value.
    pub minimum: i32,
    /// Largest value.
    pub maximum: i32,
    /// Value of a node that was never told.
    pub default: i32,
}

/// Why a value was not stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SettingError {
    /// No setting has this key.
    UnknownKey(u16),
    /// The value is outside of the bounds of its row.
    OutOfRange {
        /// The row.
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
    ($($(#[doc = $doc:literal])* $variant:ident = $key:literal, $name:literal, $unit:literal, $range:expr, $default:literal;)*) => {
        /// A setting; its row is [`Setting::description`].
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Setting { $($(#[doc = $doc])* $variant,)* }

        /// All rows, in the order of [`Setting`].
        pub const TABLE: &[Description] = &[$({
            let range: core::ops::RangeInclusive<i32> = $range;
            Description { key: $key, name: $name, unit: $unit, minimum: *range.start(), maximum: *range.end(), default: $default }
        },)*];

        const ALL: &[Setting] = &[$(Setting::$variant,)*];

        /// What each row means, in the order of [`TABLE`]. Apart from it, so that no node carries the sentences.
        pub const MEANINGS: &[&str] = &[$(concat!($($doc),*),)*];
    };
}

settings! {
    /// This node on the bus.
    NodeId = 0x0001, "node_id", "1", 1..=127, 127;
    /// The guard, whose heartbeat this node needs to be enabled outside of bench mode.
    GuardId = 0x0002, "guard_id", "1", 1..=127, 1;
    /// Period of this node's heartbeat.
    HeartbeatPeriod = 0x0003, "heartbeat_period", "ms", 10..=1_000, 50;
    /// Silence of a watched heartbeat after which its node counts as lost.
    HeartbeatTimeout = 0x0004, "heartbeat_timeout", "ms", 20..=5_000, 120;
    /// Age of the newest set-point after which the axle stops by itself.
    CommandTimeout = 0x0005, "command_timeout", "ms", 5..=1_000, 60;
    /// Period of SYNC.
    SyncPeriod = 0x0006, "sync_period", "us", 1_000..=100_000, 4_000;

    /// Rotor turns for one turn of the output shaft.
    GearRatio = 0x0010, "gear_ratio", "1e-3", 100..=2_000_000, 60_000;
    /// Encoder counts in one turn of the rotor.
    EncoderCounts = 0x0011, "encoder_counts", "1", 4..=1_048_576, 4_096;
    /// Torque constant of the motor.
    TorqueConstant = 0x0012, "torque_constant", "uN m/A", 100..=10_000_000, 40_000;
    /// Winding resistance.
    Resistance = 0x0013, "resistance", "mOhm", 1..=100_000, 600;
    /// Winding inductance.
    Inductance = 0x0014, "inductance", "uH", 1..=100_000, 300;
    /// Largest motor current.
    CurrentLimit = 0x0015, "current_limit", "mA", 10..=100_000, 10_000;
    /// Largest current with which an axle holds its position after a loss or a fault.
    HoldCurrent = 0x0016, "hold_current", "mA", 0..=100_000, 6_000;
    /// Largest speed of the output shaft.
    VelocityLimit = 0x0017, "velocity_limit", "mrad/s", 1..=2_000_000, 6_000;
    /// Largest acceleration of the output shaft, and the ramp of every stop.
    AccelerationLimit = 0x0018, "acceleration_limit", "mrad/s^2", 1..=100_000_000, 20_000;
    /// Gain of the position loop.
    PositionGain = 0x0019, "position_gain", "1e-3/s", 0..=1_000_000, 20_000;
    /// Gain of the velocity loop, at the output shaft.
    VelocityGain = 0x001a, "velocity_gain", "mA s/rad", 0..=1_000_000, 3_000;
    /// Integral time of the velocity loop.
    VelocityIntegralTime = 0x001b, "velocity_integral_time", "us", 1_000..=10_000_000, 50_000;
    /// Current that accelerates the axle, at the output shaft.
    AccelerationFeedForward = 0x001c, "acceleration_feed_forward", "uA s^2/rad", 0..=1_000_000_000, 0;
    /// Bandwidth of the current loop.
    CurrentBandwidth = 0x001d, "current_bandwidth", "rad/s", 100..=20_000, 4_000;
    /// Fraction bits of a turn in objects 0x6064 and 0x607A.
    PositionBits = 0x001e, "position_bits", "1", 8..=32, 16;
    /// Distance of set-point and position after which the axle gives up following.
    FollowingLimit = 0x001f, "following_limit", "mrad", 10..=100_000, 350;
    /// Lower end of travel, output shaft; with the upper end equal there is none.
    PositionMinimum = 0x0020, "position_minimum", "mrad", -2_000_000_000..=2_000_000_000, 0;
    /// Upper end of travel, output shaft.
    PositionMaximum = 0x0021, "position_maximum", "mrad", -2_000_000_000..=2_000_000_000, 0;
    /// Direction in which the home switch lies: 1, -1, or 0 for an axle that needs no reference.
    HomingDirection = 0x0022, "homing_direction", "1", -1..=1, 0;
    /// Position of the output shaft where the home switch closes on the way in
    /// `homing_direction`.
    HomePosition = 0x0023, "home_position", "urad", i32::MIN..=i32::MAX, 0;
    /// Speed of the search for the home switch.
    HomingSpeed = 0x0024, "homing_speed", "mrad/s", 1..=1_000_000, 300;
    /// Largest current while homing.
    HomingCurrent = 0x0025, "homing_current", "mA", 10..=100_000, 6_000;
    /// Speed of the second approach to the home switch, as a fraction of `homing_speed`.
    HomingApproach = 0x0026, "homing_approach", "1e-3", 20..=1_000, 200;
    /// Distance of the places where the two approaches find the switch, above which homing fails.
    HomingTolerance = 0x0027, "homing_tolerance", "mrad", 1..=100_000, 10;
    /// Largest current in bench mode.
    BenchCurrent = 0x0028, "bench_current", "mA", 10..=100_000, 2_000;
    /// Largest speed of the output shaft in bench mode.
    BenchSpeed = 0x0029, "bench_speed", "mrad/s", 1..=2_000_000, 1_000;

    /// Travel of the screw's nut for one turn of the output shaft.
    ScrewLead = 0x0030, "screw_lead", "um", 100..=100_000, 5_000;
    /// Distance of the first two axles, `L1`.
    LengthL1 = 0x0031, "l1", "um", 1_000..=2_000_000, 320_000;
    /// Length of the second segment, `L2`.
    LengthL2 = 0x0032, "l2", "um", 1_000..=2_000_000, 230_000;
    /// Sum of the paper's eq. 1, `K`.
    LengthK = 0x0033, "k", "um", 1_000..=4_000_000, 1_232_000;
    /// The chassis joint's node.
    JointId = 0x0034, "joint_id", "1", 1..=127, 4;
    /// Age of the joint's newest state after which the screw holds.
    JointTimeout = 0x0035, "joint_timeout", "ms", 2..=1_000, 24;
    /// Distance of the screw's home switch below the released length, where it closes.
    HomingRetreat = 0x0036, "homing_retreat", "um", 1_000..=100_000, 6_000;
    /// Speed with which the screw takes up a released belt.
    EngageSpeed = 0x0037, "engage_speed", "um/s", 100..=500_000, 20_000;

    /// The left track's node.
    LeftId = 0x0040, "left_id", "1", 1..=127, 2;
    /// The right track's node.
    RightId = 0x0041, "right_id", "1", 1..=127, 3;
    /// The screw's node.
    ScrewId = 0x0042, "screw_id", "1", 1..=127, 5;
    /// Radius of the pulleys with the belt on them.
    PulleyRadius = 0x0043, "pulley_radius", "um", 5_000..=500_000, 50_000;
    /// Distance of the belts' centre lines.
    TrackGauge = 0x0044, "track_gauge", "um", 50_000..=2_000_000, 320_000;
    /// Height of the centre of mass of B2P2's body 1 above the line of axles 1 and 2.
    BodyHeight = 0x0045, "body_height", "um", -500_000..=500_000, 0;
    /// Mass of B2P2's body 1, which carries axles 1 and 2, without payload.
    Body1Mass = 0x00b0, "body_1_mass", "mg", 1_000..=1_000_000_000, 6_356_067;
    /// Place of body 1's centre of mass, forward of axle 1.
    Body1Forward = 0x00b1, "body_1_forward", "um", -1_000_000..=1_000_000, 160_894;
    /// The same, left of the middle.
    Body1Left = 0x00b2, "body_1_left", "um", -1_000_000..=1_000_000, 2_784;
    /// Mass of B2P2's body 2, the fixed part of the front.
    Body2Mass = 0x00b3, "body_2_mass", "mg", 1_000..=1_000_000_000, 897_066;
    /// Place of body 2's centre of mass, from axle 2 along the front part.
    Body2Forward = 0x00b4, "body_2_forward", "um", -1_000_000..=1_000_000, 104_083;
    /// The same, left of the middle.
    Body2Left = 0x00b5, "body_2_left", "um", -1_000_000..=1_000_000, -14_127;
    /// The same, above the line of axles 2 and 3.
    Body2Up = 0x00b6, "body_2_up", "um", -1_000_000..=1_000_000, -723;
    /// Moment of inertia of body 2 about its centre of mass, for a turn of the chassis joint.
    Body2Inertia = 0x00b7, "body_2_inertia", "ug m^2", 0..=2_000_000_000, 3_144_372;
    /// Mass of B2P2's body 3, the sliding part of the front.
    Body3Mass = 0x00b8, "body_3_mass", "mg", 1_000..=1_000_000_000, 1_062_150;
    /// Place of body 3's centre of mass, from its rear end along the front part.
    Body3Forward = 0x00b9, "body_3_forward", "um", -1_000_000..=1_000_000, 152_680;
    /// The same, left of the middle.
    Body3Left = 0x00ba, "body_3_left", "um", -1_000_000..=1_000_000, 10;
    /// The same, above the line of axles 2 and 3.
    Body3Up = 0x00bb, "body_3_up", "um", -1_000_000..=1_000_000, 90;
    /// Moment of inertia of body 3 about its centre of mass, for a turn of the chassis joint.
    Body3Inertia = 0x00bc, "body_3_inertia", "ug m^2", 0..=2_000_000_000, 4_880_019;
    /// Declared payload on body 1.
    PayloadMass = 0x0046, "payload_mass", "g", 0..=100_000, 0;
    /// Payload's place in body 1, forward of axle 1.
    PayloadForward = 0x0047, "payload_forward", "um", -1_000_000..=1_000_000, 0;
    /// Payload's place in body 1, left of the middle.
    PayloadLeft = 0x0048, "payload_left", "um", -1_000_000..=1_000_000, 0;
    /// Payload's place in body 1, above the axle line.
    PayloadUp = 0x0049, "payload_up", "um", -1_000_000..=1_000_000, 0;
    /// Largest speed over ground that the guard passes on.
    SpeedLimit = 0x004a, "speed_limit", "um/s", 1_000..=2_000_000, 450_000;
    /// Acceleration and deceleration of the robot over ground.
    DriveAcceleration = 0x0051, "drive_acceleration", "um/s^2", 10_000..=10_000_000, 400_000;
    /// Largest deceleration of the guard's own stops, as far as the margins bear it; at least the drive acceleration.
    GuardDeceleration = 0x007c, "guard_deceleration", "um/s^2", 10_000..=10_000_000, 1_500_000;
    /// Speed of the chassis joint under the guard.
    ChassisSpeed = 0x004b, "chassis_speed", "mrad/s", 10..=5_000, 500;
    /// Margin below which commands are scaled.
    CautionMargin = 0x004c, "caution_margin", "um", 1_000..=1_000_000, 90_000;
    /// Margin below which commands are refused.
    StopMargin = 0x004d, "stop_margin", "um", 1_000..=1_000_000, 50_000;
    /// How far ahead the guard extrapolates the margins, beside the time that a stop takes.
    PredictionHorizon = 0x004e, "prediction_horizon", "ms", 0..=2_000, 150;
    /// 1: the filter limits commands. 0: every command passes.
    FilterActive = 0x004f, "filter_active", "1", 0..=1, 1;
    /// 1: the guard sends the drives the torques that it knows in advance. 0: it sends none.
    FeedForward = 0x0058, "feed_forward", "1", 0..=1, 1;
    /// Age of the operator's newest command after which the robot stops.
    OperatorTimeout = 0x0050, "operator_timeout", "ms", 20..=5_000, 300;

    /// Height of the centre of gravity, without payload, above the ground that the tracks lie on.
    CogHeight = 0x0080, "cog_height", "um", 0..=1_000_000, 45_000;
    /// Length of a track on the ground.
    ContactLength = 0x0081, "contact_length", "um", 1_000..=2_000_000, 127_000;
    /// Width of a track.
    TrackWidth = 0x0082, "track_width", "um", 1_000..=500_000, 40_000;
    /// Cohesion of the ground, `c`.
    SoilCohesion = 0x0083, "soil_cohesion", "Pa", 0..=10_000_000, 1_000;
    /// Angle of the ground's internal friction, `rho`.
    SoilFrictionAngle = 0x0084, "soil_friction_angle", "mrad", 0..=1_400, 436;
    /// How fast the ground's shear stress rises with its deformation, `K1`.
    SoilK1 = 0x0085, "soil_k1", "1e-3/m", 100..=100_000_000, 40_200;
    /// Shape of the ground's shear stress over its deformation, `K2`.
    SoilK2 = 0x0086, "soil_k2", "1e-3", 1_000..=100_000, 1_000;
    /// What makes up for the slip of the tracks: 0 nothing, 1 the soil's model, 2 the model corrected by the GNSS receiver's speed.
    SlipCompensation = 0x0087, "slip_compensation", "1", 0..=2, 1;

    /// The first drive's node, of a robot whose drives have consecutive ids.
    FirstDriveId = 0x0090, "first_drive_id", "1", 1..=112, 2;
    /// 1: the legs move the body away from where it would tip over. 0: they do not.
    PostureControl = 0x0091, "posture_control", "1", 0..=1, 1;

    /// Declination: how far magnetic north lies east of true north.
    Declination = 0x0060, "declination", "1e-3 degree", -180_000..=180_000, 0;
    /// Field of the robot's own magnets at the magnetometer, forward.
    HardIronForward = 0x0061, "hard_iron_forward", "nT", -500_000..=500_000, 0;
    /// The same to the left.
    HardIronLeft = 0x0062, "hard_iron_left", "nT", -500_000..=500_000, 0;
    /// The same upward.
    HardIronUp = 0x0063, "hard_iron_up", "nT", -500_000..=500_000, 0;

    /// Margin below which the guard trips; below the stop margin.
    TripMargin = 0x0070, "trip_margin", "um", 0..=1_000_000, 10_000;
    /// How far a margin must be above a level before its band is left for the better.
    BandHysteresis = 0x0071, "band_hysteresis", "um", 0..=1_000_000, 10_000;
    /// How long margins must stay in another band before it counts; outside of the support two samples are enough.
    BandDwell = 0x0072, "band_dwell", "ms", 0..=5_000, 100;
    /// Force-angle at which a fast robot is taken to be at the stop margin.
    StopAngle = 0x0073, "stop_angle", "mrad", 0..=1_500, 100;
    /// How far the centre of gravity may be from where the model has it; every margin is narrower by it.
    CogUncertainty = 0x0074, "cog_uncertainty", "um", 0..=1_000_000, 0;
    /// Largest load that may be on the robot without being declared.
    MassUncertainty = 0x0075, "mass_uncertainty", "g", 0..=100_000, 0;
    /// How far such a load may be from the centre of gravity.
    MassUncertaintyReach = 0x0076, "mass_uncertainty_reach", "um", 0..=2_000_000, 300_000;
    /// Mass without payload of a robot whose bodies have no settings of their own; not used by B2P2.
    RobotMass = 0x0077, "robot_mass", "g", 100..=1_000_000, 8_315;
    /// Highest step that may be behind B2P2. It limits backing and folding the front down; 0: nothing.
    StepBehind = 0x007d, "step_behind", "um", 0..=1_000_000, 150_000;
    /// Largest speed over ground while sensors are in doubt, in a supervised override and when backing off.
    CrawlSpeed = 0x0078, "crawl_speed", "um/s", 1_000..=1_000_000, 50_000;
    /// 1: a tripped robot backs off on request. 0: it does not.
    BackOff = 0x0079, "back_off", "1", 0..=1, 0;
    /// 1: nothing passes unless the operator's commands say that the dead-man switch is held. 0: there is none.
    DeadMan = 0x007a, "dead_man", "1", 0..=1, 0;
    /// Equal readings in a row after which a sensor on the body counts as stuck; 0: never.
    StuckReadings = 0x007b, "stuck_readings", "1", 0..=60_000, 200;
}

impl Setting {
    /// The setting with this key.
    pub fn from_key(key: u16) -> Option<Self> {
        ALL.iter()
            .copied()
            .find(|setting| setting.description().key == key)
    }

    /// The setting with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        ALL.iter()
            .copied()
            .find(|setting| setting.description().name == name)
    }

    /// Its row of [`TABLE`].
    pub fn description(self) -> &'static Description {
        &TABLE[self as usize]
    }
}

/// The settings of one node. Every value that it holds is within its bounds.
#[derive(Clone, Debug)]
pub struct Settings {
    values: [i32; TABLE.len()],
}

impl Default for Settings {
    fn default() -> Self {
        let mut values = [0; TABLE.len()];
        for (value, row) in values.iter_mut().zip(TABLE) {
            *value = row.default;
        }
        Self { values }
    }
}

impl Settings {
    /// Stores one value by key.
    ///
    /// # Errors
    /// [`SettingError`] names the key or the value with its bounds; nothing is stored then.
    pub fn set(&mut self, key: u16, value: i32) -> Result<(), SettingError> {
        let setting = Setting::from_key(key).ok_or(SettingError::UnknownKey(key))?;
        let row = setting.description();
        if value < row.minimum || value > row.maximum {
            return Err(SettingError::OutOfRange {
                setting,
                got: value,
            });
        }
        self.values[setting as usize] = value;
        Ok(())
    }

    /// The value in the unit of its row.
    pub fn get(&self, setting: Setting) -> i32 {
        self.values[setting as usize]
    }

    /// The value times `scale`: `scaled(Setting::CurrentLimit, 1e-3)` is in ampere.
    pub fn scaled(&self, setting: Setting, scale: f32) -> f32 {
        self.get(setting) as f32 * scale
    }

    /// A value that is a node id.
    pub fn id(&self, setting: Setting) -> u8 {
        self.get(setting) as u8
    }

    /// A time in ms as microseconds.
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
