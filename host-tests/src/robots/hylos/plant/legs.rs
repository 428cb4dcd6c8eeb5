//! Couples the gears of a leg to its joint in the physics engine, and computes the load torques of
//! the gears.

use super::robot::{self, Robot};
use super::{HIP, Hylos, HylosParameters, KNEE, STEERING, WHEEL};
use crate::world::gear::Drive;
use rapier3d_f64::prelude::*;
use tautrack::link::Shaft;

impl Hylos {
    /// Drives the joints of a leg with its four shafts; `None` means that the node is dead.
    pub(super) fn drive_leg(&mut self, leg: usize, shafts: &[Option<Shaft>; 4]) {
        let p = &self.parameters;
        let joints = p.joints(self.robot.reach(&self.world, p, leg));
        let steering = self.robot.steering(&self.world, leg);
        let [hip, knee, steer] = &mut self.gears[leg];
        let hip = hip.drive(shafts[HIP].as_ref(), joints[0]);
        let knee = knee.drive(shafts[KNEE].as_ref(), joints[1]);
        let steer = steer.drive(shafts[STEERING].as_ref(), steering);
        let wheel = shafts[WHEEL].as_ref();
        self.driven[leg] = wheel.is_some();

        let [reach, below] = p.reach([hip.place, knee.place]);
        let [[hip_x, hip_z], [knee_x, knee_z]] = columns(p, [hip.place, knee.place]);
        let slide = |place: f64, speed: f64| Drive {
            place,
            speed,
            stiffness: p.leg_gear,
            limit: f64::MAX,
        };
        let front = robot::forward(leg);
        let forward = slide(
            front * reach,
            front * (hip_x * hip.speed + knee_x * knee.speed),
        );
        let upward = slide(-below, hip_z * hip.speed + knee_z * knee.speed);
        let roll = Drive {
            place: 0.0,
            speed: wheel.map_or(0.0, |shaft| f64::from(shaft.velocity)),
            stiffness: [0.0, p.wheel_gear],
            limit: wheel.map_or(p.dead_friction[1], |_| f64::MAX),
        };
        for (joint, axis, drive) in [
            (self.robot.legs[leg], JointAxis::LinX, upward),
            (self.robot.legs[leg], JointAxis::LinY, forward),
            (self.robot.legs[leg], JointAxis::AngX, steer),
            (self.robot.axles[leg], JointAxis::AngX, roll),
        ] {
            // Always present: the handle is valid as long as the world exists.
            if let Some(joint) = self.world.impulse_joints.get_mut(joint, false) {
                let [stiffness, damping] = drive.stiffness;
                joint
                    .data
                    .set_motor(axis, drive.place, drive.speed, stiffness, damping);
                joint.data.set_motor_max_force(axis, drive.limit);
            }
        }
    }

    /// Load torques of hip and knee, N m, computed from the force at the wheel by virtual work.
    pub(super) fn torques(&self, leg: usize) -> [f64; 2] {
        let joint = self.robot.legs[leg];
        let upward = Robot::passed_on(&self.world, joint, JointAxis::LinX);
        let outward = robot::forward(leg) * Robot::passed_on(&self.world, joint, JointAxis::LinY);
        let p = &self.parameters;
        let joints = p.joints(self.robot.reach(&self.world, p, leg));
        columns(p, joints).map(|[x, z]| x * outward + z * upward)
    }
}

/// Columns of the leg's Jacobian: velocity of the wheel's centre per rate of the hip and per rate
/// of the knee, forward (backward at the rear) and up, m.
fn columns(p: &HylosParameters, [hip, knee]: [f64; 2]) -> [[f64; 2]; 2] {
    let [thigh, shank] = p.measures.leg;
    let (sine, cosine) = (libm::sin(hip + knee), libm::cos(hip + knee));
    let by_knee = [-shank * sine, -shank * cosine];
    [
        [
            by_knee[0] - thigh * libm::sin(hip),
            by_knee[1] - thigh * libm::cos(hip),
        ],
        by_knee,
    ]
}
