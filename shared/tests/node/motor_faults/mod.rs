//! Provokes the faults of a drive on the motor model, and checks reaction, time, travel and
//! snapshot. Motors: 24 V, 10 A, 0.04 N m/A, gear 60, 0.05 kg m^2 at the output shaft, speed limit
//! 6 rad/s.

pub mod rig;
mod sound;
mod supply;
mod voltage;
pub mod wrong_angle;

use rig::{PER_RADIAN, Rig, Trouble};
use tautrack::bus::cia402::mode;
use tautrack::faults::{Fault, Reaction};
use tautrack::motor::model::MotorModel;
use tautrack::node::axle::{ActiveLimit, BridgeDemand, Outputs};
use tautrack::sensors::Temperatures;
use tautrack::settings::Setting;

/// Sensors and leads that let a motor run away, or turn its torque around.
const WRONG: [Trouble; 7] = [
    Trouble::ReversedEncoder,
    Trouble::ReversedPhase,
    Trouble::FrozenEncoder,
    Trouble::NoisyEncoder(1_000),
    Trouble::Slipped(90.0),
    Trouble::Slipped(-90.0),
    Trouble::Slipped(180.0),
];

/// Runs at `speed`, rad/s, for a second, then with `trouble` and the new speed until the bridge
/// stops. Returns the outputs, the milliseconds and the travel, rad.
fn provoke(three_phase: bool, speeds: [f64; 2], trouble: Trouble) -> (Outputs, usize, f64) {
    let mut rig = Rig::new(three_phase, &[]);
    rig.target = (speeds[0] * PER_RADIAN) as i32;
    rig.run(1_000);
    rig.trouble = trouble;
    rig.target = (speeds[1] * PER_RADIAN) as i32;
    let (outputs, milliseconds, travel) = rig
        .until_fault(1_000)
        .unwrap_or_else(|| panic!("{trouble:?} at {speeds:?} rad/s is not found"));
    let fault = outputs.faults.strongest().unwrap();
    println!(
        "three_phase {three_phase}, {speeds:?} rad/s, {trouble:?}: {fault:?} after {milliseconds} ms, {travel:.3} rad"
    );
    let expected = match fault.description().reaction {
        Reaction::Off => BridgeDemand::Off,
        _ => BridgeDemand::Brake,
    };
    assert_eq!(outputs.bridge, expected);
    // The motor never carries more than the current at which the PWM interrupt opens the bridge,
    // plus what rises in a period.
    assert!(rig.largest_current < 17.0, "{} A", rig.largest_current);
    (outputs, milliseconds, travel)
}

fn slips(trouble: Trouble) -> bool {
    matches!(trouble, Trouble::Slipped(_))
}

#[test]
fn a_brushed_motor_with_a_wrong_sensor_or_lead_stops_within_50_ms_and_0_08_rad() {
    for trouble in WRONG.into_iter().filter(|trouble| !slips(*trouble)) {
        for speed in [1.2, 3.0, 5.5, -3.0] {
            let (_, milliseconds, travel) = provoke(false, [speed; 2], trouble);
            assert!(milliseconds <= 30 && travel < 0.08, "{trouble:?} {speed}");
        }
        for speeds in [[0.0, 3.0], [0.0, -5.0], [0.3, 0.3]] {
            let (_, milliseconds, travel) = provoke(false, speeds, trouble);
            assert!(
                milliseconds <= 50 && travel < 0.04,
                "{trouble:?} {speeds:?}"
            );
        }
    }
}

#[test]
fn a_rotor_angle_that_is_wrong_by_90_or_180_degrees_stops_the_motor_within_50_ms() {
    for trouble in WRONG.into_iter().filter(|trouble| slips(*trouble)) {
        for speed in [1.2, 3.0, 5.5, -3.0] {
            let (_, milliseconds, travel) = provoke(true, [speed; 2], trouble);
            assert!(milliseconds <= 50 && travel < 0.06, "{trouble:?} {speed}");
        }
    }
}

