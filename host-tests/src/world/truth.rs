//! Ground truth of a robot after a step, and the description of its drawing.

use serde::Serialize;
use std::collections::BTreeMap;

/// Ground truth of a plant, in m and rad; values that a robot does not have are 0. World axes: x
/// towards the stairs, y left, z up.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Truth {
    /// Centre of axle 1, the rear axle.
    pub axle_1: [f64; 3],
    /// Pitch, nose up positive.
    pub pitch: f64,
    /// Roll, left side up positive.
    pub roll: f64,
    /// Heading, counter-clockwise seen from above.
    pub yaw: f64,
    /// Pitch rate, rad/s.
    pub pitch_rate: f64,
    /// Chassis angle, front up positive.
    pub theta: f64,
    /// Extension `L3` of the screw.
    pub extension: f64,
    /// `L + L2 + L3 - K`: positive if the belt is strained, negative if it is slack.
    pub tension_error: f64,
    /// Centre of gravity of the robot with its payload.
    pub cog: [f64; 3],
    /// Speed of the robot along its heading, m/s.
    pub ground_speed: f64,
    /// Speed of the left and right belt, m/s.
    pub belt_speed: [f64; 2],
    /// Distance that the belts have slipped since the start, mean of both sides.
    pub slip: f64,
    /// Contact points that carried force within the last 50 ms.
    pub contacts: Vec<[f64; 3]>,
    /// Horizontal distance from the rearmost contact point to the centre of gravity, along the
    /// heading; absent in free flight.
    pub backward_margin: Option<f64>,
    /// Horizontal distance from the centre of gravity to the foremost contact point; absent in free
    /// flight.
    pub forward_margin: Option<f64>,
    /// Whether the robot has toppled backward, forward or sideways; stays set.
    pub toppled: bool,
    /// What has come off the robot, which ends a run; stays set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub came_off: Option<&'static str>,
    /// Values that only this robot has, by name; the name contains the unit.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<&'static str, f64>,
    /// Points through which the robot is drawn: those of its [`Sketch`] in a fixed order, or the
    /// ends of the straight pieces of B2P2's left belt, in the order of the belt.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 3]>,
}

/// Drawing of a robot through [`Truth::points`]; the numbers are indices of these points.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sketch {
    /// Wheels: centre and radius, m.
    pub circles: Vec<(usize, f64)>,
    /// Lines, each through several points.
    pub lines: Vec<Vec<usize>>,
}

/// A closed belt as it lies.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Strip {
    /// Width, m.
    pub width: f64,
    /// Points of its middle line in world axes, m.
    pub points: Vec<[f64; 3]>,
}

/// Pose of a body in world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyPose {
    /// Origin, m.
    pub place: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

/// Name and shape of a body in its own axes (x forward, y left, z up), m.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShape {
    /// Name of the body's coordinate frame.
    pub name: &'static str,
    /// Parts of the body.
    pub parts: Vec<Part>,
}

/// Part of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// Box along the body's axes.
    Box {
        /// Centre of the box.
        centre: [f64; 3],
        /// Lengths of the box along the axes.
        size: [f64; 3],
    },
    /// Wheel that turns about the body's y axis.
    Wheel {
        /// Centre of the wheel.
        centre: [f64; 3],
        /// Radius of the wheel.
        radius: f64,
        /// Width of the wheel.
        width: f64,
    },
}
