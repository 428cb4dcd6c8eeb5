//! Readings of the sensors of B2P2's four motors.

use super::B2p2;
use crate::world::physics::{DT, SUBSTEPS};
use rapier3d_f64::prelude::*;
use tautrack::link::Sensors;
use tautrack::sensors::Switches;

impl B2p2 {
    /// Returns the load torque at the shaft and the switches of motor number `motor`.
    pub(super) fn shaft_sensors(&self, motor: usize) -> Sensors {
        let p = &self.parameters;
        let [theta, _] = self.robot.chassis_joint(&self.world);
        let [extension, _] = self.robot.extension(&self.world, p);
        let limits = |place: f64, [low, high]: [f64; 2], home: bool| Switches {
            home,
            positive_limit: place >= high,
            negative_limit: place <= low,
        };
        let (torque, switches) = match motor {
            0 | 1 => (
                self.sprockets[motor].shaft_torque(p.pulley_radius),
                Switches::default(),
            ),
            2 => {
                let switches = limits(theta, p.joint_travel, theta >= p.joint_home);
                (
                    self.joint.shaft_torque(
                        self.passed_on(self.robot.joint, JointAxis::AngX),
                        self.rates[0],
                    ),
                    switches,
                )
            }
            3 => {
                let switches = limits(extension, p.screw_travel, extension <= p.screw_home);
                (
                    self.screw.shaft_torque(
                        self.passed_on(self.robot.screw, JointAxis::LinX),
                        self.rates[1],
                    ),
                    switches,
                )
            }
            _ => panic!("B2P2 has four motors, there is no motor {motor}"),
        };
        Sensors {
            encoder_frozen: false,
            shaft_torque: torque as f32,
            supply_voltage: p.supply_voltage as f32,
            switches,
            body: None,
        }
    }

    /// Force or torque that a gear transmitted to its joint in the last substep, N or N m.
    ///
    /// It is computed from the engine's impulse, not from the spring law: the engine iterates only
    /// a few times, after which only the impulse balances the load.
    fn passed_on(&self, handle: ImpulseJointHandle, axis: JointAxis) -> f64 {
        let motor = self
            .world
            .impulse_joints
            .get(handle)
            .and_then(|joint| joint.data.motor(axis));
        motor.map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT)
    }
}
