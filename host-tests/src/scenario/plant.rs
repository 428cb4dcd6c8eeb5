//! From a scenario's values to the plant's.

use super::{Description, Payload, Robot, Terrain};
use crate::plant::b2p2::{B2p2Parameters, Payload as Load};
use crate::plant::terrain::{Stairs, Terrain as Ground};

impl Description {
    /// The robot and its ground contact, as the plant takes them.
    pub fn parameters(&self) -> B2p2Parameters {
        B2p2Parameters {
            friction: self.friction,
            // As after a night on the shelf: no node knows where its axle is, and the belt hangs a little.
            initial_theta: 0.1,
            initial_extension_error: -0.003,
            payload: self.robot.payload.as_ref().map(Payload::plant),
            ..self.robot.parameters()
        }
    }
}

impl Payload {
    /// As the plants take it.
    pub(super) fn plant(&self) -> Load {
        Load {
            mass: self.mass_kg,
            place: self.place_m,
            from_time_s: self.from_s,
        }
    }
}

impl Robot {
    /// The robot alone, without load and ground.
    pub(super) fn parameters(&self) -> B2p2Parameters {
        let mut parameters = B2p2Parameters {
            pulley_radius: self.pulley_radius_m,
            body_1_com_height: self.com_offset_m,
            ..B2p2Parameters::with_track_constant(self.k_m)
        };
        let sensors = &mut parameters.body_sensors;
        for [noise, _] in [
            &mut sensors.inclination,
            &mut sensors.specific_force,
            &mut sensors.angular_rate,
            &mut sensors.magnetic_field,
        ] {
            *noise *= self.sensor_noise;
        }
        parameters
    }
}

impl Terrain {
    /// The ground as the plant takes it.
    pub fn ground(&self) -> Ground {
        match *self {
            Self::Flat => Ground::Flat,
            Self::Stairs {
                riser_m,
                run_m,
                count,
                width_m,
                first_nose_m,
                landing_m,
                down,
            } => Ground::Stairs(Stairs {
                riser: riser_m,
                run: run_m,
                count: count as usize,
                width: width_m,
                first_nose_x: first_nose_m,
                landing: landing_m,
                down,
            }),
            Self::Curb {
                height_m,
                nose_m,
                depth_m,
            } => Ground::Curb {
                height: height_m,
                front_x: nose_m,
                depth: depth_m,
            },
            Self::Ramp {
                angle_deg,
                foot_m,
                length_m,
            } => Ground::Ramp {
                pitch: angle_deg.to_radians(),
                foot_x: foot_m,
                length: length_m,
            },
            Self::Slope {
                angle_deg,
                side_deg,
            } => Ground::Incline {
                pitch: angle_deg.to_radians(),
                roll: side_deg.to_radians(),
            },
        }
    }

    /// x of the last nose, beyond which the landing lies (of stairs that lead down, the ground); `None` on flat ground and slopes.
    pub fn last_nose_m(&self) -> Option<f64> {
        match self.ground() {
            Ground::Stairs(stairs) => Some(stairs.last_nose_x()),
            Ground::Curb { front_x, .. } => Some(front_x),
            Ground::Flat | Ground::Ramp { .. } | Ground::Incline { .. } => None,
        }
    }
}