#[test]
fn a_three_phase_motor_with_a_wrong_sensor_or_lead_stops_within_50_ms_and_0_07_rad() {
    for trouble in WRONG {
        for speeds in [
            [0.0, 3.0],
            [0.3, 0.3],
            [0.6, 0.6],
            [1.2, 1.2],
            [2.0, 2.0],
            [3.0, 3.0],
            [5.5, 5.5],
            [-3.0, -3.0],
        ] {
            let (_, milliseconds, travel) = provoke(true, speeds, trouble);
            assert!(travel < 0.07, "{trouble:?} {speeds:?}");
            assert!(milliseconds <= 50, "{trouble:?} {speeds:?}");
        }
    }
}

#[test]
fn an_angle_that_is_wrong_by_30_or_60_degrees_is_reported_within_a_second_and_exceeds_no_limit() {
    for degrees in [30.0, -30.0, 60.0, -60.0] {
        for speed in [0.6, 1.2, 3.0, -3.0, 5.5] {
            let (outputs, milliseconds, _) = provoke(true, [speed; 2], Trouble::Slipped(degrees));
            assert!(milliseconds <= 300, "{degrees} {speed}");
            assert!(f64::from(outputs.velocity).abs() < 6.0);
        }
    }
}

#[test]
fn an_open_lead_is_found_under_load() {
    for (three_phase, leads) in [(false, 0..2), (true, 0..3)] {
        for lead in leads {
            for speed in [0.3, 1.2, 3.0] {
                let mut rig = Rig::new(three_phase, &[]);
                rig.target = (speed * PER_RADIAN) as i32;
                rig.run(1_000);
                rig.load = 8.0;
                rig.run(300);
                rig.trouble = Trouble::OpenLead(lead);
                let (outputs, milliseconds, travel) = rig.until_fault(200).unwrap();
                println!("lead {lead} at {speed} rad/s: {milliseconds} ms, {travel:.3} rad");
                assert_eq!(outputs.faults.strongest(), Some(Fault::OpenPhase));
                assert!(milliseconds <= 50 && outputs.bridge == BridgeDemand::Off);
            }
        }
    }
}

#[test]
fn a_saturated_converter_and_missed_interrupts_stop_the_motor_within_4_ms() {
    for three_phase in [false, true] {
        for code in [0, u16::MAX] {
            let (outputs, milliseconds, _) =
                provoke(three_phase, [3.0; 2], Trouble::CurrentCode(code));
            assert_eq!(outputs.faults.strongest(), Some(Fault::OverCurrent));
            assert!(milliseconds <= 2);
        }
        let (outputs, milliseconds, _) = provoke(three_phase, [3.0; 2], Trouble::MissedInterrupts);
        assert_eq!(outputs.faults.strongest(), Some(Fault::ControlOverrun));
        assert!(milliseconds <= 4);
    }
}

#[test]
fn a_sound_motor_with_wrong_parameters_runs_without_a_fault() {
    let off = |setting: Setting, percent: i32| {
        let healthy = rig::settings(true, &[]).get(setting);
        (setting, healthy * percent / 100)
    };
    for three_phase in [false, true] {
        for changes in [
            vec![],
            vec![
                (Setting::Resistance, if three_phase { 420 } else { 840 }),
                off(Setting::TorqueConstant, 110),
            ],
            vec![
                (Setting::Resistance, if three_phase { 215 } else { 430 }),
                off(Setting::TorqueConstant, 90),
            ],
            vec![(Setting::ElectricalOffset, 42_000)],
        ] {
            let mut rig = Rig::new(three_phase, &changes);
            for step in 0..60 {
                rig.target = ([5.5, -5.5, 0.0, 3.0, -0.5, 4.0][step % 6] * PER_RADIAN) as i32;
                rig.load = [0.0, 5.0, -5.0, 2.0, 8.0][step % 5];
                rig.run(400);
            }
        }
    }
}

