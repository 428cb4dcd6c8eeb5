//! What the guard knows of the robot's balance, and what of a command it lets through to the body.
//!
//! Every control period the sensors are heard ([`Supervision::hear`]); once per SYNC the stance is judged ([`Supervision::judge`]), the trip's latch asked
//! what may be asked for at all ([`Supervision::admit`]), and the filter how much of that passes ([`Supervision::filter`]).

use crate::constants::CONTROL_PERIOD;
use crate::math::vector::Vector;
use crate::math::{max, min, sin_cos};
use crate::robots::{Ahead, Allowed, Asked, Body, Stop};
use crate::sensors::BodySensors;
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::bands::{Band, Bands};
use crate::stability::criterion::{Criterion, Evaluation};
use crate::stability::filter::{self, Margins, Ramp, SpeedCommand, Tracker, Verdict};
use crate::stability::limits::MotionLimits;
use crate::stability::parameters::{Parameters, Refusal};
use crate::stability::specific_force::SpecificForce;
use crate::stability::support::{Edge, NO_EDGE, Stance, narrowest};
use crate::stability::trip::{Cause, Mode, Requests, Sight, Snapshot, Trip, crawl};
use crate::stability::trust::{Reason, Trust, Watch};
use crate::stability::{step_behind, stopping};
use crate::units::Angle;

/// Share of the posture's speed in a supervised override.
const OVERRIDE_POSTURE: f32 = 0.25;

/// Who asks, when, and for what beside motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub now_us: u64,
    pub armed: bool,
    /// An operator is there, asks for motion, and holds the dead-man switch if there is one.
    pub attended: bool,
    /// The operator asks for ordinary driving.
    pub drives: bool,
    pub requests: Requests,
}

#[derive(Clone, Debug)]
pub(super) struct Supervision {
    parameters: Parameters,
    filter_active: bool,
    watch: Watch,
    trust: Trust,
    force: SpecificForce,
    level_force: Vector<f32>,
    criterion: Criterion,
    bands: Bands,
    trip: Trip,
    tracker: Tracker,
    sensors: BodySensors,
    found: Evaluation,
    stance: Stance,
    margins: Margins,
    limits: MotionLimits,
    mode: Mode,
    /// What keeps the robot from moving at all.
    stop: Option<Stop>,
}

impl Supervision {
    /// Supervision of this robot.
    pub fn new<B: Body>(settings: &Settings) -> Self {
        let mut parameters = Parameters::new(settings);
        parameters.uncertainty.robot_mass = B::mass(settings);
        parameters.step_behind = B::step_behind(settings);
        parameters.half_width = B::half_width(settings);
        Self {
            parameters,
            filter_active: settings.get(Setting::FilterActive) == 1,
            watch: Watch::new(parameters.stuck_readings),
            trust: Trust::None(Reason::Silent),
            force: SpecificForce::default(),
            level_force: [0.0; 3],
            criterion: Criterion::default(),
            bands: Bands::default(),
            trip: Trip::default(),
            tracker: Tracker::default(),
            sensors: BodySensors::default(),
            found: Evaluation::default(),
            stance: Stance::default(),
            margins: Margins::default(),
            limits: MotionLimits::default(),
            mode: Mode::default(),
            stop: None,
        }
    }

    /// Takes the sensors of one control period; true when the attitude filter may have them.
    pub fn hear(&mut self, sensors: Option<&BodySensors>) -> bool {
        let usable = self.watch.hear(sensors, CONTROL_PERIOD);
        if let Some(sensors) = sensors.filter(|_| usable) {
            self.force.hear(sensors.specific_force);
            self.sensors = *sensors;
        }
        usable
    }

