//! A three-phase motor with Hall sensors at the motor board.

use crate::executed::{NODE, axle_program, read, with_pages, write};
use tautrack::link::{MotorModel, Sensors};
use tautrack::motor::halls::COUNTS_PER_ELECTRICAL_TURN;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::Pages;
use tautrack_host_tests::robots::motors;
use tautrack_host_tests::simulator::chip::Chip;

/// A motor with 7 pole pairs and a gear of 10, whose rotor carries the load.
fn chip() -> Chip {
    let motor = MotorModel {
        rotor_inertia: 1e-4,
        ..motors::three_phase(10_000, 0.05)
    };
    let mut settings = motors::settings(&motor);
    settings.extend([
        (Setting::NodeId, NODE.into()),
        (Setting::RotorSensor, 4),
        (Setting::EncoderCounts, 7 * COUNTS_PER_ELECTRICAL_TURN),
        (Setting::ElectricalOffset, 60_000),
        (Setting::BenchSpeed, 5_000),
    ]);
    let pages = Pages::of(&settings).expect("settings of a node");
    let mut chip = with_pages(axle_program(), &pages.0);
    chip.attach_motor(motor, 5).expect("a good model");
    chip.connect_halls();
    chip.set_sensors(&Sensors {
        supply_voltage: 24.0,
        ..Sensors::default()
    });
    chip.run(20_000);
    chip
}

#[test]
fn a_motor_with_hall_sensors_turns_without_an_alignment() {
    let mut chip = chip();
    write(&mut chip, 0x2001, 0, &[1]);
    write(&mut chip, 0x6060, 0, &[9]);
    write(&mut chip, 0x60ff, 0, &5_000_000_i32.to_le_bytes());
    for word in [6, 7].into_iter().chain([15; 500]) {
        write(&mut chip, 0x6040, 0, &[word, 0]);
    }
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0);
    // It needs no alignment.
    assert_eq!(read(&mut chip, 0x2064) & 0xff, 0);
    let velocity = chip.shaft().velocity;
    assert!((velocity - 5.0).abs() < 0.2, "{velocity} rad/s");
}
