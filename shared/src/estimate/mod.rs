//! Where the robot is, how it stands and how it is shaped: the paper's q1 to q8 as its sensors measure them.
//!
//! [`nmea`] reads the GNSS receiver, [`compass`] the magnetometer, [`position`] blends fixes with the way of the belts,
//! [`state`] puts all eight together, each with validity and age. Attitude is [`crate::stability::attitude`].
//!
//! Axes of q are those of Paillat et al. (modified Denavit-Hartenberg, frame R0), laid on the ground so that the heading is 0
//! towards true north: x0 east, y0 north, z0 up. So q1 is the way north, q2 east, q3 up (m, of axle 1, from where the first
//! believed fix was); q4 the heading, counter-clockwise from true north; q5 the roll about the heading, left side up; q6 the
//! pitch, nose up; q7 the chassis angle, front up (rad); q8 the extension `L3` minus its part inside of segment 3 (m).

pub mod compass;
pub mod nmea;
pub mod position;
pub mod state;
