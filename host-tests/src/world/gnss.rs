//! GNSS receiver on the robot: sends GGA and RMC sentences on a serial line, with slowly varying
//! errors.
//!
//! World axes here and in the plant: x north, y west, z up. The parameters define the origin.

use crate::world::noise::Noise;
use std::collections::VecDeque;

/// WGS 84 ellipsoid: radius of the equator, m, and the square of the eccentricity.
const EQUATOR: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;
/// Noise channels of a plant that belong to the receiver.
const WHITE: u64 = 16;
const WANDER: u64 = 20;
const SPEED: u64 = 24;

/// Properties of the receiver.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ReceiverParameters {
    /// Latitude and longitude of the world's origin, degrees, and its height above mean sea level,
    /// m.
    pub site: [f64; 3],
    /// Height of mean sea level above the ellipsoid at the site, m.
    pub geoid: f64,
    /// Place of the antenna relative to the body's origin: forward, left, up, m.
    pub antenna: [f64; 3],
    /// Time between two fixes, ms.
    pub period_ms: u64,
    /// Baud rate of the line; a byte takes ten bits.
    pub baud: u32,
    /// Independent noise of each fix: standard deviation along each horizontal axis, m; twice that
    /// in height.
    pub white: f64,
    /// Independent noise of the speed in each fix: standard deviation along each horizontal axis,
    /// m/s.
    pub speed: f64,
    /// Slowly varying error: standard deviation along each horizontal axis, m; twice that in
    /// height.
    pub wander: f64,
    /// Correlation time of this error, s.
    pub wander_time: f64,
    /// Start and end of the time in which the receiver sees too few satellites, s.
    pub outage_s: [f64; 2],
}

impl ReceiverParameters {
    /// A simple receiver under open sky, with its first fix after two seconds.
    pub const NOMINAL: Self = Self {
        site: [47.478_4, -0.563_2, 40.0],
        geoid: 48.0,
        antenna: [0.16, 0.0, 0.10],
        period_ms: 200,
        baud: 38_400,
        white: 0.3,
        speed: 0.0,
        wander: 1.2,
        wander_time: 60.0,
        outage_s: [0.0, 2.0],
    };
}

/// Simulated receiver and its serial line.
pub struct Receiver {
    parameters: ReceiverParameters,
    noise: Noise,
    wander: [f64; 3],
    waiting: VecDeque<u8>,
    sent: Vec<u8>,
    /// Fraction of a byte for which the line has had time.
    credit: f64,
}

impl Receiver {
    /// Creates a receiver that was just switched on.
    pub fn new(parameters: ReceiverParameters, noise: Noise) -> Self {
        Self {
            wander: [0, 1, 2].map(|axis| parameters.wander * noise.normal(0, WANDER + axis)),
            parameters,
            noise,
            waiting: VecDeque::new(),
            sent: Vec::new(),
            credit: 0.0,
        }
    }

    /// Current slowly varying error along x, y and z, m.
    pub fn wander(&self) -> [f64; 3] {
        let [x, y, z] = self.wander;
        [x, y, 2.0 * z]
    }

    /// Bytes sent in the last step.
    pub fn sent(&self) -> &[u8] {
        &self.sent
    }

    /// Runs step number `step`, of one millisecond, with the antenna at `place` (m), moving at
    /// `velocity` (m/s).
    pub fn update(&mut self, place: [f64; 3], velocity: [f64; 3], step: u64) {
        let p = self.parameters;
        if step.is_multiple_of(p.period_ms) {
            let share = p.period_ms as f64 * 1e-3 / p.wander_time;
            for (axis, wander) in (0..).zip(&mut self.wander) {
                // Keeps the variance constant.
                *wander += -share * *wander
                    + libm::sqrt(2.0 * share - share * share)
                        * p.wander
                        * self.noise.normal(step, WANDER + axis);
            }
            let lasting = self.wander();
            let received = [0, 1, 2].map(|axis| {
                let white = self.noise.normal(step, WHITE + axis as u64) * p.white;
                place[axis] + lasting[axis] + if axis == 2 { 2.0 * white } else { white }
            });
            let mut velocity = velocity;
            for (axis, speed) in (0..2).zip(&mut velocity) {
                *speed += p.speed * self.noise.normal(step, SPEED + axis);
            }
            let seconds = step as f64 * 1e-3;
            let blind = seconds >= p.outage_s[0] && seconds < p.outage_s[1];
            let text = sentences(&p, (!blind).then_some((received, velocity)), step);
            self.waiting.extend(text.bytes());
        }
        self.credit += f64::from(p.baud) * 1e-4;
        let count = self.waiting.len().min(self.credit as usize);
        self.credit = if self.waiting.is_empty() {
            0.0
        } else {
            self.credit - count as f64
        };
        self.sent.clear();
        self.sent.extend(self.waiting.drain(..count));
    }
}

