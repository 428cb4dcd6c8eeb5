//! Numbers of the guard's supervision, from the settings, and the check that they and the robot's geometry make sense together.

use super::filter::{Bounds, Ramp};
use super::step_behind::StepBehind;
use super::support::{Edge, Stance};
use crate::constants::GRAVITY;
use crate::math::{max, sin_cos};
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// An edge shorter than this has no direction, m.
const MIN_LENGTH: f32 = 1e-3;
/// How far a support may be from convex, m: rounding.
const TOLERANCE: f32 = 1e-6;

/// What is not known of the masses.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Uncertainty {
    /// How far the centre of gravity may be from the model's, m.
    pub cog: f32,
    /// Largest undeclared load, kg.
    pub mass: f32,
    /// How far from the centre of gravity it may be, m.
    pub reach: f32,
    /// Mass of the robot, kg.
    pub robot_mass: f32,
}

impl Uncertainty {
    /// What is taken off every margin, m: the centre of gravity's own uncertainty, and how far the load can pull it, `dm / (m + dm) reach`.
    #[inline]
    pub fn widening(&self) -> f32 {
        self.cog + self.mass / (self.robot_mass + self.mass) * self.reach
    }
}

/// Levels, times and limits; m, s, rad.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters {
    /// Margin below which commands are scaled.
    pub caution: f32,
    /// Margin at which nothing passes that leads to the edge.
    pub stop: f32,
    /// Margin below which the guard trips.
    pub trip: f32,
    /// Sine of the force-angle that stands for the stop margin.
    pub stop_sine: f32,
    /// How far above a level a margin must be to leave its band for the better.
    pub hysteresis: f32,
    /// How long it must be there.
    pub dwell: f32,
    /// How far ahead margins are judged, beside the time of a stop.
    pub horizon: f32,
    /// Acceleration and deceleration over ground, m/s^2.
    pub acceleration: f32,
    /// Largest deceleration of the guard's own stops, m/s^2; at least the other.
    pub braking: f32,
    /// Largest speed in doubt, m/s.
    pub crawl_speed: f32,
    /// Highest step that may be behind the robot, which its body knows.
    pub step_behind: StepBehind,
    /// Distance of its driving sides from its middle, m, which its body knows, too.
    pub half_width: f32,
    /// Backing off is allowed.
    pub back_off: bool,
    /// What is not known of the masses.
    pub uncertainty: Uncertainty,
    /// Equal readings after which a sensor counts as stuck; 0 is never.
    pub stuck_readings: u32,
}

/// Why a robot is not armed: numbers in m and m/s^2.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Refusal {
    /// Not `0 <= trip < stop < caution`.
    Levels {
        /// Trip margin.
        trip: f32,
        /// Stop margin.
        stop: f32,
        /// Caution margin.
        caution: f32,
    },
    /// A coordinate of the support or of the centre of gravity is no number.
    NotFinite,
    /// Nothing stands on the ground.
    NoSupport,
    /// The edge is too short to have a direction.
    NoEdge {
        /// Which.
        edge: Edge,
        /// Its length.
        length: f32,
    },
    /// A corner of the support is outside of the edge: not convex, or not counter-clockwise.
    NotConvex {
        /// Which edge.
        edge: Edge,
        /// How far outside.
        outside: f32,
    },
    /// On level ground the centre of gravity is nearer to the edge than the stop margin.
    CogOutside {
        /// Which edge.
        edge: Edge,
        /// Its margin, the uncertainty taken off.
        margin: f32,
    },
    /// The configured deceleration would tip the robot on level ground.
    Deceleration {
        /// As configured.
        configured: f32,
        /// The largest that leaves the trip margin.
        bearable: f32,
    },
}

impl Refusal {
    /// Code in object 0x4006:6; 0 is none.
    pub fn code(self) -> u8 {
        match self {
            Self::Levels { .. } => 1,
            Self::NotFinite => 2,
            Self::NoEdge { .. } => 3,
            Self::NotConvex { .. } => 4,
            Self::CogOutside { .. } => 5,
            Self::Deceleration { .. } => 6,
            Self::NoSupport => 7,
        }
    }
}

impl Parameters {
    /// What the settings say.
    pub fn new(settings: &Settings) -> Self {
        let metres = |setting| settings.scaled(setting, 1e-6);
        let thousandths = |setting| settings.scaled(setting, 1e-3);
        Self {
            caution: metres(Setting::CautionMargin),
            stop: metres(Setting::StopMargin),
            trip: metres(Setting::TripMargin),
            stop_sine: sin_cos(Angle::from_radians(thousandths(Setting::StopAngle))).0,
            hysteresis: metres(Setting::BandHysteresis),
            dwell: thousandths(Setting::BandDwell),
            horizon: thousandths(Setting::PredictionHorizon),
            acceleration: metres(Setting::DriveAcceleration),
            braking: max(
                metres(Setting::GuardDeceleration),
                metres(Setting::DriveAcceleration),
            ),
            crawl_speed: metres(Setting::CrawlSpeed),
            step_behind: StepBehind::NONE,
            half_width: 0.0,
            back_off: settings.get(Setting::BackOff) == 1,
            uncertainty: Uncertainty {
                cog: metres(Setting::CogUncertainty),
                mass: thousandths(Setting::MassUncertainty),
                reach: metres(Setting::MassUncertaintyReach),
                robot_mass: thousandths(Setting::RobotMass),
            },
            stuck_readings: settings.get(Setting::StuckReadings) as u32,
        }
    }

    /// Bounds of the filter that looks this far ahead, s.
    pub fn bounds(&self, horizon: f32) -> Bounds {
        let ramp = |none, all| Ramp { none, all };
        Bounds {
            towards: ramp(self.stop, self.caution),
            away: ramp(self.trip, self.stop),
            horizon,
            foresight: self.horizon,
            reserve: 0.0,
            half_width: self.half_width,
        }
    }

