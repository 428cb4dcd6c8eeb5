//! Clears stairs, curbs and ramps without a script: the operator commands speed and direction, the
//! controller commands the chassis angle and the slack, and how much of the speed to use.
//!
//! The controller knows what the guard's node knows: pitch and its rate, chassis angle, travel of
//! the belts, load of the tracks. It has no map, and knows nothing of the obstacle. Its output is
//! the command that the guard's filter limits.
//!
//! * [`phases`]: the phases, what each commands, and the table of transitions
//! * [`statics`]: which nose the robot gets over
//!
//! This file evaluates the conditions of the table.

pub mod phases;
pub mod statics;

pub use phases::{Cause, Phase};
pub use statics::{Clearing, Straight};

use crate::bus::pdo::GuardClearance;
use crate::bus::scale::{centidegrees, milli};
use crate::math::{Scalar, clamp, limit, max, min};
use crate::units::Angle;
use phases::{ASIDE, LEVEL, LEVEL_ROLL, TABLE, When};

/// Time constant of the pitch rate's low-pass, s.
const RATE_TIME: f32 = 0.06;
/// Pitch rate of a robot at rest, rad/s.
const QUIET: f32 = 0.09;
/// Change of the pitch that counts as progress, rad. On stairs that carry the robot by three noses
/// the pitch changes little.
const PROGRESS: f32 = 0.012;
/// Pitch above the one at which the robot passes its highest nose that gives the obstacle up, rad.
const BEYOND: f32 = 0.07;
/// Push of the tracks against a wall, as a part of the robot's weight.
const PUSH: f32 = 0.55;
/// Time for which the tracks must push, s.
const PUSH_TIME: f32 = 0.8;
/// Commanded speed from which on the time of a phase counts in full, m/s: the timeouts allow for
/// the travel at this speed.
const FULL_TIME: f32 = 0.08;
/// Shortest travel of the belts from one nose to the next, m. The flattest stairs, 8 cm by 22 cm,
/// have 0.23 m. A robot that gets over noses sooner slides back down between them.
const NOSE_DISTANCE: f32 = 0.2;
/// Steepest pitch that gives nothing up, rad.
const STEEPEST: f32 = statics::GIVEN_UP as f32 - BEYOND;

/// Pitch of an arch over a curb as high as body 1 is long, rad, and the rear margin that the robot
/// must have there, m: the guard's caution margin with the reserve for sways.
const ARCH: f32 = 1.22;
const ARCH_MARGIN: f32 = 0.15;

/// Returns whether a robot whose front is folded to [`phases::FOLDED`], with its centre of gravity
/// this far in front of axle 1 and above the axles, m, can stand as an arch. Only a low centre of
/// gravity and long belts allow it.
pub fn may_arch([forward, up]: [f32; 2]) -> bool {
    let (sine, cosine) = Scalar::sin_cos(ARCH);
    forward * cosine - up * sine >= ARCH_MARGIN
}

/// Time constant with which a robot that goes down turns downhill, s, the largest yaw rate for
/// this, rad/s, and the sine of the least slope on which it turns. The belts slide across the edges
/// that they turn on: the robot turns by an eighth of the commanded rate.
const DOWNHILL_TIME: f32 = 0.25;
const DOWNHILL_RATE: f32 = 0.5;
const DOWNHILL_SLOPE: f32 = 0.14;
/// Angle to the steepest descent up to which the robot goes down at full speed, and the one at
/// which its belts stand, rad.
const ASKEW: [f32; 2] = [0.03, 0.09];
/// Least part of the speed. Belts that slide across an edge hold nothing along it: the robot slides
/// down at about the speed of the belts, unless they run backward.
const LEAST_PART: f32 = -0.3;
/// Roll from which on the robot hangs with one track on the edge that the other one has left, rad.
/// It is more than stairs of 45 degrees turn a robot that is 15 degrees askew.
const HANGS: f32 = 0.2;

