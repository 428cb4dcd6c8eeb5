//! What the physics knows of a robot after a step, and how the robot is drawn.

use serde::Serialize;
use std::collections::BTreeMap;

/// State of a plant; what a robot does not have is 0. World axes: x towards the stairs, y left, z up; metres and radians.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Truth {
    /// Centre of axle 1, the rear one.
    pub axle_1: [f64; 3],
    /// Pitch, nose up positive.
    pub pitch: f64,
    /// Roll, left side up positive.
    pub roll: f64,
    /// Heading, counter-clockwise from above.
    pub yaw: f64,
    /// Pitch rate, rad/s.
    pub pitch_rate: f64,
    /// Chassis angle, front up positive.
    pub theta: f64,
    /// Extension `L3` of the screw.
    pub extension: f64,
    /// `L + L2 + L3 - K`: positive strains the belt, negative leaves it slack.
    pub tension_error: f64,
    /// Centre of gravity of the robot with its payload.
    pub cog: [f64; 3],
    /// Speed of the robot along its heading, m/s.
    pub ground_speed: f64,
    /// Speed of the left and right belt, m/s.
    pub belt_speed: [f64; 2],
    /// Path that the belts slipped since the start, mean of both sides.
    pub slip: f64,
    /// Points that carried force within the last 50 ms.
    pub contacts: Vec<[f64; 3]>,
    /// Horizontal distance from the rearmost of these to the centre of gravity, along the heading; absent in free flight.
    pub backward_margin: Option<f64>,
    /// Horizontal distance from the centre of gravity to the foremost of these.
    pub forward_margin: Option<f64>,
    /// Turned over backward, forward or sideways; stays set.
    pub toppled: bool,
    /// What only this robot has, by name; the unit is in the name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<&'static str, f64>,
    /// Places that its picture is drawn through ([`Sketch`]), in a fixed order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 3]>,
}

/// How a robot is drawn through [`Truth::points`]; the numbers count those.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sketch {
    /// Wheels: centre and radius, m.
    pub circles: Vec<(usize, f64)>,
    /// Lines from point to point.
    pub lines: Vec<Vec<usize>>,
}

/// Pose of a body in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyPose {
    /// Origin, m.
    pub place: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

/// Name and shape of a body, in its own axes: x forward, y left, z up; metres.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShape {
    /// Name of its coordinate frame.
    pub name: &'static str,
    /// What it consists of.
    pub parts: Vec<Part>,
}

/// Part of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A box along the body's axes.
    Box {
        /// Its centre.
        centre: [f64; 3],
        /// Its edges.
        size: [f64; 3],
    },
    /// A disc that turns about the body's y axis.
    Wheel {
        /// Its centre.
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
        /// Its width.
        width: f64,
    },
}
