//! A three-phase motor with Hall sensors at the motor board.

use crate::executed::{read, write};
use crate::index::with_three_phase_motor;
use crate::stamp;
use tautrack::motor::halls::COUNTS_PER_ELECTRICAL_TURN;
use tautrack::settings::Setting;

#[test]
fn a_motor_with_hall_sensors_turns_without_an_alignment() {
    let Some(_stamp) = stamp("a_motor_with_hall_sensors_turns_without_an_alignment") else {
        return;
    };
    let mut chip = with_three_phase_motor(&[
        (Setting::RotorSensor, 4),
        (Setting::EncoderCounts, 7 * COUNTS_PER_ELECTRICAL_TURN),
        (Setting::ElectricalOffset, 60_000),
        (Setting::BenchSpeed, 5_000),
    ]);
    chip.connect_halls();
    chip.run(20_000);
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
