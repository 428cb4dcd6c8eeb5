//! Controls the crawler's body: computes odometry with slip, follows a path, and commands the rates
//! of the two sprockets.

use super::kinematics::{BodyVelocity, Kinematics};
use super::parameters::{Dimensions, Ground, Masses, ParametersError, within};
use super::path::{PathFollower, Pose, wrapped};
use super::slip::{Slip, SlipModel};
use crate::math::{Scalar, limit, max, min};

/// Configuration of the controller for its robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Configuration {
    /// Lengths and gear.
    pub dimensions: Dimensions,
    /// Masses, with the payload.
    pub body: Masses,
    /// Soil from which the slip is computed.
    pub ground: Ground,
    /// Whether commands and odometry compensate slip; otherwise both ignore it.
    pub compensates_slip: bool,
    /// Largest rate of a sprocket, rad/s.
    pub sprocket_limit: f64,
}

/// Measurements of the robot's motion.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Observation {
    /// Rates of the left and the right sprocket, rad/s.
    pub sprockets: [f32; 2],
    /// Heading, rad, counter-clockwise; its magnitude is below 8000.
    pub heading: f32,
    /// Pitch of the body (nose up), rad.
    pub pitch: f32,
    /// Roll of the body (left side up), rad.
    pub roll: f32,
    /// Forward speed over ground, m/s, if one was measured since the previous observation.
    pub measured_speed: Option<f32>,
}

/// Command for the sprockets.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SprocketCommand {
    /// Rates of the left and the right sprocket, rad/s.
    pub sprockets: [f32; 2],
    /// Whether the configured soil cannot carry the robot on this slope.
    pub beyond_traction: bool,
}

/// Body controller of the crawler.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Controller {
    kinematics: Kinematics<f32>,
    slip_model: SlipModel,
    compensates_slip: bool,
    sprocket_limit: f32,
    slip: Slip,
    /// Time since the last measured speed, s, and distance that each belt has travelled in it, m.
    unmeasured: f32,
    way: [f32; 2],
    pose: Pose,
    velocity: BodyVelocity<f32>,
    path: PathFollower,
}

impl Controller {
    /// Creates a controller for this robot, at the origin.
    ///
    /// # Errors
    /// The first value out of range: those of [`Kinematics::new`] and [`SlipModel::new`], and a
    /// sprocket limit outside 0.01 to 1000 rad/s.
    pub fn new(configuration: &Configuration) -> Result<Self, ParametersError> {
        let Configuration {
            dimensions,
            body,
            ground,
            compensates_slip,
            sprocket_limit,
        } = configuration;
        Ok(Self {
            kinematics: Kinematics::new(dimensions)?,
            slip_model: SlipModel::new(dimensions, body, ground)?,
            compensates_slip: *compensates_slip,
            sprocket_limit: within("sprocket limit", *sprocket_limit, [1e-2, 1e3])? as f32,
            slip: Slip::NONE,
            unmeasured: 0.0,
            way: [0.0; 2],
            pose: Pose::default(),
            velocity: STANDING,
            path: PathFollower::default(),
        })
    }

    /// Updates slip, velocity and pose with the motion of the last `period` s. Ignores an
    /// observation with a value that is NaN or above 1000.
    pub fn observe(&mut self, observation: &Observation, period: f32) {
        let Observation {
            sprockets: [left, right],
            heading,
            pitch,
            roll,
            ..
        } = *observation;
        if ![left, right, heading, pitch, roll]
            .into_iter()
            .all(believable)
        {
            return;
        }
        let belts = [left, right].map(|rate| rate * self.kinematics.radius());
        if self.compensates_slip {
            self.slip = self
                .slip_model
                .predict(pitch, roll, belts[0] + belts[1] < 0.0);
            self.unmeasured += period;
            self.way = [0, 1].map(|side: usize| self.way[side] + belts[side] * period);
            if let Some(speed) = observation.measured_speed {
                let mean = self.way.map(|way| way / self.unmeasured);
                let period = min(self.unmeasured, LONGEST_UNMEASURED);
                self.slip_model.learn(&self.slip, mean, speed, period);
                (self.unmeasured, self.way) = (0.0, [0.0; 2]);
            }
        }
        self.velocity = self
            .kinematics
            .body_velocity([left, right], self.slip.along(belts));
        // The forward speed is the component along the heading; the distance also contains the
        // drift across it.
        let drift = self.slip.drift(self.velocity.forward);
        let (_, along) = Scalar::sin_cos(drift);
        let turn = wrapped(heading - self.pose.heading);
        let distance = self.velocity.forward * period / along;
        self.pose = Pose {
            heading,
            ..self.pose.moved(distance, drift, turn)
        };
    }

    /// Sprocket rates that move the robot as `asked` along its path.
    ///
    /// If a rate exceeds its limit, both are reduced in proportion: the robot is slower, on the
    /// same path. A command that is NaN or above 1000 is a stop.
    pub fn command(&mut self, asked: BodyVelocity<f32>, period: f32) -> SprocketCommand {
        let asked = if believable(asked.forward) && believable(asked.yaw_rate) {
            asked
        } else {
            STANDING
        };
        let velocity = self
            .path
            .follow(asked, &self.pose, self.slip.drift(asked.forward), period);
        let level = self.kinematics.drive(velocity, [0.0; 2]);
        // The direction in which a track runs gives the sign of its slip.
        let slip = self.slip.along(level.sprockets);
        let drive = self
            .kinematics
            .drive(velocity, slip.map(|slip| limit(slip, MOST_SLIP)));
        let [left, right] = drive.sprockets;
        let fastest = max(left.abs(), right.abs());
        let share = if fastest <= self.sprocket_limit {
            1.0
        } else {
            self.sprocket_limit / fastest
        };
        SprocketCommand {
            // Rounding must not carry the faster one beyond its limit.
            sprockets: drive
                .sprockets
                .map(|rate| limit(rate * share, self.sprocket_limit)),
            beyond_traction: self.slip.beyond_traction,
        }
    }

    /// Pose by odometry.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Velocity from the encoders and the estimated slip.
    pub fn velocity(&self) -> BodyVelocity<f32> {
        self.velocity
    }

    /// Estimated slip.
    pub fn slip(&self) -> Slip {
        self.slip
    }
}

const MOST_SLIP: f32 = Kinematics::<f32>::MAXIMUM_SLIP as f32;

/// Longest time for which one measured speed counts, s.
const LONGEST_UNMEASURED: f32 = 0.5;

/// No motion.
pub const STANDING: BodyVelocity<f32> = BodyVelocity {
    forward: 0.0,
    yaw_rate: 0.0,
};

/// Whether the crawler can have this value (rad, rad/s or m/s).
fn believable(value: f32) -> bool {
    value.abs() <= 1_000.0
}
