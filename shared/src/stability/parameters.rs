//! Reads the parameters of the guard's supervision from the settings, and checks that they fit each
//! other and the robot's geometry.

use super::energy::Tipping;
use super::filter::{Bounds, Ramp};
use super::step_behind::StepBehind;
use super::support::{Edge, Stance};
use crate::constants::GRAVITY;
use crate::math::{max, sin_cos};
use crate::sensing::trust::Reason;
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// Minimum length of an edge, m; a shorter one has no direction.
const MIN_LENGTH: f32 = 1e-3;
/// Tolerance of the convexity check of the support, m, for rounding.
const TOLERANCE: f32 = 1e-6;

/// Uncertainty of the robot's masses and of its attitude.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Uncertainty {
    /// Largest distance of the centre of gravity from the model's, m.
    pub cog: f32,
    /// Mass of the largest undeclared load, kg.
    pub mass: f32,
    /// Largest distance of that load from the centre of gravity, m.
    pub reach: f32,
    /// Mass of the robot, kg.
    pub robot_mass: f32,
    /// Largest horizontal distance by which an error of the attitude moves the centre of gravity,
    /// m. It grows with the age of the gyroscope's newest reading and with the time since the robot
    /// last rested.
    pub attitude: f32,
}

impl Uncertainty {
    /// Distance that is subtracted from every margin, m: [`Self::at_known_attitude`], plus the
    /// distance by which an error of the attitude moves the centre of gravity.
    #[inline]
    pub fn deduction(&self) -> f32 {
        self.at_known_attitude() + self.attitude
    }

    /// Uncertainty of the centre of gravity, m, plus the distance `dm / (m + dm) reach` by which
    /// the load can shift it.
    #[inline]
    pub fn at_known_attitude(&self) -> f32 {
        self.cog + self.mass / (self.robot_mass + self.mass) * self.reach
    }
}

/// Levels, times and limits of the supervision; m, s, rad.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters {
    /// Margin below which commands are scaled.
    pub caution: f32,
    /// Margin at and below which no motion toward the edge passes.
    pub stop: f32,
    /// Margin below which the guard trips.
    pub trip: f32,
    /// Sine of the force-angle that corresponds to the stop margin.
    pub stop_sine: f32,
    /// Hysteresis: distance above a level that a margin must have before the band improves.
    pub hysteresis: f32,
    /// Dwell time: how long a margin must be there before the band changes.
    pub dwell: f32,
    /// How far ahead margins are predicted, in addition to the time of a stop.
    pub horizon: f32,
    /// Largest speed over ground, m/s.
    pub speed: f32,
    /// Acceleration and deceleration over ground, m/s^2.
    pub acceleration: f32,
    /// Largest deceleration of the guard's own stops, m/s^2; never below `acceleration`.
    pub braking: f32,
    /// Largest speed while the sensors are in doubt, in the override and when backing off, m/s.
    pub crawl_speed: f32,
    /// Square of the robot's radius of gyration, m^2; its body provides it.
    pub gyration: f32,
    /// Highest step that may be behind the robot; its body provides it.
    pub step_behind: StepBehind,
    /// Distance of the robot's driving sides from its middle, m; its body provides it.
    pub half_width: f32,
    /// Whether backing off is allowed.
    pub back_off: bool,
    /// Uncertainty of the robot's masses and of its attitude.
    pub uncertainty: Uncertainty,
}

/// Reason why a robot is not armed; values in m, m/s^2 and rad.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Refusal {
    /// The levels do not satisfy `0 <= trip < stop < caution`.
    Levels {
        /// Trip margin.
        trip: f32,
        /// Stop margin.
        stop: f32,
        /// Caution margin.
        caution: f32,
    },
    /// A coordinate of the support or of the centre of gravity is not finite.
    NotFinite,
    /// No contact is on the ground.
    NoSupport,
    /// The edge is too short to have a direction.
    NoEdge {
        /// The edge.
        edge: Edge,
        /// Its length.
        length: f32,
    },
    /// A corner of the support is outside an edge: the support is not convex, or not
    /// counter-clockwise.
    NotConvex {
        /// The edge.
        edge: Edge,
        /// Distance of the corner outside the edge.
        outside: f32,
    },
    /// On level ground the centre of gravity is nearer to the edge than the stop margin.
    CogOutside {
        /// The edge.
        edge: Edge,
        /// Its margin, the uncertainty subtracted.
        margin: f32,
    },
    /// The configured deceleration would tip the robot on level ground.
    Deceleration {
        /// Configured deceleration.
        configured: f32,
        /// Largest deceleration that leaves the trip margin.
        bearable: f32,
    },
    /// The signs of some axes of the sensors are not checked.
    SensorAxes {
        /// The axes that are checked: 1 about x, 2 about y, 4 about z.
        checked: u8,
    },
    /// The sensors on the body are not believed.
    Sensors {
        /// Why not.
        reason: Reason,
    },
    /// Drives would be homed, but the margin to the edge is below the trip margin.
    Margin {
        /// The edge.
        edge: Edge,
        /// Its margin.
        margin: f32,
    },
    /// Drives would be homed off level ground, and the operator has not confirmed it.
    OffLevel {
        /// Pitch or roll, whichever is larger, rad.
        tilt: f32,
    },
    /// The guard has refused some of its settings in flash, or their save was interrupted.
    Settings,
    /// The gyroscope reads too much while the robot rests.
    RateAtRest {
        /// Largest reading of an axis, rad/s.
        rate: f32,
        /// Largest allowed one, rad/s.
        bound: f32,
    },
}

