//! The node of the driving screw: an axle that computes its own set-point. So `L + (L2 + L3) = K`
//! holds for the present chassis angle, not for the angle at the time when the joint's node sent
//! it.

use super::axle::{Axle, Inputs as AxleInputs, Outputs};
use crate::bus::cia402::mode;
use crate::bus::pdo::DriveMotion;
use crate::bus::scale::Scale;
use crate::constants::CONTROL_PERIOD;
use crate::faults::Fault;
use crate::math::{Turns, to_i32};
use crate::motor::profile::Motion;
use crate::screw::{Geometry, GeometryError, metres};
use crate::settings::{Setting, Settings};
use crate::units::Angle;
use core::borrow::Borrow;

/// Readings and messages since the previous tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// The axle's own inputs.
    pub axle: AxleInputs,
    /// Motion of the chassis joint (2^-32 turn, 1e-6 rad/s) and the time of its measurement, us, if
    /// a frame came.
    pub joint: Option<(DriveMotion, u64)>,
    /// Commanded slack of the belt, 2^-24 m. 0 is taut; a negative value counts as 0. The slack is
    /// approached with the engage speed.
    pub slack: i32,
}

/// State of the screw.
#[derive(Clone, Debug)]
pub struct Screw<G = Geometry> {
    axle: Axle,
    geometry: G,
    scale: Scale,
    joint: Option<(DriveMotion, u64)>,
    joint_timeout_us: u64,
    /// Travel in one tick at the engage speed, 2^-32 turn; not negative.
    engage_step: Turns,
    /// Travel in one tick at the engage speed, as slack in 2^-24 m, at least 1; and the present
    /// slack.
    slack_step: i32,
    slack: i32,
    /// `L2`, m.
    l2: f32,
    /// Terms of the slack: `2 K`, m, and `K^2 - L1^2`, m^2.
    slack_terms: (f32, f32),
    /// Half of `K - L1`, 2^-24 m. It is more slack than any extension can give.
    most_slack: i32,
    /// Distance that is left to take up since the mode began, 2^-32 turn. It goes to zero at the
    /// engage speed.
    remaining: Turns,
    /// Position of the taut belt in the previous tick, and the largest step from there, 2^-32 turn.
    taut: Turns,
    longest_step: Turns,
}

/// Largest step of the taut belt's length in a tick beyond what the velocity limit allows, m.
/// Measured motions of the joint differ by less from those that the screw has extrapolated.
const UNEXPECTED_STEP: f32 = 0.5e-3;

/// Overshoot of a screw that stops from 1 m/s, 2^-28 m. This is 10 ms: three time constants of the
/// velocity loop of a screw with the nominal settings.
const OVERSHOOT: f32 = 0.01 * 268_435_456.0;

impl Screw {
    /// Creates a screw with these settings.
    ///
    /// # Errors
    /// [`GeometryError`] if the geometry is not accepted with L1, L2 and K.
    pub fn new(settings: &Settings) -> Result<Self, GeometryError> {
        Ok(Self::with_geometry(settings, geometry(settings)?))
    }
}

/// Creates the geometry in these settings.
///
/// # Errors
/// [`GeometryError`] if it is not accepted.
pub fn geometry(settings: &Settings) -> Result<Geometry, GeometryError> {
    let [l1, l2, k] = lengths(settings);
    Geometry::from_micrometres(l1, l2, k)
}

/// Creates the geometry in these settings in `place` ([`Geometry::create_in`]).
///
/// # Errors
/// [`GeometryError`] if it is not accepted.
pub fn geometry_in<'a>(
    place: &'a mut Option<Geometry>,
    settings: &Settings,
) -> Result<&'a Geometry, GeometryError> {
    Geometry::create_in(place, lengths(settings))
}

/// Returns `L1`, `L2` and `K`, um.
fn lengths(settings: &Settings) -> [i32; 3] {
    [Setting::LengthL1, Setting::LengthL2, Setting::LengthK].map(|length| settings.get(length))
}

impl<G: Borrow<Geometry>> Screw<G> {
    /// Creates a screw with these settings and their [`geometry`], or a reference to it. A board
    /// with little RAM has the geometry, whose table takes 2 KiB, in a static variable.
    pub fn with_geometry(settings: &Settings, geometry: G) -> Self {
        let length = |setting| settings.get(setting);
        let table = geometry.borrow();
        let (l1, k) = (
            settings.si(Setting::LengthL1),
            settings.si(Setting::LengthK),
        );
        let scale = Scale::linear(length(Setting::ScrewLead));
        let released = i64::from(table.released_length().to_bits());
        let retreat = (i64::from(length(Setting::HomingRetreat)) << 28) / 1_000_000;
        let reference = scale.shaft_from_length(released - retreat);
        // The extension is longest at half a turn of theta. There is nothing to reach beyond it or
        // below the switch.
        let longest = i64::from(table.length(Angle::from_bits(i32::MIN)).to_bits());
        let travel = (reference, scale.shaft_from_length(longest));
        let engage_metres = settings.si(Setting::EngageSpeed);
        let unexpected = scale.shaft_velocity_from_linear(UNEXPECTED_STEP);
        let longest_step = settings.si(Setting::VelocityLimit) * CONTROL_PERIOD + unexpected;
        let engage_speed = scale.shaft_velocity_from_linear(engage_metres);
        let slack_step = to_i32(engage_metres * (CONTROL_PERIOD * 16_777_216.0));
        Self {
            axle: Axle::with_scale::<false>(settings, scale, reference, Some(travel)),
            geometry,
            scale,
            joint: None,
            joint_timeout_us: settings.milliseconds(Setting::JointTimeout),
            engage_step: Turns::from_radians(engage_speed * CONTROL_PERIOD),
            slack_step,
            slack: 0,
            l2: settings.si(Setting::LengthL2),
            slack_terms: (k + k, (k - l1) * (k + l1)),
            most_slack: to_i32(0.5 * (k - l1) * 16_777_216.0),
            remaining: Turns::ZERO,
            taut: Turns::ZERO,
            longest_step: Turns::from_radians(longest_step),
        }
    }

