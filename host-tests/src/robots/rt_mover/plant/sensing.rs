//! Readings of the sensors of RT-Mover's nine motors.

use super::RtMover;
use crate::world::physics::{DT, SUBSTEPS};
use rapier3d_f64::prelude::JointAxis;
use tautrack::link::Sensors;
use tautrack::sensors::Switches;

/// Number of wheel motors; they come first.
const WHEELS: usize = 4;
/// Angle from which a shaft's home switch is closed, rad. It is close to the angle on level ground,
/// so that homing lifts no wheel off the ground.
pub const SWITCH: f64 = 0.01;

impl RtMover {
    /// Returns the load torque at the shaft and the home switch of motor number `motor`.
    pub(super) fn shaft_sensors(&self, motor: usize) -> Sensors {
        let joint = self
            .world
            .impulse_joints
            .get(self.robot.shafts[motor].handle);
        let passed_on = joint
            .and_then(|joint| joint.data.motor(JointAxis::AngX))
            .map_or(0.0, |motor| -motor.impulse * SUBSTEPS as f64 / DT);
        let angle = self.robot.shafts[motor].angle(&self.world);
        Sensors {
            switches: Switches {
                home: motor >= WHEELS && angle >= SWITCH,
                ..Switches::default()
            },
            shaft_torque: self.gears[motor].shaft_torque(passed_on, self.rates[motor]) as f32,
            supply_voltage: self.parameters.supply_voltage as f32,
            ..Sensors::default()
        }
    }
}