/// Returns the part of the speed, and the yaw rate, rad/s, that turn a robot downhill: if it heads
/// to the left of the steepest descent by a small angle, its left side is up by this angle times
/// the sine of the slope.
///
/// A robot that leaves the last edge with one track first falls to this side, until the other track
/// has left it, too. So it turns before. If it hangs, it drives on.
fn downhill(facts: &Facts) -> [f32; 2] {
    let (slope, _) = Scalar::sin_cos(-facts.pitch);
    if slope < DOWNHILL_SLOPE {
        return [1.0, 0.0];
    }
    let askew = facts.roll / slope;
    let [least, most] = ASKEW;
    let slower = (askew.abs() - least) / (most - least);
    let part = if facts.roll.abs() > HANGS {
        1.0
    } else {
        clamp(1.0 - slower, LEAST_PART, 1.0)
    };
    [part, limit(-askew / DOWNHILL_TIME, DOWNHILL_RATE)]
}

/// What the controller knows, once per SYNC.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facts {
    /// Pitch of the belts' lower run behind axle 2, nose up positive, rad. It is that of the body,
    /// unless the front is lowered: then the run goes from axle 1 to axle 3.
    pub pitch: f32,
    /// Its rate, rad/s.
    pub pitch_rate: f32,
    /// Measured chassis angle, rad.
    pub chassis: f32,
    /// Travel of the belts since the previous period, m.
    pub travel: f32,
    /// Push of both tracks as a part of the robot's weight.
    pub push: f32,
    /// Roll, left side up positive, rad.
    pub roll: f32,
    /// Heading.
    pub heading: Angle,
    /// Forward speed that the operator commands, m/s.
    pub speed: f32,
    /// Yaw rate that the operator commands, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
    /// Time since the previous period, s.
    pub period: f32,
}

impl Facts {
    /// Returns the yaw rate that the operator commands, rad/s; 0 in a phase in which the robot
    /// stands.
    fn yaw_rate_in(&self, phase: Phase) -> f32 {
        if phase.order().fastest > 0.0 {
            self.yaw_rate
        } else {
            0.0
        }
    }
}

/// What the controller commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Forward speed, m/s.
    pub speed: f32,
    /// Yaw rate, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
    /// Chassis angle, rad; `None` stays as it is.
    pub chassis: Option<f32>,
    /// Whether the belts are released; `None` leaves the slack as it is.
    pub released: Option<bool>,
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Clearance {
    phase: Phase,
    cause: Cause,
    transitions: u8,
    cleared: u8,
    /// Whether the robot has got over a nose or an edge since the approach.
    crossed: bool,
    /// Time and travel in the phase.
    lasted: f32,
    travelled: f32,
    rate: f32,
    level_for: f32,
    quiet_for: f32,
    pushing_for: f32,
    /// Pitch at the last progress, and travel since then.
    marked: f32,
    stuck: f32,
    /// Travel since the last nose, m, and the number of noses in a row that came too soon.
    since_nose: f32,
    slides: u8,
    /// Pitch on the noses of these stairs; `None` before the second one.
    noses: Option<f32>,
    /// Pitch that gives an obstacle up.
    too_steep: f32,
    attempt: Attempt,
    may_arch: bool,
    /// Heading before the obstacle, or as the operator has turned the robot.
    course: Angle,
}

/// What was tried at the present obstacle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Attempt {
    /// Nothing, or taut belts.
    Taut,
    /// It is too high for taut belts.
    TooHigh,
    /// It is too high, and released belts were tried.
    Released,
}

impl Clearance {
    /// Creates the controller of this robot, which may stand as an arch or not ([`may_arch`]).
    pub fn new(robot: &Straight<f32>, may_arch: bool) -> Self {
        let [steepest, _] = robot.highest(STEEPEST);
        Self {
            phase: Phase::Off,
            cause: Cause::None,
            transitions: 0,
            cleared: 0,
            crossed: false,
            lasted: 0.0,
            travelled: 0.0,
            rate: 0.0,
            level_for: 0.0,
            quiet_for: 0.0,
            pushing_for: 0.0,
            marked: 0.0,
            stuck: 0.0,
            since_nose: 0.0,
            slides: 0,
            noses: None,
            too_steep: steepest + BEYOND,
            attempt: Attempt::Taut,
            may_arch,
            course: Angle::ZERO,
        }
    }

    /// Returns the phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Ends the clearance: the operator takes over.
    pub fn end(&mut self) {
        if self.phase != Phase::Off {
            self.enter(Phase::Off, Cause::Operator, 0.0);
        }
    }

