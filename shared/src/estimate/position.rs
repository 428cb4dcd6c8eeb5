//! Estimates the position in a plane that touches the earth where the robot began, from fixes of a
//! GNSS receiver and from the distance that the belts travel between two fixes.
//!
//! A fix is "believed" when it is used for the estimate, and "doubted" when it is kept back because
//! it is too far from the estimate.

use super::nmea::{Place, Sentence};
use crate::estimate::attitude::LevelAxes;
use crate::math::{sin_cos, sqrt, to_i32};
use crate::units::Angle;

/// Largest horizontal dilution of precision with which a fix is used, in units of 0.01.
pub const DILUTION_LIMIT: u16 = 500;
/// Allowed distance between a fix and the estimate, m, in addition to the distance that the robot
/// can have travelled since the last believed fix. A fix that is farther away is not believed at
/// once.
pub const GATE: f32 = 10.0;
/// Number of fixes in a row that must agree with each other before the first position is believed.
pub const FIRST_FIXES: u32 = 3;
/// Number of fixes in a row that must agree with each other before a jump is believed: 2 s at five
/// fixes a second.
pub const JUMP_FIXES: u32 = 10;
/// Largest divisor of a correction. The n-th believed fix pulls the estimate by 1/n of its
/// distance, but at least by 1/`LEAST_GAIN`. At five fixes a second, noise of the receiver is
/// averaged over 20 s, and a wrong distance of the belts is forgotten in the same time.
pub const LEAST_GAIN: u32 = 100;

/// A fix that the receiver reports as good.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Fix {
    /// UTC time of day, ms. Sentences with the same time are one fix.
    pub time_ms: u32,
    /// Place of the receiver.
    pub place: Place,
    /// Height above mean sea level, mm.
    pub altitude_mm: Option<i32>,
}

impl Fix {
    /// Returns the fix in `sentence`; `None` if the receiver has none, extrapolates or simulates
    /// it, or reports a poor precision.
    pub fn from_sentence(sentence: &Sentence) -> Option<Self> {
        let (time_ms, place, altitude_mm) = match sentence {
            Sentence::Gga(gga)
                if matches!(gga.quality, 1..=5)
                    && gga.dilution.is_some_and(|limit| limit <= DILUTION_LIMIT) =>
            {
                (gga.time_ms, gga.place, gga.altitude_mm)
            }
            Sentence::Gga(_) => return None,
            Sentence::Rmc(rmc) => (rmc.time_ms, rmc.place, None),
        };
        Some(Self {
            time_ms: time_ms?,
            place: place?,
            altitude_mm,
        })
    }
}

/// Plane that touches the ellipsoid at `origin`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plane {
    origin: Place,
    /// Metres per 1e-7 degree, to the north and to the east.
    north: f32,
    east: f32,
}

impl Plane {
    /// Creates the plane at `origin`, from the radii of curvature of the WGS 84 ellipsoid there.
    pub fn new(origin: Place) -> Self {
        const EQUATOR: f32 = 6_378_137.0;
        const ECCENTRICITY_SQUARED: f32 = 0.006_694_38;
        const RADIANS: f32 = (core::f64::consts::PI / 1.8e9) as f32;
        let latitude = Angle::from_radians(origin.latitude as f32 * RADIANS);
        let (sine, cosine) = sin_cos(latitude);
        let root = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
        let across = EQUATOR / sqrt(root);
        let along = across * (1.0 - ECCENTRICITY_SQUARED) / root;
        Self {
            origin,
            north: along * RADIANS,
            east: across * cosine * RADIANS,
        }
    }