    /// Judges how the robot stands, `period` s after the time before. `kept_shape` is how it would stand
    /// now with its shape of then, if that is known. Margins are worth nothing when the sensors are not.
    pub fn judge(
        &mut self,
        stance: &Stance,
        kept_shape: Option<&Stance>,
        attitude: &Attitude,
        speed: f32,
        period: f32,
    ) {
        self.level_force = self.force.advance(&attitude.level_axes(), period);
        self.found = self
            .criterion
            .evaluate(stance, self.level_force, speed, &self.parameters);
        self.watch
            .compare(self.level_force, !self.found.quick, period);
        self.trust = self.watch.trust();
        if matches!(self.trust, Trust::None(_)) {
            self.found.margins = [f32::NAN; 4];
        }
        self.stance = *stance;
        let widening = self.parameters.uncertainty.widening();
        let kept = kept_shape.map_or(self.found.gravity, |stance| {
            stance.margins().map(|margin| margin - widening)
        });
        self.margins = self
            .tracker
            .update(stance, &self.found, &kept, speed, period);
        self.limits = MotionLimits::of(&self.found, &self.parameters);
        self.bands
            .update(&self.found.margins, period, &self.parameters);
    }

    /// Whether a robot with this stance on level ground may be armed.
    pub fn check(&self, level: &Stance) -> Result<(), Refusal> {
        self.parameters.check(level)
    }

    /// What may be asked of the body: the operator's command, as far as there is one, sensors are believed and no trip is in the way.
    pub fn admit<P: Copy>(
        &mut self,
        asked: Asked<P>,
        posture: P,
        speed: f32,
        moment: &Moment,
    ) -> (Asked<P>, Verdict) {
        let trust = self.trust;
        let command = SpeedCommand {
            forward: asked.forward,
            yaw_rate: asked.yaw_rate,
        };
        let sight = Sight {
            armed: moment.armed && self.filter_active,
            band: self.bands.band(),
            trust,
            moment: Snapshot {
                cause: Cause::EmergencyStop,
                time_us: moment.now_us,
                margins: self.margins.now,
                edge: narrowest(&self.margins.now),
                asked: command,
                speed,
                sensors: self.sensors,
            },
        };
        self.mode = self.trip.update(&sight, moment.requests, &self.parameters);
        let edge = self
            .trip
            .snapshot()
            .map_or(sight.moment.edge, |kept| kept.edge);
        let cause = self.trip.snapshot().map(|kept| kept.cause);
        let stay = Asked {
            forward: 0.0,
            yaw_rate: 0.0,
            posture,
        };
        let with = |command: SpeedCommand, posture| Asked {
            forward: command.forward,
            yaw_rate: command.yaw_rate,
            posture,
        };
        let admitted = self.mode.admit(command, &self.parameters);
        let gently = (stay, Some(Stop::Gentle));
        let (passed, verdict) = match (self.mode, trust) {
            (Mode::Tripped, _) => {
                let verdict = match (cause, trust) {
                    (Some(Cause::EmergencyStop), _) => Verdict::EmergencyStopped,
                    (_, Trust::None(reason)) | (Some(Cause::Sensors(reason)), _) => {
                        Verdict::Blind(reason)
                    }
                    _ => Verdict::Tripped(edge),
                };
                ((stay, Some(Stop::Hard)), verdict)
            }
            (mode, Trust::None(reason)) if mode != Mode::Overridden => {
                (gently, Verdict::Blind(reason))
            }
            _ if !moment.attended => (gently, Verdict::Unattended),
            (Mode::Overridden, _) => (
                (with(admitted, asked.posture), None),
                Verdict::Overridden(edge),
            ),
            (Mode::BackingOff(_), _) => {
                ((with(admitted, posture), None), Verdict::BackingOff(edge))
            }
            _ if !moment.drives => (gently, Verdict::Passed),
            (_, Trust::Degraded(reason)) if self.filter_active => {
                let slow = crawl(command, &self.parameters);
                let verdict = if slow == command {
                    Verdict::Passed
                } else {
                    Verdict::Doubted(reason)
                };
                ((with(slow, asked.posture), None), verdict)
            }
            _ => ((asked, None), Verdict::Passed),
        };
        let (asked, stop) = passed;
        self.stop = stop;
        (asked, verdict)
    }

