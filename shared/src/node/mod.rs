//! Computes what each node does in one tick: outputs from inputs. There is no I/O, no waiting, and
//! no clock other than the time in the inputs.

pub mod axle;
pub mod calibration;
pub mod cogging;
pub mod guard;
pub mod screw;