    /// Converts a place to metres north and east of the origin.
    ///
    /// Worst error between the 65th parallels: 0.38 m within 1 km, at the corner, because the
    /// meridians converge; 15 mm within 100 m (`shared/tests/estimate/position.rs`, against
    /// the ellipsoid in double precision).
    pub fn metres(&self, place: Place) -> [f32; 2] {
        let north = place.latitude.wrapping_sub(self.origin.latitude);
        // Across the date line the difference is wrong by 3.6e9 units.
        let east = i64::from(place.longitude) - i64::from(self.origin.longitude);
        let east = match east {
            1_800_000_000.. => east - 3_600_000_000,
            ..=-1_800_000_000 => east + 3_600_000_000,
            _ => east,
        };
        [north as f32 * self.north, east as f32 * self.east]
    }
}

/// What happened to a fix.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// It was blended with the estimate.
    Believed,
    /// It is kept back until more fixes agree with it.
    Doubted,
    /// A fix with the same time was taken already.
    Known,
}

/// The newest believed fix of one direction, horizontal or vertical, and the number of believed
/// fixes.
#[derive(Clone, Copy, Debug)]
struct Trust {
    fixes: u32,
    received_us: u64,
    stamp_ms: u32,
}

/// The place where the robot would be if the newest doubted fixes were right, and how many of them
/// agree.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    metres: [f32; 3],
    fixes: u32,
    received_us: u64,
    stamp_ms: u32,
}

/// Estimate of the robot's position.
#[derive(Clone, Debug)]
pub struct Position {
    speed_limit: f32,
    plane: Option<Plane>,
    datum_mm: Option<i32>,
    /// Distance north, east and up, nm. Steps of half a millimetre add up exactly, however far the
    /// origin is.
    nanometres: [i64; 3],
    horizontal: Option<Trust>,
    vertical: Option<Trust>,
    suspect: Option<Suspect>,
    believed: u32,
    doubted: u32,
}

impl Position {
    /// Creates the estimate for a robot that drives no faster than `speed_limit`, m/s.
    pub fn new(speed_limit: f32) -> Self {
        Self {
            speed_limit,
            plane: None,
            datum_mm: None,
            nanometres: [0; 3],
            horizontal: None,
            vertical: None,
            suspect: None,
            believed: 0,
            doubted: 0,
        }
    }

    /// Dead reckoning: moves the estimate by the distance `way_um` of the belts along the body's
    /// forward axis. Slip of the belts is not seen.
    pub fn advance(&mut self, way_um: i32, heading: Angle, axes: &LevelAxes) {
        let [forward, left, up] = axes.of([way_um as f32 * 1e3, 0.0, 0.0]);
        let (sine, cosine) = sin_cos(heading);
        let steps = [
            forward * cosine - left * sine,
            -(forward * sine + left * cosine),
            up,
        ];
        for (place, step) in self.nanometres.iter_mut().zip(steps) {
            *place = place.wrapping_add(i64::from(to_i32(step)));
        }
    }

    /// Takes a fix that was received at `now_us`.
    pub fn fix(&mut self, fix: &Fix, now_us: u64) -> Verdict {
        let new = |trust: Option<Trust>| trust.is_none_or(|last| last.stamp_ms != fix.time_ms);
        let level = new(self.horizontal);
        let altitude = fix.altitude_mm.filter(|_| new(self.vertical));
        let doubted_already = (self.suspect).is_some_and(|suspect| suspect.stamp_ms == fix.time_ms);
        if doubted_already || !(level || altitude.is_some()) {
            return Verdict::Known;
        }
        let plane = *self.plane.get_or_insert_with(|| Plane::new(fix.place));
        let [north, east] = plane.metres(fix.place);
        let here = self.metres();
        let up = altitude.map_or(here[2], |altitude| {
            let datum = *self.datum_mm.get_or_insert(altitude);
            altitude.wrapping_sub(datum) as f32 * 1e-3
        });
        let there = [north, east, up];

        let last_us = self.horizontal.map(|trust| trust.received_us);
        if last_us.is_none_or(|last_us| !self.near(here, there, now_us.saturating_sub(last_us))) {
            return self.doubt(fix, there, now_us);
        }
        self.suspect = None;
        self.believed = self.believed.wrapping_add(1);
        if level {
            self.blend(false, there, fix, now_us);
        }
        if altitude.is_some() {
            self.blend(true, there, fix, now_us);
        }
        Verdict::Believed
    }