    /// What the margins leave of what was admitted. `ahead` is where the posture's motion leads within
    /// [`Self::horizon`], none while it is at rest. `stopping` is the time of a stop at the configured
    /// deceleration, s.
    pub fn filter<P>(
        &self,
        asked: &Asked<P>,
        ahead: Option<&Ahead>,
        pitch: f32,
        stopping: f32,
    ) -> (Allowed, Verdict) {
        let parameters = &self.parameters;
        let bearable = if asked.forward < 0.0 {
            self.limits.forward
        } else {
            self.limits.backward
        };
        // Harder braking is kept for what nobody foresaw.
        let brake = min(bearable, parameters.acceleration);
        let backs_off = matches!(self.mode, Mode::BackingOff(_));
        let horizon = parameters.horizon + stopping * (parameters.acceleration / brake);
        let mut bounds = parameters.bounds(horizon);
        if backs_off {
            // The trip itself watches the edge from which the robot backs off.
            bounds.away = Ramp {
                none: -NO_EDGE,
                all: -NO_EDGE,
            };
        }
        bounds.reserve =
            self.lifted(pitch) * filter::sway(Edge::Back, pitch) * bounds.towards.width();
        // A robot that is about to fall over its rear needs every way out: as driving forward ends,
        // backing and folding begin to pass whatever may be behind.
        let kept = bounds.towards.moved(bounds.reserve);
        let wide = kept.share(self.margins.now[Edge::Back as usize]);
        let (posture_share, posture) = ahead.map_or((1.0, Verdict::Passed), |ahead| {
            let margins = self.as_now(ahead.stance.margins());
            let judged = filter::posture(pitch, &self.margins, margins, &bounds);
            if !ahead.lifts {
                return judged;
            }
            step_behind::within(judged, self.room(), 1.0 - wide)
        });
        let command = SpeedCommand {
            forward: asked.forward,
            yaw_rate: asked.yaw_rate,
        };
        let driven = filter::drive(command, pitch, &self.margins, &bounds);
        let (share, drive) = if backs_off {
            driven
        } else {
            filter::within_speed(driven, asked.forward, self.speed_limit(asked.forward, wide))
        };
        let unhindered = Allowed {
            share: 1.0,
            stop: self.stop,
            posture: self.stop.is_none(),
            limits: MotionLimits::unlimited(parameters),
        };
        if !self.filter_active {
            return (unhindered, Verdict::Passed);
        }
        if self.mode == Mode::Overridden {
            let limits = MotionLimits {
                posture: OVERRIDE_POSTURE,
                ..unhindered.limits
            };
            return (
                Allowed {
                    limits,
                    ..unhindered
                },
                Verdict::Passed,
            );
        }
        let allowed = Allowed {
            share,
            stop: self.stop,
            posture: posture_share > 0.0 && self.stop.is_none(),
            limits: MotionLimits {
                posture: posture_share,
                ..self.limits
            },
        };
        let verdict = if drive == Verdict::Passed {
            posture
        } else {
            drive
        };
        (allowed, verdict)
    }

    /// Margins of another shape, m, less what uncertainty and measured force take from the present
    /// ones.
    fn as_now(&self, margins: [f32; 4]) -> [f32; 4] {
        let widening = self.parameters.uncertainty.widening();
        core::array::from_fn(|index| {
            let force = self.found.gravity[index] - self.margins.now[index];
            margins[index] - widening - force
        })
    }

    /// How much the body counts as lifted, 0 to 1: it stands on its rear and on a front that lifts it,
    /// and sways when either moves. Its sine exceeds that of its support by 0.05 to 0.15. 0 for NaN.
    fn lifted(&self, pitch: f32) -> f32 {
        const LIFTED: Ramp = Ramp {
            none: 0.05,
            all: 0.15,
        };
        let [_, support] = self.stance.along();
        LIFTED.share(sin_cos(Angle::from_radians(pitch)).0 - support)
    }

    /// What a fall off a step behind leaves of the present stance, m.
    fn room(&self) -> f32 {
        let parameters = &self.parameters;
        let widening = parameters.uncertainty.widening();
        step_behind::room(&self.stance, &parameters.step_behind, widening)
    }