#[test]
fn the_snapshot_holds_the_readings_of_the_first_fault_alone() {
    let mut rig = Rig::new(true, &[(Setting::BridgeTemperature, 900)]);
    rig.temperatures = Temperatures {
        bridge: Some(41.5),
        motor: None,
    };
    rig.target = (3.0 * PER_RADIAN) as i32;
    rig.load = 12.0;
    rig.run(1_000);
    rig.supply_voltage = 11.5;
    let (outputs, milliseconds, _) = rig.until_fault(20).unwrap();
    assert_eq!(milliseconds, 5);
    let snapshot = outputs.snapshot.expect("the first fault");
    assert_eq!(snapshot.code, Fault::UnderVoltage.description().code);
    assert_eq!(snapshot.supply_voltage, 11_500);
    assert_eq!(snapshot.velocity, outputs.motion.velocity);
    assert_eq!(snapshot.position, outputs.motion.position);
    assert_eq!(snapshot.current, outputs.status.current);
    assert_eq!(
        (snapshot.bridge_temperature, snapshot.motor_temperature),
        (415, i16::MIN)
    );
    // A second fault leaves it alone; after a reset, the next fault takes a new one. The open
    // bridge resists no load.
    rig.load = 0.0;
    rig.temperatures.bridge = Some(95.0);
    let mut raised = outputs.faults;
    for _ in 0..50 {
        let outputs = rig.tick();
        assert_eq!(outputs.snapshot, None);
        raised = raised.or(outputs.faults);
    }
    assert!(raised.contains(Fault::OverTemperature));
    (rig.supply_voltage, rig.temperatures.bridge, rig.reset) = (24.0, Some(30.0), true);
    while !rig.tick().faults.is_empty() {}
    rig.reset = false;
    rig.run(500);
    rig.supply_voltage = 33.0;
    let (outputs, ..) = rig.until_fault(20).unwrap();
    assert_eq!(
        outputs.snapshot.unwrap().code,
        Fault::OverVoltage.description().code
    );
}

#[test]
fn temperatures_and_their_sensors_are_watched_where_the_settings_say_so() {
    for (temperature, fault, within) in [
        (Some(90.5), Fault::OverTemperature, 20),
        (Some(f32::NAN), Fault::InvalidReading, 3),
        (None, Fault::InvalidReading, 3),
    ] {
        let mut rig = Rig::new(false, &[(Setting::MotorTemperature, 900)]);
        rig.temperatures.motor = Some(25.0);
        rig.target = PER_RADIAN as i32;
        rig.run(500);
        rig.temperatures.motor = temperature;
        let (outputs, milliseconds, _) = rig.until_fault(50).unwrap();
        assert_eq!(outputs.faults.strongest(), Some(fault));
        assert_eq!(
            (milliseconds, outputs.bridge),
            (within, BridgeDemand::Brake)
        );
        // Without the setting, the reading is not used.
        let mut rig = Rig::new(false, &[]);
        rig.temperatures.motor = temperature;
        rig.target = PER_RADIAN as i32;
        rig.run(500);
    }
}

#[test]
fn with_a_sign_probe_a_wrong_drive_stops_50_ms_after_its_first_torque_and_before_a_full_one() {
    for three_phase in [false, true] {
        for trouble in WRONG {
            if !three_phase && slips(trouble) {
                continue;
            }
            for speed in [3.0, -5.0, 0.5] {
                let mut rig = Rig::new(three_phase, &[(Setting::ProbeCurrent, 1_000)]);
                rig.run(500);
                (rig.trouble, rig.largest_current) = (trouble, 0.0);
                rig.target = (speed * PER_RADIAN) as i32;
                let (start, mut milliseconds) = (rig.angle(), 0);
                let fault = loop {
                    let outputs = rig.tick();
                    match outputs.bridge {
                        BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => {
                            assert!(current.abs() <= 1.0);
                            milliseconds += usize::from(current != 0.0);
                        }
                        _ => break outputs.faults.strongest(),
                    }
                };
                let travel = (rig.angle() - start).abs();
                println!(
                    "three_phase {three_phase}, {speed} rad/s, {trouble:?}: {fault:?} after {milliseconds} ms, {travel:.4} rad"
                );
                assert!(fault.is_some() && milliseconds <= 50 && travel < 0.02);
                // A rotor angle that jumps disturbs the current controllers.
                let noisy = matches!(trouble, Trouble::NoisyEncoder(_));
                let most = if noisy { 3.0 } else { 1.1 };
                assert!(rig.largest_current < most, "{} A", rig.largest_current);
            }
        }
    }
}