    /// Gives the clearance up where the robot stands, because something else stopped it.
    pub fn stop(&mut self) {
        if !matches!(self.phase, Phase::Off | Phase::GivenUp | Phase::Held) {
            self.enter(Phase::Held, Cause::Stopped, 0.0);
        }
    }

    /// Returns what the controller commands now.
    pub fn advance(&mut self, facts: &Facts) -> Wanted {
        if self.phase == Phase::Off {
            (self.attempt, self.noses, self.crossed) = (Attempt::Taut, None, false);
            (self.since_nose, self.slides) = (NOSE_DISTANCE, 0);
            self.enter(Phase::Approach, Cause::Operator, facts.pitch);
        }
        self.observe(facts);
        if facts.speed < 0.0 {
            return self.back(facts);
        }
        let next = TABLE.iter().find(|row| {
            row.from == self.phase && row.when.iter().all(|when| self.holds(*when, facts))
        });
        if let Some(row) = next {
            if row.cause == Cause::NextNose {
                self.noses = Some(
                    self.noses
                        .map_or(facts.pitch, |noses| min(noses, facts.pitch)),
                );
            }
            if row.cause == Cause::PastNose {
                let slid = self.since_nose < NOSE_DISTANCE;
                self.slides = if slid {
                    self.slides.saturating_add(1)
                } else {
                    0
                };
                self.since_nose = 0.0;
            }
            if row.to == Phase::Withdraw {
                self.slides = 0;
            }
            if row.to == Phase::Approach {
                let cleared = self.crossed && row.cause == Cause::Landed;
                self.cleared = self.cleared.saturating_add(u8::from(cleared));
                self.crossed = false;
                self.noses = None;
                self.attempt = Attempt::Taut;
            }
            if row.cause == Cause::TooHigh && self.attempt == Attempt::Taut && self.noses.is_none()
            {
                self.attempt = Attempt::TooHigh;
            }
            self.crossed |= matches!(row.to, Phase::Sway | Phase::Haul | Phase::Descend);
            if row.to == Phase::Raise {
                self.attempt = Attempt::Released;
            }
            self.enter(row.to, row.cause, facts.pitch);
        }
        let order = self.phase.order();
        let drives = facts.speed > 0.0;
        let [part, yaw_rate] = if drives && facts.yaw_rate == 0.0 && self.phase == Phase::Descend {
            downhill(facts)
        } else {
            [1.0, facts.yaw_rate_in(self.phase)]
        };
        Wanted {
            speed: part * order.speed * min(facts.speed, order.fastest),
            yaw_rate,
            chassis: order.chassis.map(f32::to_radians),
            released: order.released,
        }
    }

    /// Lets the operator back. The phase stays, and so does the front.
    fn back(&mut self, facts: &Facts) -> Wanted {
        let order = self.phase.order();
        // A robot that is backed on purpose does not slide.
        (self.stuck, self.slides) = (0.0, 0);
        Wanted {
            speed: -min(-facts.speed, order.fastest),
            yaw_rate: facts.yaw_rate_in(self.phase),
            chassis: None,
            released: order.released,
        }
    }

    /// Returns what is published.
    pub fn report(&self) -> GuardClearance {
        GuardClearance {
            phase: self.phase as u8,
            cause: self.cause as u8,
            transitions: self.transitions,
            cleared: self.cleared,
            noses: centidegrees(self.noses.unwrap_or(0.0)),
            travelled: milli(self.travelled),
        }
    }

    fn enter(&mut self, phase: Phase, cause: Cause, pitch: f32) {
        (self.phase, self.cause) = (phase, cause);
        self.transitions = self.transitions.wrapping_add(1);
        (self.lasted, self.travelled) = (0.0, 0.0);
        (self.quiet_for, self.level_for, self.pushing_for) = (0.0, 0.0, 0.0);
        (self.marked, self.stuck) = (pitch, 0.0);
    }

