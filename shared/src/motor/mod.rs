//! Estimation and control of one motor.
//!
//! * [`observer`]: position and velocity from encoder counts
//! * [`profile`]: motion of a set-point within its limits
//! * [`cascade`]: current from a set-point
//! * [`cogging`]: finds the current that cancels the cogging torque
//! * [`current`]: compare values of the half bridges from a current, in the PWM interrupt
//! * [`calibration`]: measures the motor and its sensors on request
//! * [`alignment`]: finds the angle of a rotor whose sensor only counts
//! * [`limits`]: what a motor, a bridge and a supply can carry; the current limiter
//! * [`back_emf`]: compares the voltage of the bridge with the speed of the encoder
//! * [`angle_watch`]: watches the rotor's angle at low speed
//! * [`angle_probe`]: finds a wrong rotor angle with a current that makes no torque
//! * [`ripple`]: finds a back-EMF that turns relative to the rotor's axes
//! * [`encoder_steps`]: finds a noisy encoder
//! * [`halls`]: counts the rotor from Hall sensors
//! * [`index`]: finds lost counts, and corrects the rotor's angle
//! * [`bridge`]: readings and commands of the power stage
//! * [`capture`]: records signals of the PWM interrupt
//! * `model`: simulated motors, for boards without hardware (feature `lockstep`)
//! * [`rotor`]: electrical angle of a three-phase motor
//! * [`shaft_sensor`]: absolute angle sensor at the output shaft
//!
//! Positions are [`crate::math::Turns`] of the output shaft, so that they lose neither precision
//! nor range over time. Only differences of positions become `f32`.

pub mod alignment;
pub mod angle_probe;
pub mod angle_watch;
pub mod back_emf;
pub mod board_limits;
pub mod bridge;
pub mod calibration;
pub mod capture;
pub mod cascade;
pub mod cogging;
pub mod current;
pub mod encoder_steps;
pub mod halls;
pub mod index;
pub mod limits;
#[cfg(feature = "lockstep")]
pub mod model;
pub mod observer;
pub mod profile;
pub mod ripple;
pub mod rotor;
pub mod shaft_sensor;
