//! Requests, progress and results of the commissioning.

/// Requests of object 0x2110.
pub mod request {
    /// No step; ends one that is under way.
    pub const NONE: u8 = 0;
    /// The robot stands still on level ground: tilt of the board, gyroscope at rest, zero of the
    /// inclinometer.
    pub const LEVEL: u8 = 1;
    /// The robot stands still with its nose raised, at the same heading: direction of the board,
    /// signs about the transverse axis.
    pub const NOSE_UP: u8 = 2;
    /// The robot stands still with its left side raised: signs about the longitudinal axis.
    pub const LEFT_UP: u8 = 3;
    /// The robot turns once on level ground: the compass, signs about the vertical axis.
    pub const TURN: u8 = 4;
}

/// Values of object 0x2111:1 besides the request under way.
pub mod progress {
    /// The last step is done.
    pub const DONE: u8 = 100;
    /// The last step was refused.
    pub const REFUSED: u8 = 101;
}

/// Why a step was refused (object 0x2111:2).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// The robot is not disarmed.
    NotDisarmed = 1,
    /// An earlier step is missing.
    Order = 2,
    /// The gyroscope moved by this much, 1e-3 rad/s.
    Moved = 3,
    /// The accelerometer does not read 1 g, but this much, 1e-3 m/s^2.
    NotGravity = 4,
    /// The gyroscope reads this much at rest, 1e-3 rad/s.
    RateAtRest = 5,
    /// The robot is raised by this little, 1e-3 rad, or the wrong side is.
    NotRaised = 6,
    /// Gyroscope and accelerometer disagree on the rotation since the level rest by this much, 1e-3
    /// rad: an axis has the wrong sign, or is another one.
    GyroscopeSign = 7,
    /// Inclinometer and accelerometer disagree by this much, 1e-3 rad.
    Inclinometer = 8,
    /// The magnetometer gave too few readings, this many.
    TooFewFields = 9,
    /// The readings of the magnetometer are no ellipse, or one with this radius, nT.
    NoEllipse = 10,
    /// The field did not turn against the robot: an axis of the magnetometer has the wrong sign.
    MagnetometerSign = 11,
    /// The step took too long.
    Timeout = 12,
    /// There is no such request.
    Unknown = 13,
}

/// Values of the settings that the steps have found since power-up, in the units of the settings.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[allow(missing_docs)] // named as the settings
pub struct Values {
    pub mounting: [i32; 3],
    pub rate_at_rest: [i32; 3],
    pub level: [i32; 2],
    pub hard_iron: [i32; 3],
    pub soft_iron: [i32; 3],
}

/// Progress and results, as object 0x2111 shows them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Report {
    /// Request under way, or how the last one ended; 0 if there was none.
    pub progress: u8,
    /// Why it was refused, and the value; 0 if it was not.
    pub reason: u8,
    /// Value that was refused, in the unit of the reason.
    pub refused: i32,
    /// Axes whose signs are checked: 1 about x, 2 about y, 4 about z.
    pub axes: u8,
    /// Values of the settings.
    pub values: Values,
}