    /// Whether a robot that stands on level ground like this may be armed.
    ///
    /// # Errors
    /// [`Refusal`]: the first thing that makes no sense.
    pub fn check(&self, stance: &Stance) -> Result<(), Refusal> {
        // Every comparison is false for NaN.
        if !(0.0 <= self.trip && self.trip < self.stop && self.stop < self.caution) {
            return Err(Refusal::Levels {
                trip: self.trip,
                stop: self.stop,
                caution: self.caution,
            });
        }
        let mut numbers = stance.contacts().chain([stance.cog]).flatten();
        if !numbers.all(f32::is_finite) {
            return Err(Refusal::NotFinite);
        }
        let widening = self.uncertainty.widening();
        let mut bearable = f32::INFINITY;
        if stance.contacts().next().is_none() {
            return Err(Refusal::NoSupport);
        }
        for (edge, there, [from, to]) in stance.edges() {
            if !there {
                continue;
            }
            let along = [to[0] - from[0], to[1] - from[1]];
            let length = crate::math::sqrt(along[0] * along[0] + along[1] * along[1]);
            if !(length > MIN_LENGTH) {
                return Err(Refusal::NoEdge { edge, length });
            }
            let inside = |point: [f32; 3]| {
                (along[0] * (point[1] - from[1]) - along[1] * (point[0] - from[0])) / length
            };
            let outside = stance
                .contacts()
                .fold(0.0, |most, point| max(most, -inside(point)));
            if !(outside <= TOLERANCE) {
                return Err(Refusal::NotConvex { edge, outside });
            }
            let margin = inside(stance.cog) - widening;
            if !(margin >= self.stop) {
                return Err(Refusal::CogOutside { edge, margin });
            }
            // Braking presses on the edges that lie across the way.
            let across = along[1].abs() / length;
            let height = max(stance.cog[2] - from[2], 0.0) * across + widening + 1e-6;
            bearable = crate::math::min(bearable, GRAVITY * (margin - self.trip) / height);
        }
        if !(self.acceleration <= bearable) {
            return Err(Refusal::Deceleration {
                configured: self.acceleration,
                bearable,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot 0.8 m long and 0.4 m wide.
    const CONTACTS: [[f32; 3]; 4] = [
        [0.0, -0.2, 0.0],
        [0.8, -0.2, 0.0],
        [0.8, 0.2, 0.0],
        [0.0, 0.2, 0.0],
    ];
    const COG: [f32; 3] = [0.3, 0.0, 0.2];

    fn stance() -> Stance {
        Stance::on(CONTACTS, COG)
    }

    fn parameters() -> Parameters {
        Parameters::new(&Settings::default())
    }

    #[test]
    fn the_bounds_of_the_filter_are_those_of_the_settings() {
        let bounds = parameters().bounds(0.4);
        let expected = [0.05, 0.09, 0.01, 0.05, 0.4, 0.15];
        let (towards, away) = (bounds.towards, bounds.away);
        let found = [
            towards.none,
            towards.all,
            away.none,
            away.all,
            bounds.horizon,
            bounds.foresight,
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{bounds:?}");
        }
    }

    #[test]
    fn a_sound_robot_is_armed() {
        assert_eq!(parameters().check(&stance()), Ok(()));
    }

    #[test]
    fn each_flaw_is_named_with_its_numbers() {
        let levels = Parameters {
            trip: 0.06,
            ..parameters()
        };
        assert!(matches!(
            levels.check(&stance()),
            Err(Refusal::Levels { trip: 0.06, stop, caution }) if stop < 0.06 && caution > 0.06
        ));
        let mut bad = stance();
        bad.cog[1] = f32::NAN;
        assert_eq!(parameters().check(&bad), Err(Refusal::NotFinite));
        let [rear_right, front_right, _, rear_left] = CONTACTS;
        let short = Stance::on([rear_right, front_right, front_right, rear_left], COG);
        assert_eq!(
            parameters().check(&short),
            Err(Refusal::NoEdge {
                edge: Edge::Front,
                length: 0.0
            })
        );
        let mut contacts = CONTACTS;
        contacts.reverse();
        let clockwise = Stance::on(contacts, COG);
        assert!(matches!(
            parameters().check(&clockwise),
            Err(Refusal::NotConvex { edge: Edge::Right, outside }) if (outside - 0.4).abs() < 1e-6
        ));
        let mut aside = stance();
        aside.cog[1] = 0.16;
        assert!(matches!(
            parameters().check(&aside),
            Err(Refusal::CogOutside { edge: Edge::Left, margin }) if (margin - 0.04).abs() < 1e-6
        ));
        assert_eq!(
            parameters().check(&Stance::default()),
            Err(Refusal::NoSupport)
        );
        let hasty = Parameters {
            acceleration: 20.0,
            ..parameters()
        };
        assert!(matches!(
            hasty.check(&stance()),
            // 9.81 (0.3 - 0.01) / 0.2
            Err(Refusal::Deceleration { configured: 20.0, bearable }) if (bearable - 14.2196).abs() < 0.01
        ));
    }

    /// The centre of gravity of robot and load, by their moments.
    #[test]
    fn an_undeclared_load_widens_by_how_far_it_can_pull_the_centre_of_gravity() {
        let uncertainty = Uncertainty {
            cog: 0.005,
            mass: 2.0,
            reach: 0.25,
            robot_mass: 8.0,
        };
        let pulled = (8.0 * 0.0 + 2.0 * 0.25) / 10.0;
        assert!((uncertainty.widening() - 0.005 - pulled).abs() < 1e-6);
    }
}
