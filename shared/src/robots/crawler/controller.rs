//! The crawler's body controller: odometry with slip, the path, and the speeds of the two sprockets.

use super::kinematics::{BodyVelocity, Kinematics};
use super::parameters::{Dimensions, Ground, Masses, ParametersError, within};
use super::path::{PathFollower, Pose, wrapped};
use super::slip::{Slip, SlipModel};
use crate::math::{Scalar, limit, max, min};

/// What the controller is told about its robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Configuration {
    /// Lengths and gear.
    pub dimensions: Dimensions,
    /// Masses, with the payload.
    pub body: Masses,
    /// The soil that slip is computed from.
    pub ground: Ground,
    /// Make up for slip; else commands and odometry go without.
    pub compensates_slip: bool,
    /// Most that a sprocket may turn, rad/s.
    pub sprocket_limit: f64,
}

/// What is known about the robot's motion.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Observation {
    /// Rates of left and right sprocket, rad/s.
    pub sprockets: [f32; 2],
    /// Heading, rad, counter-clockwise; less than 8000.
    pub heading: f32,
    /// Pitch of the body (nose up) and roll (left side up), rad.
    pub pitch: f32,
    /// See `pitch`.
    pub roll: f32,
    /// Forward speed over the ground, m/s, where something measured it since the observation before.
    pub measured_speed: Option<f32>,
}

/// What the sprockets shall do.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SprocketCommand {
    /// Rates of left and right sprocket, rad/s.
    pub sprockets: [f32; 2],
    /// The configured soil does not bear the robot on this slope.
    pub beyond_traction: bool,
}

/// Body controller.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Controller {
    kinematics: Kinematics<f32>,
    slip_model: SlipModel,
    compensates_slip: bool,
    sprocket_limit: f32,
    slip: Slip,
    /// Time since a speed was measured, s, and way of the belts in it, m.
    unmeasured: f32,
    way: [f32; 2],
    pose: Pose,
    velocity: BodyVelocity<f32>,
    path: PathFollower,
}

impl Controller {
    /// A controller for this robot, at the origin.
    ///
    /// # Errors
    /// The first value out of range: those of [`Kinematics::new`] and [`SlipModel::new`], and a sprocket limit outside 0.01 to 1000 rad/s.
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

    /// Takes in what the last `period` seconds brought: slip, then the way made with it. An observation that cannot be true is left out.
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
        // The way made is that along the heading, and what the robot drifts beside it.
        let drift = self.slip.drift(self.velocity.forward);
        let (_, along) = Scalar::sin_cos(drift);
        let turn = wrapped(heading - self.pose.heading);
        let distance = self.velocity.forward * period / along;
        self.pose = Pose {
            heading,
            ..self.pose.moved(distance, drift, turn)
        };
    }

    /// Sprocket rates that move the robot as `asked` along its path. Where one would be beyond its limit, both are taken back in
    /// proportion: slower, on the same path. What is asked for in no number is a stop.
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
        // Which way a track goes says which way its slip counts.
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

    /// Where the robot is by its odometry.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// How the robot moves by its encoders and the estimated slip.
    pub fn velocity(&self) -> BodyVelocity<f32> {
        self.velocity
    }

    /// Estimated slip.
    pub fn slip(&self) -> Slip {
        self.slip
    }
}

const MOST_SLIP: f32 = Kinematics::<f32>::MAXIMUM_SLIP as f32;

/// A measured speed stands for no more time than this, s.
const LONGEST_UNMEASURED: f32 = 0.5;

/// No motion.
pub const STANDING: BodyVelocity<f32> = BodyVelocity {
    forward: 0.0,
    yaw_rate: 0.0,
};

/// A value (rad, rad/s or m/s) that a crawler can have.
fn believable(value: f32) -> bool {
    value.abs() <= 1_000.0
}
