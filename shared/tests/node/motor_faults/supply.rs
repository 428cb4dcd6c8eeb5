//! A supply that cannot take power back: its capacitor is all that absorbs the energy of braking.

use super::rig::{GEAR, PER_RADIAN, Rig, model};
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

/// Runs a drive on a battery of 24 V with a diode, and a capacitor, F. The energy that the bridge
/// returns follows from the balance of the rotor: what it loses, minus friction and copper.
struct Balance {
    capacitor: f64,
    voltage: f64,
    kinetic: f64,
}

impl Balance {
    /// Runs a control period. Returns whether a current in d burns energy.
    fn tick(&mut self, rig: &mut Rig) -> bool {
        rig.supply_voltage = self.voltage as f32;
        let outputs = rig.tick();
        if let Some(fault) = outputs.faults.strongest() {
            panic!("{} at {} V", fault.description().name, self.voltage);
        }
        let parameters = model(true);
        let velocity = f64::from(rig.motor.shaft().velocity);
        let inertia = f64::from(parameters.rotor_inertia) * GEAR * GEAR;
        let kinetic = 0.5 * inertia * velocity * velocity;
        let friction = f64::from(parameters.friction_torque) * velocity.abs() * 1e-3;
        let [a, b] = rig.motor.readings().currents.map(|code| {
            (f64::from(code) - 32_768.0) / 32_768.0 * f64::from(super::rig::STAGE.full_scale)
        });
        let copper = 0.3 * (a * a + b * b + (a + b) * (a + b)) * 1e-3;
        let returned = self.kinetic - kinetic - friction - copper;
        self.kinetic = kinetic;
        let energy = 0.5 * self.capacitor * self.voltage * self.voltage + returned;
        self.voltage = (2.0 * energy / self.capacitor).sqrt().max(24.0);
        matches!(outputs.bridge, BridgeDemand::Braking { .. })
    }
}

/// Brakes from 5.5 rad/s to standstill. Returns the highest voltage, the milliseconds, and whether
/// a current in d burnt energy.
fn brake(changes: &[(Setting, i32)]) -> (f64, usize, bool) {
    let mut rig = Rig::new(true, changes);
    let mut balance = Balance {
        capacitor: 2e-3,
        voltage: 24.0,
        kinetic: 0.0,
    };
    rig.target = (5.5 * PER_RADIAN) as i32;
    for _ in 0..1_000 {
        balance.tick(&mut rig);
    }
    rig.target = 0;
    let (mut highest, mut burnt) = (0.0_f64, false);
    for milliseconds in 0..2_000 {
        burnt |= balance.tick(&mut rig);
        highest = highest.max(balance.voltage);
        if rig.motor.shaft().velocity.abs() < 0.02 {
            return (highest, milliseconds, burnt);
        }
    }
    panic!("still moving");
}

#[test]
fn a_three_phase_motor_brakes_to_standstill_below_the_over_voltage_of_a_supply_that_takes_nothing()
{
    let (highest, milliseconds, burnt) = brake(&[]);
    println!("at most {highest} V, {milliseconds} ms");
    assert!(burnt && highest < 31.7, "{highest}");
    // As fast as the acceleration limit of 20 rad/s^2 asks, and the lag of the loops.
    assert!(milliseconds < 400, "{milliseconds}");
}

#[test]
#[should_panic(expected = "over-voltage")]
fn without_the_limit_the_same_stop_ends_in_over_voltage() {
    brake(&[(Setting::RegenerationVoltage, 60_000)]);
}
