//! Section of a scenario file for B2P2: the values that its paper does not give, their bounds, and
//! the parameters of the plant.

use super::nodes;
use super::plant::{self, B2p2Parameters};
use crate::bounds::{Problem, contradiction, within};
use crate::robots::payload::Payload;
use crate::robots::{Conditions, NodeSpec, Posture, Robot, Section};
use crate::world::Plant;
use crate::world::terrain::Terrain;
use serde::{Deserialize, Serialize};

fn usual() -> f64 {
    1.0
}

/// Values that the paper does not give; docs/plant.md lists the nominal ones and the reasons for
/// them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct B2p2 {
    /// Belt length `K` without the arcs around the pulleys.
    pub k_m: f64,
    /// Radius of the three pulleys, belt included.
    pub pulley_radius_m: f64,
    /// Height of body 1's centre of mass above the line through axles 1 and 2.
    #[serde(default)]
    pub com_offset_m: f64,
    /// Distance by which the belts can rise between pulleys before they meet the guide plates.
    #[serde(default)]
    pub guide_clearance_m: f64,
    /// Noise of the sensors on the body, as a multiple of the nominal noise.
    #[serde(default = "usual")]
    pub sensor_noise: f64,
    /// Load in addition to the robot's own mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
}

impl B2p2 {
    /// The nominal values, as in docs/plant.md.
    pub fn nominal() -> Self {
        Self {
            k_m: 1.232,
            pulley_radius_m: 0.05,
            com_offset_m: 0.0,
            guide_clearance_m: 0.0,
            sensor_noise: 1.0,
            payload: None,
        }
    }

    /// Parameters of the robot itself, without payload and ground.
    fn alone(&self) -> B2p2Parameters {
        let mut parameters = B2p2Parameters {
            pulley_radius: self.pulley_radius_m,
            body_1_com_height: self.com_offset_m,
            guide_clearance: self.guide_clearance_m,
            ..B2p2Parameters::with_track_constant(self.k_m)
        };
        let sensors = &mut parameters.body_sensors;
        for noise in [
            &mut sensors.tilt_force,
            &mut sensors.specific_force,
            &mut sensors.angular_rate,
            &mut sensors.magnetic_field,
        ] {
            *noise *= self.sensor_noise;
        }
        parameters
    }

    /// Parameters of the plant, on ground with this coefficient of friction.
    pub fn parameters(&self, friction: f64) -> B2p2Parameters {
        B2p2Parameters {
            friction,
            // A robot that was moved while off: no node knows the position of its axle, and the
            // belt is slightly slack.
            initial_theta: 0.1,
            initial_extension_error: -0.003,
            payload: self.payload.as_ref().map(Payload::load),
            ..self.alone()
        }
    }
}

impl Default for Robot {
    /// B2P2 with its nominal values.
    fn default() -> Self {
        Self::B2p2(B2p2::nominal())
    }
}

impl Robot {
    /// The default robot with this level of sensor noise.
    pub fn nominal(sensor_noise: f64) -> Self {
        Self::B2p2(B2p2 {
            sensor_noise,
            ..B2p2::nominal()
        })
    }

    /// Returns B2P2's section; `None` for another robot.
    pub fn b2p2(&self) -> Option<&B2p2> {
        match self {
            Self::B2p2(section) => Some(section),
            _ => None,
        }
    }

    /// Returns B2P2's section. Replaces another robot with B2P2 and its nominal values.
    pub fn b2p2_mut(&mut self) -> &mut B2p2 {
        if self.b2p2().is_none() {
            *self = Self::default();
        }
        match self {
            Self::B2p2(section) => section,
            _ => unreachable!("it was replaced"),
        }
    }
}

impl Section for B2p2 {
    fn check(&self, conditions: &Conditions) -> Result<(), Problem> {
        let B2p2Parameters { l1, l2, .. } = B2p2Parameters::nominal();
        // From `L1 + 2 L2` on, the extension is never negative; from `K / L1` = 2.4 on, the screw's
        // stated errors hold.
        let least_k = f64::max(l1 + 2.0 * l2, 2.4 * l1);
        within(
            "robot.b2p2.k_m",
            self.k_m,
            least_k,
            2.0,
            "m (the minimum is L1 + 2 L2 and 2.4 L1 of the robot)",
        )?;
        within(
            "robot.b2p2.pulley_radius_m",
            self.pulley_radius_m,
            0.01,
            0.15,
            "m",
        )?;
        within("robot.b2p2.com_offset_m", self.com_offset_m, -0.2, 0.2, "m")?;
        within(
            "robot.b2p2.guide_clearance_m",
            self.guide_clearance_m,
            0.0,
            0.8 * self.pulley_radius_m,
            "m (the maximum is 0.8 of the pulley radius)",
        )?;
        within("robot.b2p2.sensor_noise", self.sensor_noise, 0.0, 100.0, "")?;
        if let Some(payload) = &self.payload {
            payload.check("robot.b2p2.payload", conditions.duration_s)?;
        }
        match conditions.terrain {
            Terrain::Hillside { .. } => {
                contradiction("terrain", "is a hillside, which B2P2's plant has not")
            }
            _ => Ok(()),
        }
    }

    fn payload_mut(&mut self) -> Option<&mut Payload> {
        self.payload.as_mut()
    }

    /// Position of the robot's foremost point at the start, m, for any chassis angle: with a
    /// straight chassis, axle 3 is at `(K + L1) / 2`.
    fn front_m(&self) -> f64 {
        f64::midpoint(self.k_m, self.alone().l1) + self.pulley_radius_m
    }

    fn posture(&self) -> Posture {
        Posture::ChassisAngle {
            travel: B2p2Parameters::nominal().joint_travel,
        }
    }

    fn nodes(&self, conditions: &Conditions) -> Vec<NodeSpec> {
        nodes::nodes(self, conditions)
    }

    fn plant(&self, conditions: &Conditions) -> Box<dyn Plant> {
        let parameters = self.parameters(conditions.friction);
        let ground = conditions.terrain.ground();
        Box::new(plant::B2p2::new(&parameters, &ground, conditions.seed))
    }
}
