//! What the sensors of the nine motors read.

use super::RtMover;
use crate::world::physics::{DT, SUBSTEPS};
use rapier3d_f64::prelude::JointAxis;
use tautrack::link::Sensors;
use tautrack::sensors::Switches;

/// Motors before this one turn wheels.
const WHEELS: usize = 4;
/// Angle from which a shaft's home switch is closed, rad: close to where it stands on level
/// ground, so that no wheel leaves it for that.
pub const SWITCH: f64 = 0.01;

impl RtMover {
    /// Torque at the shaft and the home switch of a motor.
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
