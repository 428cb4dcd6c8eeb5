//! The node of the driving screw: an axle that computes its own set-point. So
//! `L + (L2 + L3) = K - slack` holds for the present chassis angle, not for the angle at the time
//! when the joint's node sent it. The slack is 0 in mode "taut", and commanded in mode "released".

mod belt_watch;

use super::axle::{Axle, Belt, Inputs as AxleInputs, Outputs};
use crate::bus::pdo::DriveMotion;
use crate::bus::scale::Scale;
use crate::constants::CONTROL_PERIOD;
use crate::faults::Fault;
use crate::math::{Turns, to_i16, to_i32};
use crate::motor::profile::Motion;
use crate::screw::{Extension, Geometry, GeometryError, SlackLaw, Tension, metres};
use crate::settings::{Setting, Settings};
use crate::units::{Angle, Length};
use belt_watch::BeltWatch;
use core::borrow::Borrow;

/// Readings and messages since the previous tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// The axle's own inputs.
    pub axle: AxleInputs,
    /// Motion of the chassis joint (2^-32 turn, 1e-6 rad/s) and the time of its measurement, us, if
    /// a frame came.
    pub joint: Option<(DriveMotion, u64)>,
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
    slack_law: SlackLaw,
    /// Present slack of the belt, its largest value, and its largest change in one tick, at least
    /// 1; all in 2^-24 m and not negative.
    slack: i32,
    slack_limit: i32,
    slack_step: i32,
    /// The belt has not the commanded slack.
    lacks_slack: bool,
    tension: Tension,
    /// Tension to which a released belt is tightened, N.
    tighten_tension: f32,
    belt_watch: BeltWatch,
    /// Distance that is left to take up since the mode began, 2^-32 turn. It goes to zero at the
    /// engage speed.
    remaining: Turns,
    /// Position by the law of the belt in the previous tick, and the largest step from there, 2^-32
    /// turn.
    law: Turns,
    longest_step: Turns,
}

/// Units of a slack per metre.
const UNITS: f32 = 16_777_216.0;

/// Speed at which the slack of a tightened belt changes for each newton that the tension is away
/// from its set-point, m/s. A belt of 100 kN and 1.9 m gains 53 N in a millimetre. So the
/// crossover is at 26 rad/s, below the 50 rad/s of the low-pass. The default engage speed is that
/// of a belt without tension.
const TIGHTEN_GAIN: f32 = 0.0005;
/// Distance by which a belt that is tightened may yield beyond the commanded slack, 2^-24 m (5 mm).
const MOST_YIELD: i32 = 83_886;

/// Largest step of the extension by the law of the belt in a tick, beyond what the velocity limit
/// allows, m. Measured motions of the joint differ by less from those that the screw has
/// extrapolated.
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