    fn observe(&mut self, facts: &Facts) {
        let period = facts.period;
        self.rate += (facts.pitch_rate - self.rate) * (period / (RATE_TIME + period));
        if !self.rate.is_finite() {
            self.rate = 0.0;
        }
        let timer = |holds: bool, time: f32| if holds { time + period } else { 0.0 };
        self.level_for = timer(
            facts.pitch.abs() < LEVEL.to_radians()
                && facts.roll.abs() < LEVEL_ROLL.to_radians()
                && self.rate.abs() < 2.0 * QUIET,
            self.level_for,
        );
        self.quiet_for = timer(self.rate.abs() < QUIET, self.quiet_for);
        self.lasted += period * clamp(facts.speed / FULL_TIME, 0.0, 1.0);
        let forward = if self.phase.order().speed < 0.0 {
            -facts.travel
        } else {
            facts.travel
        };
        self.travelled += forward;
        self.stuck += max(forward, 0.0);
        self.since_nose += max(forward, 0.0);
        if (facts.pitch - self.marked).abs() > PROGRESS {
            (self.marked, self.stuck) = (facts.pitch, 0.0);
        }
        self.pushing_for = timer(facts.push > PUSH, self.pushing_for);
        if self.phase == Phase::Approach || facts.yaw_rate != 0.0 {
            self.course = facts.heading;
        }
    }

