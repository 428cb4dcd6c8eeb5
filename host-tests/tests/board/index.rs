//! A three-phase motor at the motor board: its incremental encoder is aligned, and the index
//! confirms the angle.

use crate::executed::{axle_program, read, with_pages, write};
use tautrack::link::{MotorModel, Sensors, ThreePhaseModel, WindingModel};
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::Pages;

/// 24 V, 0.04 N m/A, with a gear of 10.
const MOTOR: MotorModel = MotorModel {
    winding: WindingModel::ThreePhase(ThreePhaseModel {
        resistance: 0.3,
        inductance: [0.15e-3, 0.18e-3],
        flux: 0.04 / (1.5 * 7.0),
        pole_pairs: 7,
        offset_degrees: 40.0,
        cogging_torque: 0.0,
        cogging_periods: 42,
    }),
    rotor_inertia: 1e-4,
    gear_ratio: 10.0,
    friction_torque: 0.05,
    brake_torque: 0.0,
    encoder_counts: 4_096,
    current_noise: 0.02,
    current_quantum: 0.0,
    dead_time: 0.6e-6,
};

#[test]
fn the_index_of_an_encoder_confirms_the_angle_of_an_aligned_motor() {
    let settings = [
        (Setting::NodeId, i32::from(crate::executed::NODE)),
        (Setting::MotorKind, 1),
        (Setting::RotorSensor, 3),
        (Setting::ElectricalOffset, 40_000),
        (Setting::Resistance, 300),
        (Setting::Inductance, 150),
        (Setting::InductanceQ, 180),
        (Setting::GearRatio, 10_000),
        (Setting::AlignmentTravel, 1_000),
    ];
    let pages = Pages::of(&settings).expect("settings of a node");
    let mut chip = with_pages(axle_program(), &pages.0);
    chip.attach_motor(MOTOR, 5).expect("a good model");
    chip.set_sensors(&Sensors {
        supply_voltage: 24.0,
        ..Sensors::default()
    });
    chip.run(20_000);
    write(&mut chip, 0x2001, 0, &[1]);
    write(&mut chip, 0x6060, 0, &[9]);
    write(&mut chip, 0x60ff, 0, &1_000_000_i32.to_le_bytes());
    let mut states = Vec::new();
    for word in [6, 7].into_iter().chain([15; 600]) {
        write(&mut chip, 0x6040, 0, &[word, 0]);
        let state = read(&mut chip, 0x2064) & 0xff;
        if states.last() != Some(&state) {
            println!("{state} at {} ms", chip.clock() / 170_000);
            states.push(state);
        }
        assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0, "{states:?}");
        if state == 4 {
            break;
        }
    }
    // Needed, under way, done, confirmed.
    assert_eq!(states, [1, 2, 3, 4]);
    assert!((chip.shaft().velocity - 1.0).abs() < 0.1);
}