    /// Keeps a fix back. If enough fixes in a row agree with each other, moves the estimate to
    /// them.
    fn doubt(&mut self, fix: &Fix, there: [f32; 3], now_us: u64) -> Verdict {
        let agreeing = self
            .suspect
            .filter(|last| self.near(last.metres, there, now_us.saturating_sub(last.received_us)));
        let fixes = agreeing.map_or(0, |last| last.fixes) + 1;
        let wanted = if self.horizontal.is_some() {
            JUMP_FIXES
        } else {
            FIRST_FIXES
        };
        if fixes < wanted {
            self.doubted = self.doubted.wrapping_add(1);
            self.suspect = Some(Suspect {
                metres: there,
                fixes,
                received_us: now_us,
                stamp_ms: fix.time_ms,
            });
            if agreeing.is_none() && self.horizontal.is_none() {
                // Nothing depends on the plane yet, so it begins at this fix.
                self.plane = Some(Plane::new(fix.place));
                self.datum_mm = fix.altitude_mm;
                if let Some(suspect) = &mut self.suspect {
                    suspect.metres = [0.0; 3];
                }
            }
            return Verdict::Doubted;
        }
        self.suspect = None;
        self.believed = self.believed.wrapping_add(1);
        (self.horizontal, self.vertical) = (None, None);
        self.blend(false, there, fix, now_us);
        if fix.altitude_mm.is_some() {
            self.blend(true, there, fix, now_us);
        }
        Verdict::Believed
    }

    /// Returns whether a robot can be at both places within `elapsed_us`. Heights count half,
    /// because receivers measure them less precisely.
    fn near(&self, a: [f32; 3], b: [f32; 3], elapsed_us: u64) -> bool {
        let reach = GATE + self.speed_limit * (elapsed_us as f32 * 1e-6);
        let [north, east, up] = [0, 1, 2].map(|axis| a[axis] - b[axis]);
        north * north + east * east + 0.25 * up * up <= reach * reach
    }

    /// Pulls north and east, or the height, towards a believed fix.
    fn blend(&mut self, vertical: bool, there: [f32; 3], fix: &Fix, now_us: u64) {
        let trust = if vertical {
            &mut self.vertical
        } else {
            &mut self.horizontal
        };
        let fixes = trust.map_or(1, |trust| (trust.fixes + 1).min(LEAST_GAIN));
        *trust = Some(Trust {
            fixes,
            received_us: now_us,
            stamp_ms: fix.time_ms,
        });
        for (axis, (place, there)) in self.nanometres.iter_mut().zip(there).enumerate() {
            if vertical == (axis == 2) {
                let distance = there - *place as f32 * 1e-9;
                *place = place.wrapping_add((distance / fixes as f32 * 1e9) as i64);
            }
        }
    }

    /// Returns the position: metres north, east and up from the place of the first believed fix.
    /// The resolution is 0.1 mm within 1 km.
    pub fn metres(&self) -> [f32; 3] {
        self.nanometres.map(|place| place as f32 * 1e-9)
    }

    /// Returns when north and east, and when up, last had a believed fix, us; `None` before the
    /// first.
    pub fn fixed_us(&self) -> [Option<u64>; 2] {
        [self.horizontal, self.vertical].map(|trust| trust.map(|trust| trust.received_us))
    }

    /// Returns the place where the plane touches the earth, and its height above mean sea level,
    /// mm. `None` before a position is believed.
    pub fn origin(&self) -> Option<(Place, Option<i32>)> {
        let plane = self.plane.filter(|_| self.horizontal.is_some())?;
        Some((plane.origin, self.datum_mm))
    }

    /// Returns the numbers of fixes that were believed and that were kept back since power-up; they
    /// wrap.
    pub fn counts(&self) -> [u32; 2] {
        [self.believed, self.doubted]
    }
}
