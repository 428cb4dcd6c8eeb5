//! B2P2's body: how it stands, what the operator's command becomes, and the set-points that follow from it.

use super::drives::{Drives, Role};
use crate::bus::pdo::OperatorCommand;
use crate::math::{clamp, limit, to_i32};
use crate::motor::profile::{Limits, SetPoint as Motion};
use crate::robots::b2p2::Model;
use crate::screw::{Geometry, GeometryError, metres};
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::filter::{Bounds, Margins, Tracker, Verdict, chassis, drive};
use crate::stability::support::margins;
use crate::units::Angle;

/// Gain with which the heading is held while no yaw is asked for, 1/s, and the largest yaw rate that it asks for, rad/s.
const HEADING_GAIN: f32 = 1.5;
const HEADING_RATE: f32 = 0.3;
/// Acceleration of the chassis joint, rad/s^2.
const CHASSIS_ACCELERATION: f32 = 4.0;
const METRES_PER_BUS: f32 = 1.0 / 16_777_216.0;

#[derive(Clone, Debug)]
pub(super) struct Body {
    model: Model,
    geometry: Geometry,
    bounds: Bounds,
    filter_active: bool,
    speed: Limits,
    chassis_limits: Limits,
    gauge: f32,
    pulley_radius: f32,
    released_bus: i32,

    joint_known: bool,
    screw_known: bool,
    theta: Angle,
    extension: f32,
    tracks: Option<[i32; 2]>,
    odometry_um: f32,
    odometry_whole_um: i32,
    tracker: Tracker,
    margins: Margins,
    /// Set-point of the chassis joint, 2^-32 turn.
    chassis: Motion,
    /// Forward speed that is passed on; its position is not used.
    forward: Motion,
    yaw_rate: f32,
    heading: Option<Angle>,
    share: f32,
}

impl Body {
    pub fn new(settings: &Settings) -> Result<Self, GeometryError> {
        let metres = |setting| settings.scaled(setting, 1e-6);
        let geometry = Geometry::from_micrometres(
            settings.get(Setting::LengthL1),
            settings.get(Setting::LengthL2),
            settings.get(Setting::LengthK),
        )?;
        let retreat = (i64::from(settings.get(Setting::ReferenceRetreat)) << 24) / 1_000_000;
        let released = i64::from(geometry.released_length().to_bits() >> 4) - retreat;
        Ok(Self {
            model: Model::new(settings),
            geometry,
            bounds: Bounds {
                caution: metres(Setting::CautionMargin),
                stop: metres(Setting::StopMargin),
                horizon: settings.scaled(Setting::PredictionHorizon, 1e-3),
            },
            filter_active: settings.get(Setting::FilterActive) == 1,
            speed: Limits {
                velocity: metres(Setting::SpeedLimit),
                acceleration: metres(Setting::DriveAcceleration),
            },
            chassis_limits: Limits {
                velocity: settings.scaled(Setting::ChassisSpeed, 1e-3),
                acceleration: CHASSIS_ACCELERATION,
            },
            gauge: metres(Setting::TrackGauge),
            pulley_radius: metres(Setting::PulleyRadius),
            released_bus: released as i32,
            joint_known: false,
            screw_known: false,
            theta: Angle::ZERO,
            extension: released as f32 * METRES_PER_BUS,
            tracks: None,
            odometry_um: 0.0,
            odometry_whole_um: 0,
            tracker: Tracker::default(),
            margins: Margins::default(),
            chassis: Motion::default(),
            forward: Motion::default(),
            yaw_rate: 0.0,
            heading: None,
            share: 1.0,
        })
    }

    /// Takes what the drives and the attitude filter say, once per SYNC.
    pub fn observe(&mut self, drives: &Drives, attitude: &Attitude, period: f32) {
        self.joint_known = drives.of(Role::Joint).referenced();
        self.screw_known = drives.of(Role::Screw).referenced();
        if self.joint_known {
            self.theta = Angle::from_bits(drives.of(Role::Joint).position());
        }
        if self.screw_known {
            self.extension = drives.of(Role::Screw).position() as f32 * METRES_PER_BUS;
        }
        let tracks = [Role::Left, Role::Right].map(|role| drives.of(role).position());
        if let Some(before) = self.tracks {
            let turns = |side: usize| tracks[side].wrapping_sub(before[side]) as f32 / 65_536.0;
            let way = core::f32::consts::PI * self.pulley_radius * (turns(0) + turns(1));
            // Whole micrometres leave the sum, so that it never grows coarse.
            self.odometry_um += way * 1e6;
            let whole = to_i32(self.odometry_um);
            self.odometry_um -= whole as f32;
            self.odometry_whole_um = self.odometry_whole_um.wrapping_add(whole);
        }
        self.tracks = Some(tracks);
        let now = self.margins_at(self.theta, self.extension, attitude);
        self.margins = self.tracker.update(now, period);
    }