#[test]
fn the_sign_probe_ends_with_the_first_motion_and_begins_anew_with_each_arming() {
    for three_phase in [false, true] {
        let mut rig = Rig::new(three_phase, &[(Setting::ProbeCurrent, 400)]);
        for _ in 0..2 {
            rig.target = (3.0 * PER_RADIAN) as i32;
            let mut limited = 0;
            for _ in 0..300 {
                limited += usize::from(rig.run(1).active_limit == ActiveLimit::SignProbe);
            }
            println!("three_phase {three_phase}: limited for {limited} ms");
            assert!((1..=60).contains(&limited));
            rig.load = 12.0;
            let outputs = rig.run(500);
            assert!(outputs.status.current > 4_500 && (outputs.velocity - 3.0).abs() < 0.2);
            rig.load = 0.0;
            rig.word = Some(0x0000);
            rig.run(1_000);
            rig.word = None;
        }
    }
}

#[test]
fn a_shaft_that_does_not_turn_gets_no_more_than_the_current_of_the_sign_probe() {
    for three_phase in [false, true] {
        let stuck = MotorModel {
            friction_torque: 10.0,
            ..rig::model(three_phase)
        };
        let settings = rig::settings(three_phase, &[(Setting::ProbeCurrent, 1_000)]);
        let mut rig = Rig::with_model(stuck, &settings);
        rig.target = (3.0 * PER_RADIAN) as i32;
        let (outputs, ..) = rig.until_fault(500).unwrap();
        assert_eq!(outputs.faults.strongest(), Some(Fault::Blocked));
        assert!(rig.largest_current < 1.1, "{} A", rig.largest_current);
    }
}

/// Arms a drive whose shaft still turns, and lets it turn the other way.
#[test]
fn a_shaft_that_coasts_when_power_is_enabled_is_not_accused_by_the_sign_probe() {
    for three_phase in [false, true] {
        for acceleration in [20_000, 120_000] {
            for off in [8, 40, 100] {
                let changes = [
                    (Setting::ProbeCurrent, 560),
                    (Setting::AccelerationLimit, acceleration),
                ];
                let mut rig = Rig::new(three_phase, &changes);
                rig.target = (5.0 * PER_RADIAN) as i32;
                rig.run(600);
                rig.word = Some(0);
                rig.run(off);
                rig.word = None;
                for target in [-5.0, 0.0, 5.0] {
                    rig.target = (target * PER_RADIAN) as i32;
                    rig.run(500);
                }
            }
        }
    }
}

/// A shaft that was held is free when power is enabled again, with the torque still demanded.
#[test]
fn the_sign_probe_forgets_that_the_shaft_was_held() {
    for three_phase in [false, true] {
        let mut rig = Rig::new(three_phase, &[(Setting::ProbeCurrent, 560)]);
        rig.mode = mode::CYCLIC_TORQUE;
        rig.run(300);
        let torque = 1.0 * 0.04 * rig::GEAR; // N m of 1 A
        rig.target = (torque * f64::from(rig.axle.scale().torque_units())) as i32;
        let held = (0..200).find_map(|_| {
            rig.load = if rig.motor.shaft().velocity > 0.0 {
                1.5
            } else {
                0.9
            };
            rig.tick().faults.strongest()
        });
        assert_eq!(held, Some(Fault::Blocked));
        rig.load = 0.0;
        rig.reset = true;
        while !rig.tick().faults.is_empty() {}
        rig.reset = false;
        rig.run(100);
    }
}