/// Formats the GGA and RMC sentences of one step. The time of day at power-up is noon.
fn sentences(p: &ReceiverParameters, fix: Option<([f64; 3], [f64; 3])>, step: u64) -> String {
    let seconds = 12 * 3_600 + step / 1_000;
    let time = format!(
        "{:02}{:02}{:02}.{:02}",
        seconds / 3_600 % 24,
        seconds / 60 % 60,
        seconds % 60,
        step % 1_000 / 10
    );
    let Some((place, [north, west, _])) = fix else {
        let gga = framed(&format!("GPGGA,{time},,,,,0,00,99.99,,,,,,"));
        return gga + &framed(&format!("GPRMC,{time},V,,,,,,,010626,,,N"));
    };
    let [latitude, longitude, height] = geodetic(p, place);
    let place = format!(
        "{},{},{},{}",
        minutes(latitude, 2),
        if latitude < 0.0 { 'S' } else { 'N' },
        minutes(longitude, 3),
        if longitude < 0.0 { 'W' } else { 'E' }
    );
    let altitude = height - p.geoid;
    let gga = framed(&format!(
        "GPGGA,{time},{place},1,08,1.10,{altitude:.2},M,{:.1},M,,",
        p.geoid
    ));
    let knots = libm::sqrt(north * north + west * west) * 3_600.0 / 1_852.0;
    let course = libm::atan2(-west, north).to_degrees().rem_euclid(360.0);
    gga + &framed(&format!(
        "GPRMC,{time},A,{place},{knots:.3},{course:.2},010626,,,A"
    ))
}

/// Formats an angle as degrees, minutes and 1e-5 minutes (19 mm of latitude).
fn minutes(degrees: f64, wide: usize) -> String {
    let units = (degrees.abs() * 60.0 * 1e5).round() as u64;
    let (whole, rest) = (units / 6_000_000, units % 6_000_000);
    format!("{whole:0wide$}{:02}.{:05}", rest / 100_000, rest % 100_000)
}

/// Adds the checksum and the end of the line.
fn framed(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// Latitude and longitude, degrees, and height above the ellipsoid, m, of a place in the world.
///
/// It converts to earth-centred axes, and back by Bowring's iteration.
pub fn geodetic(p: &ReceiverParameters, [north, west, up]: [f64; 3]) -> [f64; 3] {
    let [latitude, longitude, altitude] = p.site;
    let (latitude, longitude) = (latitude.to_radians(), longitude.to_radians());
    let (sin_p, cos_p) = (libm::sin(latitude), libm::cos(latitude));
    let (sin_l, cos_l) = (libm::sin(longitude), libm::cos(longitude));
    let radius = |sine: f64| EQUATOR / libm::sqrt(1.0 - ECCENTRICITY_SQUARED * sine * sine);
    let height = altitude + p.geoid;
    let out = (radius(sin_p) + height) * cos_p;
    let east = -west;
    let outward = up * cos_p - north * sin_p;
    let x = (out + outward) * cos_l - east * sin_l;
    let y = (out + outward) * sin_l + east * cos_l;
    let z = (radius(sin_p) * (1.0 - ECCENTRICITY_SQUARED) + height) * sin_p
        + north * cos_p
        + up * sin_p;
    let across = libm::sqrt(x * x + y * y);
    let (mut found, mut height) = (latitude, height);
    for _ in 0..5 {
        let n = radius(libm::sin(found));
        height = across / libm::cos(found) - n;
        found = libm::atan2(z, across * (1.0 - ECCENTRICITY_SQUARED * n / (n + height)));
    }
    [found.to_degrees(), libm::atan2(y, x).to_degrees(), height]
}
