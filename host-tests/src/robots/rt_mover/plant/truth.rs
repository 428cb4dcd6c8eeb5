//! Ground truth of RT-Mover, as recorded in a run.

use super::margin::margin;
use super::robot::SEAT;
use super::{MOTORS, RtMover};
use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::RigidBody;
use tautrack::constants::GRAVITY_F64;

/// Names of channels of [`crate::world::truth::Truth`] that only this robot has, one per wheel:
/// upward force of the ground, and height of the wheel's lowest point.
const LOADS: [&str; 4] = [
    "front_left_load_n",
    "front_right_load_n",
    "rear_left_load_n",
    "rear_right_load_n",
];
const HEIGHTS: [&str; 4] = [
    "front_left_height_m",
    "front_right_height_m",
    "rear_left_height_m",
    "rear_right_height_m",
];
/// Channel names of the distance of each wheel's lowest point ahead of the robot's start.
const PLACES: [&str; 4] = [
    "front_left_x_m",
    "front_right_x_m",
    "rear_left_x_m",
    "rear_right_x_m",
];
/// Channel names of the shaft angles; their motors follow those of the wheels.
const SHAFTS: [&str; 5] = [
    "front_steering_rad",
    "rear_steering_rad",
    "front_roll_rad",
    "rear_roll_rad",
    "pitch_shaft_rad",
];
/// Channel name of the support margin: the minimum distance of the centre of gravity from the edges
/// between the wheels that carry load. It is absent in free flight.
const MARGIN: &str = "support_margin_m";
/// Order of the wheels around the robot, counter-clockwise seen from above.
const AROUND: [usize; 4] = [3, 1, 0, 2];

/// Tilt of the seat from which the robot counts as toppled, rad.
const TURNED_OVER: f64 = 1.0;
/// Number of steps for which a wheel that carried force counts as standing. Single contacts flicker
/// from step to step.
const WINDOW: u64 = 50;
/// Minimum force of a wheel that supports the robot, N.
const LEAST_LOAD: f64 = 0.1;

impl RtMover {
    /// Lowest points of the wheels in world axes, m.
    pub fn wheels(&self) -> [[f64; 3]; 4] {
        self.lowest.map(|point| point.to_array())
    }

    /// Upward force of the ground on each wheel in the last step, N.
    pub fn loads(&self) -> [f64; 4] {
        self.loads
    }

    /// Angles of all joints, in the order of the motors, rad; those of the wheels from -pi to pi.
    pub fn joints(&self) -> [f64; MOTORS] {
        self.robot.shafts.map(|shaft| shaft.angle(&self.world))
    }

    /// Weight of the robot with its load, N.
    pub fn weight(&self) -> f64 {
        let load = self.payload.map_or(0.0, |load| load.mass);
        (self.parameters.masses.total() + load) * GRAVITY_F64
    }

    /// Updates the ground truth after a step.
    pub(super) fn observe(&mut self) {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        let m = &self.parameters.masses;
        let seat_centre = Vector::new(m.seat_forward, 0.0, m.seat_height);
        let masses = [
            m.body,
            m.seat,
            0.5 * m.arm,
            0.5 * m.arm,
            0.5 * m.arm,
            0.5 * m.arm,
            m.wheel,
            m.wheel,
            m.wheel,
            m.wheel,
        ];
        let mut moment = Vector::ZERO;
        for (index, (body, mass)) in bodies.iter().zip(masses).enumerate() {
            let local = if index == SEAT {
                seat_centre
            } else {
                Vector::ZERO
            };
            moment += body.position().transform_point(local) * mass;
        }
        let tilt = |body: &RigidBody| {
            let [forward, left] =
                [Vector::X, Vector::Y].map(|axis| body.position().rotation * axis);
            let level = libm::sqrt(left.x * left.x + left.y * left.y);
            let ahead = libm::sqrt(forward.x * forward.x + forward.y * forward.y);
            [libm::atan2(forward.z, ahead), libm::atan2(left.z, level)]
        };
        let load = self.payload.map_or(0.0, |load| {
            let place = Vector::from_array(load.place);
            moment += bodies[SEAT].position().transform_point(place) * load.mass;
            load.mass
        });
        let [forward, left] =
            [Vector::X, Vector::Y].map(|axis| bodies[SEAT].position().rotation * axis);
        let points = self.robot.points(&self.world, &self.parameters);
        self.lowest = self.robot.lowest_points(&self.world, &self.parameters);
        self.loads = self.robot.loads(&self.world);
        let shafts = self.robot.shafts.map(|shaft| shaft.angle(&self.world));
        let truth = &mut self.truth;
        [truth.pitch, truth.roll] = tilt(bodies[SEAT]);
        truth.pitch_rate = -bodies[SEAT].angvel().dot(left);
        truth.yaw = libm::atan2(forward.y, forward.x);
        truth.axle_1 = (0.5 * (points[2] + points[3])).to_array();
        truth.cog = (moment / (m.total() + load)).to_array();
        truth.ground_speed = bodies[0].linvel().dot(forward);
        truth.contacts.clear();
        for (until, load) in self.standing_until.iter_mut().zip(self.loads) {
            if load > LEAST_LOAD {
                *until = self.step + WINDOW;
            }
        }
        let stands = self.standing_until.map(|until| until > self.step);
        for (wheel, (place, load)) in self.lowest.iter().zip(self.loads).enumerate() {
            truth.channels.insert(LOADS[wheel], load);
            truth.channels.insert(HEIGHTS[wheel], place.z);
            truth.channels.insert(PLACES[wheel], place.x);
            if stands[wheel] {
                truth.contacts.push(place.to_array());
            }
        }
        for (name, angle) in SHAFTS.into_iter().zip(&shafts[4..]) {
            truth.channels.insert(name, *angle);
        }
        let standing: Vec<_> = AROUND
            .into_iter()
            .filter(|wheel| stands[*wheel])
            .map(|wheel| self.lowest[wheel])
            .collect();
        match margin(&standing, Vector::from_array(truth.cog)) {
            Some(margin) => truth.channels.insert(MARGIN, margin),
            None => truth.channels.remove(MARGIN),
        };
        truth.points.clear();
        truth.points.extend(points.iter().map(Vector::to_array));
        truth.toppled |= truth.pitch.abs() > TURNED_OVER || truth.roll.abs() > TURNED_OVER;
    }
}