    /// Returns the axle that turns the screw.
    pub fn axle(&self) -> &Axle {
        &self.axle
    }

    /// Returns the axle, for the parameters of clients and the results of a calibration.
    /// [`Screw::tick`] runs its ticks.
    pub fn axle_mut(&mut self) -> &mut Axle {
        &mut self.axle
    }

    /// Runs one control period.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        if inputs.joint.is_some() {
            self.joint = inputs.joint;
        }
        let taut = self.taut(inputs);
        self.axle.tick_following(&inputs.axle, taut)
    }

    /// Computes the set-point that gives the belt its present slack, for the joint's motion
    /// extrapolated to now.
    fn taut(&mut self, inputs: &Inputs) -> Result<Motion, Fault> {
        let (motion, measured_us) = self.joint.ok_or(Fault::JointLost)?;
        let age_us = inputs.axle.now_us.saturating_sub(measured_us);
        if age_us > self.joint_timeout_us {
            return Err(Fault::JointLost);
        }
        let rate = motion.velocity as f32 * 1e-6;
        // The age is below the timeout, which is at most one second. The extrapolation ends at half
        // a turn, beyond which it has no meaning.
        let moved = rate * (age_us as u32 as f32 * (1e-6 * Turns::PER_RADIAN));
        let theta = Angle::from_bits(motion.position) + Angle::from_bits(to_i32(moved));
        let extension = self.geometry.borrow().extension(theta);

        let speed = metres(extension.derivative) * rate;
        self.update_slack(inputs.slack);
        let retreat = self.retreat(metres(extension.length));
        let length = extension.length.to_bits().saturating_sub(retreat);
        // A screw that moves inward overshoots where it stops, by less than its speed times
        // `OVERSHOOT`.
        let overshoot = to_i32(speed * -OVERSHOOT);
        let overshoot = if overshoot > 0 { overshoot } else { 0 };
        let released = self.geometry.borrow().released_length().to_bits();
        let shortest = released.saturating_add(overshoot);
        let at_end = length < shortest;
        let (length, speed) = if at_end {
            (shortest, 0.0)
        } else {
            (length, speed)
        };
        let law = self.scale.shaft_from_length(i64::from(length));
        let step = law - core::mem::replace(&mut self.taut, law);

        if self.axle.operates_in(mode::TAUT) {
            // No joint moves like this: another node sends in its name, or its position is lost.
            if step.distance() > self.longest_step.distance() {
                return Err(Fault::DuplicateId);
            }
            let step = self.engage_step;
            self.remaining = if self.remaining > step {
                self.remaining - step
            } else if self.remaining < -step {
                self.remaining + step
            } else {
                Turns::ZERO
            };
        } else {
            self.remaining = self.axle.position() - law;
        }
        Ok(Motion {
            position: law + self.remaining,
            velocity: self.scale.shaft_velocity_from_linear(speed),
            acceleration: 0.0,
        })
    }

    /// Moves the present slack towards the commanded one, by at most what the engage speed allows
    /// in a tick.
    fn update_slack(&mut self, commanded: i32) {
        let commanded = if commanded <= 0 {
            0
        } else if commanded < self.most_slack {
            commanded
        } else {
            self.most_slack
        };
        // Both are between 0 and `most_slack`.
        let change = commanded - self.slack;
        self.slack = if change > self.slack_step {
            self.slack + self.slack_step
        } else if change < -self.slack_step {
            self.slack - self.slack_step
        } else {
            commanded
        };
    }

    /// Returns how far the screw draws back from the extension `length`, m, to give the belt its
    /// present slack. The result is in 2^-28 m.
    ///
    /// By eq. 2 of Paillat et al. the length of the front is
    /// `r = (K^2 - L1^2) / (2 (K + L1 cos theta))`. The difference between this length for `K` and
    /// for `K - s` is `s r (2 K - s - 2 r) / (K^2 - L1^2 - 2 s r)`, which does not contain theta.
    /// The error of single precision is 0.2 um, which has no effect on a slack belt.
    fn retreat(&self, length: f32) -> i32 {
        if self.slack == 0 {
            return 0;
        }
        let (s, r) = (self.slack as f32 * (1.0 / 16_777_216.0), length + self.l2);
        let (two_k, squares) = self.slack_terms;
        let (sr, front) = (s * r, r + r);
        // The result is below 8 m.
        let retreat = sr * (two_k - s - front) / (squares - (sr + sr));
        to_i32(retreat * 268_435_456.0)
    }
}

#[cfg(test)]
mod tests;