    /// Largest speed in the direction of a command at which neither an instant stop nor the fall off
    /// a step behind tips the robot. Crawling back stays free as far as the rear margin is not `wide`
    /// (0 to 1).
    fn speed_limit(&self, forward: f32, wide: f32) -> (f32, Edge) {
        let widening = self.parameters.uncertainty.widening();
        let (limit, edge) = stopping::speed_limit(&self.stance, &self.found, forward, widening);
        if edge == Edge::Front {
            return (limit, edge);
        }
        let crawl = (1.0 - wide) * self.parameters.crawl_speed;
        (
            min(limit, max(step_behind::speed(self.room()), crawl)),
            edge,
        )
    }

    pub fn horizon(&self) -> f32 {
        self.parameters.horizon
    }

    pub fn margins(&self) -> &Margins {
        &self.margins
    }

    /// A trip or an emergency stop is latched.
    pub fn tripped(&self) -> bool {
        self.trip.latched()
    }

    pub fn telemetry(&self, refusal: Option<Refusal>) -> Telemetry {
        Telemetry {
            band: self.bands.band(),
            trust: self.trust,
            with_force: self.found.fast,
            tripped: self.trip.latched(),
            trips: self.trip.count(),
            limits: self.limits,
            snapshot: self.trip.snapshot().copied(),
            refusal,
        }
    }
}

