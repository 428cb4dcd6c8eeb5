//! Readings of the sensors of Hylos' sixteen motors.

use super::robot::Robot;
use super::{HIP, Hylos, KNEE, MOTORS, STEERING, WHEEL};
use rapier3d_f64::prelude::JointAxis;
use tautrack::link::Sensors;
use tautrack::robots::hylos::parameters::{HIP_RANGE, KNEE_RANGE, STEERING_RANGE};
use tautrack::sensors::Switches;

impl Hylos {
    /// Returns the load torque at the shaft and the switches of motor number `motor`. The home
    /// switch of a joint changes at the joint's angle at power-up.
    pub(super) fn shaft_sensors(&self, motor: usize) -> Sensors {
        assert!(
            motor < MOTORS,
            "Hylos has {MOTORS} motors, there is no motor {motor}"
        );
        let p = &self.parameters;
        let (leg, kind) = (motor / 4, motor % 4);
        let (joint, gear) = (self.robot.legs[leg], &self.gears[leg]);
        let torque = match kind {
            HIP | KNEE => gear[kind].shaft_torque(self.leg_torques[leg][kind], 0.0),
            STEERING => {
                gear[kind].shaft_torque(Robot::passed_on(&self.world, joint, JointAxis::AngX), 0.0)
            }
            _ if self.driven[leg] => {
                Robot::passed_on(&self.world, self.robot.axles[leg], JointAxis::AngX)
            }
            _ => 0.0,
        };
        let detail = &self.detail;
        let (place, range, reference) = match kind {
            HIP => (detail.legs[leg][0], HIP_RANGE, p.initial_leg[0]),
            KNEE => (detail.legs[leg][1], KNEE_RANGE, p.initial_leg[1]),
            _ => (detail.steering[leg], STEERING_RANGE, 0.0),
        };
        let switches = if kind == WHEEL {
            Switches::default()
        } else {
            Switches {
                home: place <= reference,
                positive_limit: place >= range[1],
                negative_limit: place <= range[0],
            }
        };
        Sensors {
            encoder_frozen: false,
            shaft_torque: torque as f32,
            supply_voltage: p.supply_voltage as f32,
            switches,
            body: None,
        }
    }
}