/// Returns the largest step of the position by the law of the belt in a tick.
fn longest_step(settings: &Settings, scale: Scale) -> Turns {
    let unexpected = scale.shaft_velocity_from_linear(UNEXPECTED_STEP);
    Turns::from_radians(settings.si(Setting::VelocityLimit) * CONTROL_PERIOD + unexpected)
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
        let scale = Scale::linear(length(Setting::ScrewLead));
        let released = i64::from(table.released_length().to_bits());
        let retreat = (i64::from(length(Setting::HomingRetreat)) << 28) / 1_000_000;
        let reference = scale.shaft_from_length(released - retreat);
        // The extension is longest at half a turn of theta. There is nothing to reach beyond it or
        // below the switch.
        let longest = i64::from(table.length(Angle::from_bits(i32::MIN)).to_bits());
        let travel = (reference, scale.shaft_from_length(longest));
        let engage_metres = settings.si(Setting::EngageSpeed);
        let engage_speed = scale.shaft_velocity_from_linear(engage_metres);
        let slack_law = SlackLaw::new(table);
        Self {
            axle: Axle::with_scale::<false>(settings, scale, reference, Some(travel)),
            geometry,
            scale,
            joint: None,
            joint_timeout_us: settings.milliseconds(Setting::JointTimeout),
            engage_step: Turns::from_radians(engage_speed * CONTROL_PERIOD),
            slack_law,
            slack: 0,
            slack_limit: to_i32(settings.si(Setting::SlackLimit) * UNITS),
            lacks_slack: false,
            tension: Tension::default(),
            tighten_tension: settings.si(Setting::TightenTension),
            belt_watch: BeltWatch::new(settings),
            slack_step: to_i32(engage_metres * (CONTROL_PERIOD * UNITS)),
            remaining: Turns::ZERO,
            law: Turns::ZERO,
            longest_step: longest_step(settings, scale),
        }
    }

    /// Takes over the gains and limits of these settings, which take effect at once.
    pub fn retune(&mut self, settings: &Settings) {
        self.axle.retune_as::<false>(settings);
        self.longest_step = longest_step(settings, self.scale);
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

    /// Returns the estimated tension of the belts, N: the mean of both.
    pub fn tension(&self) -> f32 {
        self.tension.newtons()
    }

    /// Runs one control period.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        if inputs.joint.is_some() {
            self.joint = inputs.joint;
        }
        let belt = self.follow(inputs);
        self.watch_belts();
        let outputs = self
            .axle
            .tick_following(&inputs.axle, belt, self.lacks_slack);
        Outputs {
            belt_tension: to_i16(self.tension.newtons() * 10.0),
            ..outputs
        }
    }

    /// Reports an overload or the loss of a belt, which the axle's next tick raises.
    fn watch_belts(&mut self) {
        let engaged = self.remaining == Turns::ZERO && self.slack == 0;
        let taut = engaged && self.axle.follows_joint() && self.axle.homed();
        let faults = self.belt_watch.tick(self.tension.newtons(), taut);
        self.axle.report(faults);
    }

    /// Computes the set-point that gives the belt its present slack, for the joint's motion
    /// extrapolated to now.
    fn follow(&mut self, inputs: &Inputs) -> Belt {
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
        let follows = self.axle.follows_joint();
        let moves = follows && self.axle.is_free();
        let withheld = moves && self.update_slack();
        if !follows {
            // It engages from wherever its shaft is.
            self.slack = 0;
        }
        let taut = self.geometry.borrow().extension(theta);
        let slack = self.slack as f32 * (1.0 / UNITS);
        let extension = self.slack_law.extension(taut, slack);

        let speed = metres(extension.derivative) * rate;
        let length = extension.length.to_bits();
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
        let now = Extension {
            length: Length::from_bits(length),
            ..extension
        };
        let per_force = self.slack_law.tension_per_force(now, slack);
        let force = self.axle.unexpected_load(inputs.axle.current);
        self.tension.add(force * per_force, CONTROL_PERIOD);
        let law = self.scale.shaft_from_length(i64::from(length));
        let step = law - core::mem::replace(&mut self.law, law);

        // No joint moves like this: another node sends in its name, or its position is lost.
        if follows && step.distance() > self.longest_step.distance() {
            return Err(Fault::DuplicateId);
        }
        let step = self.engage_step;
        self.remaining = if !moves {
            self.axle.position() - law
        } else if self.remaining > step {
            self.remaining - step
        } else if self.remaining < -step {
            self.remaining + step
        } else {
            Turns::ZERO
        };
        self.lacks_slack = withheld || at_end && self.slack > 0;
        Ok(Motion {
            position: law + self.remaining,
            velocity: self.scale.shaft_velocity_from_linear(speed),
            acceleration: 0.0,
        })
    }

    /// Moves the present slack towards the commanded one, by at most what the engage speed allows
    /// in a tick. Returns whether the command is outside of what the settings allow.
    ///
    /// A released belt is tightened with a limited tension. It gets tighter while the tension is
    /// below the setting. It yields while the tension is above, up to [`MOST_YIELD`] beyond the
    /// command.
    fn update_slack(&mut self) -> bool {
        let commanded = self.axle.commanded_slack();
        let target = commanded.unwrap_or(0);
        // Both ends are constants, and 0 is the lower one.
        let allowed = target.max(0).min(self.slack_limit);
        let mut change = allowed - self.slack;
        if commanded.is_some() && change <= 0 {
            let excess = self.tension.newtons() - self.tighten_tension;
            let wanted = to_i32(excess * (TIGHTEN_GAIN * CONTROL_PERIOD * UNITS));
            change = wanted.max(change).min((change + MOST_YIELD).max(0));
        }
        self.slack += change.max(-self.slack_step).min(self.slack_step);
        allowed != target
    }
}

#[cfg(test)]
mod tests;
