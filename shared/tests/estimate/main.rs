//! Tests of the estimate of q against independent computations: NMEA sentences, compass, plane and
//! dead reckoning.

mod attitude;
mod compass;
mod ellipse;
mod ellipsoid;
mod nmea;
mod position;
#[path = "../support/random.rs"]
#[allow(dead_code)] // the models need the joints
mod random;
mod state;

use tautrack::estimate::attitude::Attitude;
use tautrack::sensors::BodySensors;

/// Adds the checksum and the end of the line.
fn framed(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// An attitude that was measured once.
fn tilted(roll: f64, pitch: f64) -> Attitude {
    let mut attitude = Attitude::default();
    let sensors = BodySensors {
        inclination: [pitch as f32, roll as f32],
        ..BodySensors::default()
    };
    assert!(attitude.update(&sensors, 1e-3));
    attitude
}
