//! Estimates where the robot is, how it stands and which shape it has: the coordinates q1 to q8 of
//! Paillat et al., as the sensors measure them.
//!
//! * [`attitude`] computes pitch, roll and heading.
//! * [`specific_force`] averages the measured force.
//! * [`nmea`] reads the GNSS receiver.
//! * [`compass`] computes the heading from the magnetometer.
//! * [`position`] combines position fixes with the distance that the belts travel.
//! * [`state`] collects all eight coordinates, each with its validity and age.
//!
//! The axes of q are those of Paillat et al. (modified Denavit-Hartenberg, frame R0), laid on the
//! ground so that the heading is 0 towards true north: x0 east, y0 north, z0 up.
//!
//! * q1, q2, q3: distance north, east and up, m, from the place of the first believed fix to axle 1
//! * q4: heading, counter-clockwise from true north, rad
//! * q5: roll about the heading, left side up, rad
//! * q6: pitch, nose up, rad
//! * q7: chassis angle, front up, rad
//! * q8: extension `L3` without its part inside of segment 3, m

pub mod attitude;
pub mod compass;
pub mod ellipse;
pub mod nmea;
pub mod position;
pub mod specific_force;
pub mod state;