    fn margins_at(&self, theta: Angle, extension: f32, attitude: &Attitude) -> [f32; 4] {
        let shape = self.model.shape(theta, extension);
        let axes = attitude.level_axes();
        let level = |point| axes.of(point);
        margins(&self.model.support(&shape, level), level(shape.cog))
    }

    /// Turns a command into set-points, once per SYNC. Unless `armed`, everything stays where it is.
    pub fn drive(
        &mut self,
        asked: OperatorCommand,
        armed: bool,
        attitude: &Attitude,
        period: f32,
    ) -> Verdict {
        if !armed {
            self.forward = Motion::default();
            self.yaw_rate = 0.0;
            self.heading = None;
            self.share = 1.0;
            self.chassis = Motion::at(i64::from(self.theta.to_bits()));
            return Verdict::Passed;
        }
        let forward = f32::from(asked.forward) * 1e-3;
        let (share, drive_verdict) = drive(
            forward,
            attitude.pitch().radians(),
            &self.margins,
            &self.bounds,
        );
        self.share = if self.filter_active { share } else { 1.0 };
        self.forward
            .toward_velocity(forward * self.share, self.speed, period);
        self.yaw_rate = self.yaw(f32::from(asked.yaw_rate) * 1e-3 * self.share, attitude);

        let chassis_verdict = self.move_chassis(asked.chassis, attitude, period);
        if drive_verdict == Verdict::Passed {
            chassis_verdict
        } else {
            drive_verdict
        }
    }

    fn move_chassis(&mut self, asked: i16, attitude: &Attitude, period: f32) -> Verdict {
        // The joint turns less than half a turn each way, so that a wrapped angle is the angle.
        let target = i64::from(i32::from(asked) << 16);
        let mut next = self.chassis;
        next.toward_position(target, self.chassis_limits, period);
        let reach = Angle::from_radians(next.velocity * self.bounds.horizon);
        let ahead = self.theta + reach;
        let length = metres(self.geometry.length(ahead));
        let verdict = chassis(
            &self.margins,
            self.margins_at(ahead, length, attitude),
            &self.bounds,
        );
        if verdict != Verdict::Passed && self.filter_active {
            next = self.chassis;
            next.toward_velocity(0.0, self.chassis_limits, period);
        }
        self.chassis = next;
        verdict
    }

    /// Yaw rate: as asked, or what holds the heading while none is asked for.
    fn yaw(&mut self, asked: f32, attitude: &Attitude) -> f32 {
        if asked != 0.0 || self.forward.velocity == 0.0 {
            self.heading = None;
            return asked;
        }
        let wanted = *self.heading.get_or_insert(attitude.heading());
        limit(
            HEADING_GAIN * (wanted - attitude.heading()).radians(),
            HEADING_RATE,
        )
    }

    /// Set-points of the left and right track, 1e-6 rad/s.
    pub fn track_speeds(&self) -> [i32; 2] {
        let turn = 0.5 * self.gauge * self.yaw_rate;
        [-turn, turn].map(|side| to_i32((self.forward.velocity + side) / self.pulley_radius * 1e6))
    }

    /// Set-point of the chassis joint, 2^-32 turn.
    pub fn joint_bus(&self) -> i32 {
        self.chassis.position as i32
    }

    /// The same in 2^-16 turn.
    pub fn chassis_bus(&self) -> i16 {
        ((self.chassis.position + 0x8000) >> 16) as i16
    }

    /// Extension that holds the belt taut at the measured chassis angle, 2^-24 m.
    pub fn taut_bus(&self) -> i32 {
        self.geometry.length(self.theta).to_bits() >> 4
    }

    /// Extension at which the belt is slack at any chassis angle and the reference switch opens, 2^-24 m.
    pub fn released_bus(&self) -> i32 {
        self.released_bus
    }

    pub fn joint_known(&self) -> bool {
        self.joint_known
    }

    pub fn screw_known(&self) -> bool {
        self.screw_known
    }

    pub fn margins(&self) -> &Margins {
        &self.margins
    }

    /// Forward speed that is passed on, m/s.
    pub fn forward_speed(&self) -> f32 {
        self.forward.velocity
    }

    /// Share of the asked speed that the filter leaves, percent.
    pub fn share_percent(&self) -> u8 {
        clamp(self.share * 100.0, 0.0, 100.0) as u8
    }

    /// Distance by the belts' encoders, um.
    pub fn odometry_um(&self) -> i32 {
        self.odometry_whole_um
    }
}