    fn holds(&self, when: When, facts: &Facts) -> bool {
        let pitch = facts.pitch.to_degrees();
        let chassis = facts.chassis.to_degrees();
        match when {
            When::PitchAbove(bound) => pitch > bound,
            When::PitchBelow(bound) => pitch < bound,
            When::FallsFasterThan(bound) => self.rate.to_degrees() < -bound,
            When::ChassisAbove(bound) => chassis > bound,
            When::ChassisWithin(bound) => chassis.abs() < bound,
            When::LevelFor(time) => self.level_for >= time,
            When::Turned => {
                let turned = (facts.heading - self.course).radians();
                turned.abs() > ASIDE.to_radians()
            }
            When::QuietFor(time) => self.quiet_for >= time,
            When::Travelled(distance) => self.travelled >= distance,
            When::Lasted(time) => self.lasted >= time,
            When::TooSteepUp => facts.pitch > self.too_steep,
            When::BelowNoses(bound) => {
                (self.noses).is_some_and(|noses| pitch < noses.to_degrees() - bound)
            }
            When::Stuck(distance) => self.stuck >= distance,
            When::Slides(times) => self.slides >= times,
            When::Pushing => self.pushing_for >= PUSH_TIME,
            When::MayRelease => self.may_arch && self.attempt == Attempt::TooHigh,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nominal robot: K = 1.232 m, centre of gravity on the line of the axles.
    fn clearance() -> Clearance {
        let robot = Straight {
            cog: [0.2585, 0.0],
            length: 0.776,
            pulley_radius: 0.05,
        };
        Clearance::new(&robot, false)
    }

    fn facts(pitch_deg: f32, rate_deg_s: f32) -> Facts {
        Facts {
            pitch: pitch_deg.to_radians(),
            pitch_rate: rate_deg_s.to_radians(),
            travel: 0.13 * 4e-3,
            speed: 0.13,
            period: 4e-3,
            ..Facts::default()
        }
    }

    /// Lets the robot drive with these facts for a time, s.
    fn drive(clearance: &mut Clearance, facts: &Facts, time: f32) -> Wanted {
        let mut wanted = clearance.advance(facts);
        for _ in 0..(time / facts.period) as u32 {
            wanted = clearance.advance(facts);
        }
        wanted
    }

    #[test]
    fn a_nose_that_is_never_passed_is_given_up_on_level_ground() {
        let mut clearance = clearance();
        drive(&mut clearance, &facts(0.0, 0.0), 1.0);
        assert_eq!(clearance.phase(), Phase::Approach);
        drive(&mut clearance, &facts(20.0, 0.0), 1.0);
        assert_eq!(clearance.phase(), Phase::Climb);
        let wanted = drive(&mut clearance, &facts(51.0, 0.0), 0.1);
        assert_eq!(clearance.phase(), Phase::Withdraw);
        assert!(wanted.speed < 0.0, "{wanted:?}");
        let backward = Facts {
            travel: -2e-4,
            ..facts(0.0, 0.0)
        };
        let wanted = drive(&mut clearance, &backward, 4.0);
        assert_eq!(clearance.phase(), Phase::GivenUp);
        assert_eq!(wanted.speed, 0.0);
        assert_eq!(clearance.report().cause, Cause::Level as u8);
    }

    /// The operator backs in every phase, also in those that back by themselves.
    #[test]
    fn an_operator_who_backs_never_drives_the_robot_forward() {
        let mut clearance = clearance();
        let backward = |facts: Facts| Facts {
            speed: -0.1,
            ..facts
        };
        for pitch_deg in [0.0, 20.0, 51.0, 51.0, -10.0] {
            for _ in 0..20 {
                clearance.advance(&facts(pitch_deg, 0.0));
                let phase = clearance.phase();
                let wanted = clearance.advance(&backward(facts(pitch_deg, -30.0)));
                assert!(wanted.speed <= 0.0, "{phase:?}");
                assert_eq!(wanted.chassis, None);
                assert_eq!(clearance.phase(), phase);
            }
        }
    }

    #[test]
    fn a_stop_by_the_guard_is_held_until_the_operator_requests_anew() {
        let mut clearance = clearance();
        drive(&mut clearance, &facts(20.0, 0.0), 1.0);
        clearance.stop();
        let wanted = drive(&mut clearance, &facts(0.0, 0.0), 10.0);
        assert_eq!((clearance.phase(), wanted.speed), (Phase::Held, 0.0));
        assert_eq!(clearance.report().cause, Cause::Stopped as u8);
        clearance.end();
        assert_eq!(clearance.phase(), Phase::Off);
        drive(&mut clearance, &facts(0.0, 0.0), 0.1);
        assert_eq!(clearance.phase(), Phase::Approach);
    }

    /// Nothing that an operator asks moves tracks or belts of a robot that is held.
    #[test]
    fn a_robot_that_is_held_stands_and_keeps_its_slack() {
        let mut clearance = clearance();
        drive(&mut clearance, &facts(20.0, 0.0), 1.0);
        clearance.stop();
        for speed in [-0.1, 0.0, 0.1] {
            let turning = Facts {
                speed,
                yaw_rate: 0.3,
                ..facts(20.0, 0.0)
            };
            let wanted = clearance.advance(&turning);
            assert_eq!((wanted.speed, wanted.yaw_rate), (0.0, 0.0));
            assert_eq!((wanted.chassis, wanted.released), (None, None));
        }
    }

    #[test]
    fn without_a_commanded_speed_nothing_moves_in_any_phase() {
        let mut clearance = clearance();
        for (pitch_deg, roll) in [
            (0.0, 0.0),
            (-20.0, 0.1),
            (20.0, 0.1),
            (51.0, 0.1),
            (-30.0, 0.1),
        ] {
            let driving = Facts {
                roll,
                ..facts(pitch_deg, 0.0)
            };
            drive(&mut clearance, &driving, 0.1);
            let phase = clearance.phase();
            let wanted = clearance.advance(&Facts {
                speed: 0.0,
                travel: 0.0,
                ..driving
            });
            assert_eq!((wanted.speed, wanted.yaw_rate), (0.0, 0.0), "{phase:?}");
        }
    }

    /// A robot that backs off a nose that it has not passed has cleared nothing.
    #[test]
    fn an_obstacle_counts_as_cleared_only_behind_a_nose_or_an_edge() {
        for (falls, cleared) in [(false, 0), (true, 1)] {
            let mut clearance = clearance();
            drive(&mut clearance, &facts(20.0, 0.0), 1.0);
            assert_eq!(clearance.phase(), Phase::Climb);
            if falls {
                drive(&mut clearance, &facts(15.0, -30.0), 0.3);
            }
            drive(&mut clearance, &facts(0.0, 0.0), 3.0);
            assert_eq!(clearance.phase(), Phase::Approach);
            assert_eq!(clearance.report().cleared, cleared);
        }
    }

    /// On stairs a robot that slides back after each nose does not climb.
    #[test]
    fn noses_too_close_to_each_other_are_no_progress() {
        for (distance, phase) in [(0.15, Phase::Withdraw), (0.25, Phase::Climb)] {
            let mut clearance = clearance();
            drive(&mut clearance, &facts(22.0, 0.0), 1.0);
            for _ in 0..12 {
                drive(&mut clearance, &facts(22.0, -40.0), 0.1);
                drive(&mut clearance, &facts(22.0, 0.0), distance / 0.13 - 0.1);
            }
            assert_eq!(clearance.phase(), phase);
        }
    }

    #[test]
    fn an_operator_who_backs_between_noses_may_try_again() {
        let mut clearance = clearance();
        drive(&mut clearance, &facts(22.0, 0.0), 1.0);
        for _ in 0..12 {
            drive(&mut clearance, &facts(22.0, -40.0), 0.1);
            drive(&mut clearance, &facts(22.0, 0.0), 1.0);
            let backward = Facts {
                speed: -0.13,
                travel: -0.13 * 4e-3,
                ..facts(22.0, 0.0)
            };
            drive(&mut clearance, &backward, 1.0);
        }
        assert_eq!(clearance.phase(), Phase::Climb);
    }

    /// At any speed the robot travels as far until a phase times out.
    #[test]
    fn a_slow_operator_has_more_time() {
        for (speed, phase) in [(0.13, Phase::Withdraw), (0.01, Phase::Climb)] {
            let mut clearance = clearance();
            drive(&mut clearance, &facts(20.0, 0.0), 0.1);
            // The pitch changes as on stairs.
            for step in 0..125 {
                let slow = Facts {
                    speed,
                    travel: speed * 4e-3,
                    ..facts(20.0 + (step % 2) as f32 * 2.0, 0.0)
                };
                drive(&mut clearance, &slow, 1.0);
            }
            assert_eq!(clearance.phase(), phase);
        }
    }

    #[test]
    fn a_robot_that_turns_aside_is_held_unless_the_operator_turns_it() {
        for (yaw_rate, phase) in [(0.0, Phase::Held), (0.3, Phase::Climb)] {
            let mut clearance = clearance();
            let turned = |heading: f32| Facts {
                yaw_rate,
                heading: Angle::from_radians(heading),
                ..facts(20.0, 0.0)
            };
            drive(&mut clearance, &turned(3.0), 1.0);
            assert_eq!(clearance.phase(), Phase::Climb);
            drive(&mut clearance, &turned(-3.0), 0.1);
            assert_eq!(clearance.phase(), Phase::Climb);
            drive(&mut clearance, &turned(-2.5), 0.1);
            assert_eq!(clearance.phase(), phase);
        }
    }

    /// A robot across stairs has no pitch.
    #[test]
    fn a_robot_on_its_side_is_not_level() {
        let mut clearance = clearance();
        drive(&mut clearance, &facts(20.0, 0.0), 1.0);
        let across = Facts {
            roll: -0.5,
            ..facts(0.0, 0.0)
        };
        drive(&mut clearance, &across, 5.0);
        assert_eq!(clearance.phase(), Phase::Climb);
    }

    /// A heading to the left of the steepest descent raises the left side.
    #[test]
    fn a_robot_that_descends_turns_downhill() {
        let tilted = |roll: f32| Facts {
            roll,
            ..facts(-25.0, 0.0)
        };
        let mut clearance = clearance();
        for roll in [0.05, -0.05] {
            let wanted = drive(&mut clearance, &tilted(roll), 0.1);
            assert_eq!(clearance.phase(), Phase::Descend);
            assert!(wanted.yaw_rate * roll < 0.0, "{wanted:?}");
        }
    }

    /// A robot that is askew turns on the spot, one that hangs on an edge drives on.
    #[test]
    fn a_robot_that_descends_askew_turns_before_it_drives_on() {
        let speed = |roll: f32| {
            let mut clearance = clearance();
            let askew = Facts {
                roll,
                ..facts(-25.0, 0.0)
            };
            drive(&mut clearance, &askew, 0.1).speed
        };
        let full = speed(0.0);
        assert_eq!(speed(0.01), full);
        assert!((0.0..0.5 * full).contains(&speed(0.03)));
        for side in [1.0, -1.0] {
            assert!((-0.5 * full..0.0).contains(&speed(0.1 * side)));
            assert_eq!(speed(0.4 * side), full);
        }
    }
}