/// What the guard knows of the robot's balance (objects 0x4006 and 0x4007).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Telemetry {
    /// Band of the narrowest margin.
    pub band: Band,
    /// How far the sensors on the body are believed.
    pub trust: Trust,
    /// The measured force counts, beside the centre of gravity.
    pub with_force: bool,
    /// The guard has tripped.
    pub tripped: bool,
    /// Trips since power-up.
    pub trips: u16,
    /// Limits that the margins hand down.
    pub limits: MotionLimits,
    /// What was known at the last trip.
    pub snapshot: Option<Snapshot>,
    /// Why the robot is not armed.
    pub refusal: Option<Refusal>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robots::b2p2::B2p2;

    fn settings(changes: &[(Setting, i32)]) -> Settings {
        let mut settings = Settings::default();
        for (setting, value) in changes {
            settings
                .set(setting.description().key, *value)
                .expect("a value within bounds");
        }
        settings
    }

    /// A support 0.8 m long and 0.6 m wide, with the centre of gravity `ahead` of the rear edge.
    fn stance(ahead: f32) -> Stance {
        let contacts = [
            [0.0, -0.3, 0.0],
            [0.8, -0.3, 0.0],
            [0.8, 0.3, 0.0],
            [0.0, 0.3, 0.0],
        ];
        Stance::on(contacts, [ahead, 0.0, 0.2])
    }

    /// Supervision of a robot at rest on level ground, with good sensors.
    fn standing(settings: &Settings, ahead: f32, speed: f32) -> Supervision {
        let mut supervision = Supervision::new::<B2p2>(settings);
        let level = BodySensors {
            specific_force: [0.0, 0.0, 9.81],
            ..BodySensors::default()
        };
        let mut attitude = Attitude::default();
        for step in 0..100 {
            // Readings that never change would be those of a stuck sensor.
            let noise = 1e-5 * (step % 3) as f32;
            let reading = BodySensors {
                inclination: [noise, -noise],
                ..level
            };
            assert!(supervision.hear(Some(&reading)));
            attitude.update(&reading, CONTROL_PERIOD);
            supervision.judge(&stance(ahead), None, &attitude, speed, 4e-3);
        }
        supervision
    }

    /// The shape ahead has 65 mm behind, which a certain robot may use slowly; 20 mm less, it may not.
    #[test]
    fn the_uncertainty_is_taken_off_the_margin_ahead() {
        for (uncertainty, passes) in [(0, true), (20_000, false)] {
            let settings = settings(&[(Setting::CogUncertainty, uncertainty)]);
            let supervision = standing(&settings, 0.3, 0.0);
            let (allowed, verdict) = supervision.filter(
                &Asked::<()>::default(),
                Some(&stance(0.065).into()),
                0.0,
                0.0,
            );
            let expected = if passes {
                Verdict::PostureScaled(Edge::Back)
            } else {
                Verdict::PostureRefused(Edge::Back)
            };
            assert_eq!((allowed.posture, verdict), (passes, expected));
        }
    }

    /// The shape ahead has 80 mm behind: enough on level ground, too little for a steep robot's sway.
    #[test]
    fn a_steep_robot_keeps_room_for_its_sway() {
        let supervision = standing(&Settings::default(), 0.3, 0.0);
        for (pitch, passes) in [(0.0, true), (0.6, false), (-0.6, true)] {
            let (allowed, _) = supervision.filter(
                &Asked::<()>::default(),
                Some(&stance(0.08).into()),
                pitch,
                0.0,
            );
            assert_eq!(allowed.posture, passes, "{pitch}");
        }
    }

    /// The margin behind falls with 0.3 m/s to 0.2 m: because the shape changes, or because the robot
    /// rears up, which it does after the change of shape as well.
    #[test]
    fn a_change_of_shape_is_no_decay_but_rearing_up_is_from_its_first_moment() {
        let asked = Asked {
            forward: 0.1,
            ..Asked::<()>::default()
        };
        let attitude = Attitude::default();
        let fall = 0.3 * CONTROL_PERIOD;
        // Steps of rearing up until something is held back, after a change of shape to 0.2 m from `start`.
        let held_back = |start: f32| {
            let mut supervision = standing(&Settings::default(), start, 0.1);
            let mut judge = |margin: f32, kept: f32| {
                let (now, kept) = (stance(margin), stance(kept));
                supervision.judge(&now, Some(&kept), &attitude, 0.1, CONTROL_PERIOD);
                supervision.filter(&asked, None, 0.3, 0.1).0.share < 1.0
            };
            let mut margin = start;
            while margin > 0.2 {
                margin -= fall;
                assert!(!judge(margin, margin + fall), "{margin}");
            }
            margin = 0.2;
            let mut steps = 0;
            while !judge(margin, margin) {
                margin -= fall;
                steps += 1;
            }
            steps
        };
        let (after_rest, after_change) = (held_back(0.2), held_back(0.6));
        assert!(after_rest > 0);
        assert_eq!(after_rest, after_change);
    }

    /// 2 kg undeclared within 0.3 m, on robots of 8.315 kg and 40 kg: the pull on the centre of
    /// gravity by its moments.
    #[test]
    fn a_heavier_robot_is_less_uncertain() {
        for (body_1, total) in [(6_356_067, 8.315_283), (38_040_784, 40.0)] {
            let settings = settings(&[
                (Setting::MassUncertainty, 2_000),
                (Setting::Body1Mass, body_1),
            ]);
            let found = standing(&settings, 0.4, 0.0).margins().now[0];
            let expected = 0.4 - 2.0 * 0.3 / (total + 2.0);
            assert!((f64::from(found) - expected).abs() < 1e-5, "{found}");
        }
    }

    /// The centre of gravity is 0.2 m high on level ground: no fall off a step of 150 mm is borne. Where
    /// the margin is wide, nothing passes backward, and the front is not folded down. Where it is
    /// narrow, these may be the ways out.
    #[test]
    fn a_narrow_margin_leaves_the_ways_out_though_a_step_may_be_behind() {
        let backward = Asked {
            forward: -0.45,
            ..Asked::<()>::default()
        };
        // A lifted body keeps 40 mm for its sway, and so its ways out open earlier.
        for (pitch, reserve) in [(0.04, 0.0), (0.5, 0.04)] {
            let judge = |margin: f32| {
                let margin = margin + reserve;
                let supervision = standing(&Settings::default(), margin, 0.0);
                let ahead = Ahead {
                    stance: stance(margin + 0.001),
                    lifts: true,
                };
                let (allowed, _) = supervision.filter(&backward, Some(&ahead), pitch, 0.0);
                (0.45 * allowed.share, allowed.limits.posture)
            };
            assert_eq!(judge(0.10), (0.0, 0.0));
            let (backed, folded) = judge(0.07);
            assert!((backed - 0.025).abs() < 1e-3 && (folded - 0.5).abs() < 0.02);
            let (backed, folded) = judge(0.045);
            assert!(
                (backed - 0.05).abs() < 1e-3 && folded > 0.8,
                "{backed} {folded}"
            );
        }
    }

    /// A support that rises along the heading with this sine, and the centre of gravity `ahead` of its
    /// rear edge.
    fn sloped(sine: f32, ahead: f32) -> Stance {
        let up = 0.8 * sine;
        let contacts = [
            [0.0, -0.3, 0.0],
            [0.8, -0.3, up],
            [0.8, 0.3, up],
            [0.0, 0.3, 0.0],
        ];
        Stance::on(contacts, [ahead, 0.0, 0.2])
    }

    /// 100 mm from the rear edge at a pitch of 35 degrees.
    #[test]
    fn a_body_that_is_steeper_than_its_support_keeps_the_band_for_its_sway_while_it_drives() {
        let asked = Asked {
            forward: 0.2,
            ..Asked::<()>::default()
        };
        let share = |tangent: f32| {
            let mut supervision = standing(&Settings::default(), 0.1, 0.0);
            supervision.stance = sloped(tangent, 0.1);
            supervision.filter(&asked, None, 0.6, 0.0).0.share
        };
        // The sine of the pitch is 0.565.
        let tangent =
            |difference: f32| libm::tan(libm::asin(0.564_6 - f64::from(difference))) as f32;
        assert!((share(0.0) - 0.25).abs() < 0.02);
        assert!((share(tangent(0.15)) - 0.25).abs() < 0.02);
        assert!((share(tangent(0.10)) - 0.75).abs() < 0.03);
        for difference in [0.05, 0.0, -0.2] {
            assert!(share(tangent(difference)) > 0.98, "{difference}");
        }
    }

    /// Nose up at 70 mm from the rear edge.
    #[test]
    fn the_guard_holds_back_a_turn_nose_up() {
        let turn = Asked {
            yaw_rate: 0.5,
            ..Asked::<()>::default()
        };
        let mut supervision = standing(&Settings::default(), 0.07, 0.0);
        supervision.stance = sloped(0.2, 0.07);
        let share = |pitch: f32| supervision.filter(&turn, None, pitch, 0.0).0.share;
        assert!((share(0.2) - 0.5).abs() < 0.02, "{}", share(0.2));
        assert_eq!(share(-0.05), 1.0);
    }

    /// Whatever margin is left, and however steep the robot is, one of the motions is not slow.
    #[test]
    fn some_motion_always_passes_above_the_trip_margin() {
        let supervision = |margin: f32| standing(&Settings::default(), margin, 0.0);
        for margin in (12..140).map(|millimetres| millimetres as f32 * 1e-3) {
            let supervision = supervision(margin);
            for pitch in [0.0, 0.1, 0.2, 0.4, 0.6, 0.8] {
                let share = |forward: f32| {
                    let asked = Asked {
                        forward,
                        ..Asked::<()>::default()
                    };
                    supervision.filter(&asked, None, pitch, 0.0).0.share
                };
                let ahead = Ahead {
                    stance: stance(margin + 0.001),
                    lifts: true,
                };
                let none = Asked::<()>::default();
                let (folding, _) = supervision.filter(&none, Some(&ahead), pitch, 0.0);
                let most = max(max(share(0.05), share(-0.05)), folding.limits.posture);
                assert!(most > 0.09, "{margin} at {pitch}: {most}");
            }
        }
    }

    /// The centre of gravity is 0.2 m high and 30 mm ahead of the rear edge: an instant stop bears
    /// 0.21 m/s there.
    #[test]
    fn backing_down_close_to_the_rear_edge_is_slow() {
        let mut settings = Settings::default();
        settings
            .set(Setting::StepBehind.description().key, 0)
            .expect("no step");
        let supervision = standing(&settings, 0.03, -0.1);
        let backward = Asked {
            forward: -0.45,
            ..Asked::<()>::default()
        };
        let (allowed, verdict) =
            supervision.filter(&backward, Some(&stance(0.03).into()), 0.3, 0.0);
        assert_eq!(verdict, Verdict::Scaled(Edge::Back));
        let passed = 0.45 * allowed.share;
        // v^2 = 2 g (l - h) l^2 / h^2 with l^2 = 0.0409 m^2.
        assert!((passed - 0.2099).abs() < 2e-3, "{passed}");
    }
}