impl Refusal {
    /// Code in object 0x4006:6; 0 means that there is no refusal.
    pub fn code(self) -> u8 {
        match self {
            Self::Levels { .. } => 1,
            Self::NotFinite => 2,
            Self::NoEdge { .. } => 3,
            Self::NotConvex { .. } => 4,
            Self::CogOutside { .. } => 5,
            Self::Deceleration { .. } => 6,
            Self::NoSupport => 7,
            Self::SensorAxes { .. } => 8,
            Self::Sensors { .. } => 9,
            Self::Margin { .. } => 10,
            Self::OffLevel { .. } => 11,
            Self::Settings => 12,
            Self::RateAtRest { .. } => 13,
        }
    }
}

impl Parameters {
    /// Reads the parameters from the settings.
    pub fn new(settings: &Settings) -> Self {
        Self {
            caution: settings.si(Setting::CautionMargin),
            stop: settings.si(Setting::StopMargin),
            trip: settings.si(Setting::TripMargin),
            stop_sine: sin_cos(Angle::from_radians(settings.si(Setting::StopAngle))).0,
            hysteresis: settings.si(Setting::BandHysteresis),
            dwell: settings.si(Setting::BandDwell),
            horizon: settings.si(Setting::PredictionHorizon),
            speed: settings.si(Setting::SpeedLimit),
            acceleration: settings.si(Setting::DriveAcceleration),
            braking: max(
                settings.si(Setting::GuardDeceleration),
                settings.si(Setting::DriveAcceleration),
            ),
            crawl_speed: settings.si(Setting::CrawlSpeed),
            gyration: 0.0,
            step_behind: StepBehind::NONE,
            half_width: 0.0,
            back_off: settings.get(Setting::BackOff) == 1,
            uncertainty: Uncertainty {
                cog: settings.si(Setting::CogUncertainty),
                mass: settings.si(Setting::MassUncertainty),
                reach: settings.si(Setting::MassUncertaintyReach),
                robot_mass: settings.si(Setting::RobotMass),
                attitude: 0.0,
            },
        }
    }

    /// Bounds of the filter that looks `horizon` s ahead, for a robot that turns like that and
    /// stops with the deceleration `braking`, m/s^2.
    pub fn bounds(&self, horizon: f32, braking: f32, tipping: [Tipping; 4]) -> Bounds {
        let ramp = |none, all| Ramp { none, all };
        Bounds {
            towards: ramp(self.stop, self.caution),
            away: ramp(self.trip, self.stop),
            horizon,
            foresight: self.horizon,
            tipping,
            half_width: self.half_width,
            fastest: self.speed,
            braking,
            noses: self.step_behind.height > 0.0,
        }
    }

    /// Checks whether a robot with this stance on level ground may be armed.
    ///
    /// # Errors
    /// [`Refusal`]: the first check that fails.
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
        let deduction = self.uncertainty.at_known_attitude();
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
            let margin = inside(stance.cog) - deduction;
            if !(margin >= self.stop) {
                return Err(Refusal::CogOutside { edge, margin });
            }
            // Braking loads the edges that lie across the direction of travel.
            let across = along[1].abs() / length;
            let height = max(stance.cog[2] - from[2], 0.0) * across + deduction + 1e-6;
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
        let bounds = parameters().bounds(0.4, 1.5, [Tipping::default(); 4]);
        let expected = [0.05, 0.09, 0.01, 0.05, 0.4, 0.15];
        assert_eq!((bounds.braking, bounds.fastest), (1.5, parameters().speed));
        assert!(!bounds.noses, "no step");
        let mut on_steps = parameters();
        on_steps.step_behind.height = 0.15;
        assert!(on_steps.bounds(0.4, 1.5, [Tipping::default(); 4]).noses);
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

    /// Compares with the centre of gravity of robot and load, computed by their moments.
    #[test]
    fn an_undeclared_load_widens_by_how_far_it_can_pull_the_centre_of_gravity() {
        let uncertainty = Uncertainty {
            cog: 0.005,
            mass: 2.0,
            reach: 0.25,
            robot_mass: 8.0,
            attitude: 0.0,
        };
        let pulled = (8.0 * 0.0 + 2.0 * 0.25) / 10.0;
        assert!((uncertainty.deduction() - 0.005 - pulled).abs() < 1e-6);
    }
}
