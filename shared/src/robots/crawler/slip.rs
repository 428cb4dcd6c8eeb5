//! Estimates the slip of the tracks from the slope and the configured soil, and corrects the
//! estimate slowly by measured speeds.

use super::parameters::{Dimensions, Ground, Masses, ParametersError, within};
use super::soil::{Footprint, Soil};
use crate::constants::GRAVITY;
use crate::math::{Scalar, clamp, limit, max, min};

/// Minimum cosine of the pitch: a robot that stands on its end has no pressure along its run.
const LEAST_COSINE: f32 = 0.1;
/// Maximum of the estimate. A track that slips more is stuck, and turning it faster digs.
const MAXIMUM_SLIP: f32 = 0.6;
/// Range of the correction: a third to three times the slip of the soil model.
const CORRECTION: [f32; 2] = [1.0 / 3.0, 3.0];
/// Time constant of the correction, s. The speed of a GNSS receiver deviates by some tenths of the
/// robot's speed from fix to fix.
const CORRECTION_TIME: f32 = 8.0;
/// Predicted slip below which a measurement says little about the soil.
const WEAK_SLIP: f32 = 0.03;
/// Mean speed of the belts below which the slip is not measured, m/s.
const SLOWEST: f32 = 0.03;

/// Model of the slip at which the ground carries the robot's weight along the slope.
///
/// Each track carries half of the weight's component along the ground, forward and sideways. The
/// roll decides how the pressure is shared between the tracks. Along a run the pressure grows
/// linearly to the lower end, as the moment of the weight requires. The ground shears the same way
/// in every direction, so the slip points against the force. The model does not contain the slip of
/// turning and speeding up; the path follower compensates its effect on the heading.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SlipModel {
    soil: Soil<f32>,
    footprint: Footprint<f32>,
    weight: f32,
    /// Centre of gravity from the middle between the runs: forward, left, up, m.
    cog: [f32; 3],
    spacing: f32,
    /// Estimated slip over the slip of the model.
    correction: f32,
}

/// Slip in the direction of the force, as a fraction of the belts' travel.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Slip {
    /// Fraction that the left and the right track lose forward: positive when the ground pushes the
    /// robot forward.
    pub forward: [f32; 2],
    /// Fraction by which the robot drifts to the right while the ground pushes it to the left.
    pub rightward: f32,
    /// Whether the slope requires more than the ground carries at some track. The slip of that
    /// track is then the one at which the ground carries most.
    pub beyond_traction: bool,
}

impl Slip {
    /// No slip.
    pub const NONE: Self = Self {
        forward: [0.0; 2],
        rightward: 0.0,
        beyond_traction: false,
    };

    /// Angle from the robot's heading to its direction of travel, rad, counter-clockwise, while its
    /// belts run forward (`speed` above zero) or backward.
    pub fn drift(&self, speed: f32) -> f32 {
        let [left, right] = self.along([speed; 2]);
        let angle = Scalar::atan2(self.rightward, 1.0 - 0.5 * (left + right));
        if speed < 0.0 { angle } else { -angle }
    }

    /// Signed slips for the kinematics, of belts (or tracks) that move at `speeds`: what is lost
    /// forward is gained backward.
    pub fn along(&self, speeds: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|side: usize| {
            if speeds[side] < 0.0 {
                -self.forward[side]
            } else {
                self.forward[side]
            }
        })
    }
}

impl SlipModel {
    /// Creates the model of a robot with these dimensions and masses on this ground.
    ///
    /// # Errors
    /// The first value out of range: mass 10 g to 1 t, centre of gravity within 10 m, lengths 1 mm
    /// to 10 m, and those of [`Soil::new`].
    pub fn new(
        dimensions: &Dimensions,
        body: &Masses,
        ground: &Ground,
    ) -> Result<Self, ParametersError> {
        const LENGTH: [f64; 2] = [1e-3, 10.0];
        let (mass, cog) = body.checked()?;
        Ok(Self {
            soil: Soil::new(ground)?,
            footprint: Footprint {
                width: within("track width", dimensions.track_width, LENGTH)? as f32,
                length: within("contact length", dimensions.contact_length, LENGTH)? as f32,
            },
            weight: mass * GRAVITY,
            cog,
            spacing: within("track spacing", dimensions.track_spacing, LENGTH)? as f32,
            correction: 1.0,
        })
    }

    /// Slip at this pitch (nose up) and roll (left side up), rad, of belts that run forward or
    /// `backward`. The ground meets the track at the end towards which it drives. Cost: twice
    /// [`Soil::slip_for`].
    pub fn predict(&self, pitch: f32, roll: f32, backward: bool) -> Slip {
        let ((rise, along), (tilt, upright)) = (Scalar::sin_cos(pitch), Scalar::sin_cos(roll));
        let half = 0.5 * self.weight;
        let (forward, leftward) = (half * upright * rise, half * tilt);
        let force = Scalar::sqrt(forward * forward + leftward * leftward);
        let area = self.footprint.width * self.footprint.length;
        let utmost = self.soil.utmost_slip(&self.footprint);
        let [cog_forward, cog_left, height] = self.cog;
        // Position of the pressure's resultant: the ground's force passes through the centre of
        // gravity.
        let resultant = cog_forward - height * rise / max(along, LEAST_COSINE);
        let behind = if backward { resultant } else { -resultant };
        let shift = limit(6.0 * behind / self.footprint.length, 1.0);
        let mut beyond_traction = false;
        let [left, right] = [-1.0, 1.0].map(|right: f32| {
            // The upper side carries less.
            let aside = height * tilt - cog_left * upright * along;
            let share = 0.5 * upright * along + right * aside / self.spacing;
            let pressure = self.weight * clamp(share, 0.0, 1.0) / area;
            let slip = self
                .soil
                .slip_bearing(&self.footprint, pressure, shift, force);
            beyond_traction |= slip.is_err();
            min(slip.unwrap_or(utmost) * self.correction, MAXIMUM_SLIP)
        });
        // On level ground the force has no direction and needs no slip.
        let per_force = if force > 0.0 { 1.0 / force } else { 0.0 };
        Slip {
            forward: [left, right].map(|slip| slip * forward * per_force),
            rightward: 0.5 * (left + right) * leftward * per_force,
            beyond_traction,
        }
    }

    /// Corrects the model by a forward speed that was measured over ground while the belts ran at
    /// `belts` (all m/s) with the slip `slip`.
    ///
    /// The correction is slow (8 s) and bounded: a wrong measurement changes the slip by a factor
    /// of three at most. Nothing is learnt where almost no slip is expected, nor from belts that
    /// stand or turn the robot on the spot.
    pub fn learn(&mut self, slip: &Slip, belts: [f32; 2], measured_speed: f32, period: f32) {
        let speed = 0.5 * (belts[0] + belts[1]);
        if !(speed.abs() > SLOWEST && measured_speed.is_finite()) {
            return;
        }
        let [left, right] = slip.along([speed; 2]);
        let expected = 0.5 * (left + right);
        let uncorrected = expected / self.correction;
        let error = clamp(1.0 - measured_speed / speed - expected, -1.0, 1.0);
        let gain = uncorrected / (uncorrected * uncorrected + WEAK_SLIP * WEAK_SLIP);
        let corrected = self.correction + error * gain * (period / CORRECTION_TIME);
        self.correction = clamp(corrected, CORRECTION[0], CORRECTION[1]);
    }

    /// Estimated slip over the slip of the soil model alone.
    pub fn correction(&self) -> f32 {
        self.correction
    }
}
