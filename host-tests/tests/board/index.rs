//! A three-phase motor at the motor board: its incremental encoder is aligned, and the index
//! confirms the angle. Near its highest speed, the currents of some phases cannot be sampled.

use crate::chip::TIM1;
use crate::executed::{NODE, read, with_pages, write};
use crate::images::programs;
use crate::stamp;
use tautrack::link::{MotorModel, Sensors};
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::Pages;
use tautrack_host_tests::robots::motors;
use tautrack_host_tests::simulator::chip::Chip;

/// A chip with a three-phase motor of 7 pole pairs behind a gear of 10, whose rotor carries the
/// load, and with these settings besides those of the motor. It is switched on.
pub fn with_three_phase_motor(more: &[(Setting, i32)]) -> Chip {
    let motor = MotorModel {
        rotor_inertia: 1e-4,
        ..motors::three_phase(10_000, 0.05)
    };
    let mut settings = motors::settings(&motor);
    settings.push((Setting::NodeId, NODE.into()));
    settings.extend_from_slice(more);
    let pages = Pages::of(&settings).expect("settings of a node");
    let mut chip = with_pages(&programs().axle, &pages.0);
    chip.attach_motor(motor, 5).expect("a good model");
    chip.set_sensors(&Sensors {
        supply_voltage: 24.0,
        ..Sensors::default()
    });
    chip
}

#[test]
fn the_index_of_an_encoder_confirms_the_angle_of_an_aligned_motor() {
    let Some(_stamp) = stamp("the_index_of_an_encoder_confirms_the_angle_of_an_aligned_motor")
    else {
        return;
    };
    let mut chip =
        with_three_phase_motor(&[(Setting::RotorSensor, 3), (Setting::AlignmentTravel, 1_000)]);
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

/// Compare registers of TIM1, and the value above which the low side conducts too briefly for the
/// op-amp: 0.6 us of dead time and 1.3 us before the middle, at 170 MHz.
const COMPARES: [u32; 3] = [TIM1 + 0x34, TIM1 + 0x38, TIM1 + 0x3c];
const TOO_BRIEF: u32 = 4_250 - 323;

/// The model of the chip shows no current in such a phase.
#[test]
fn a_motor_near_its_highest_speed_needs_no_sample_of_a_low_side_that_conducts_too_briefly() {
    let name =
        "a_motor_near_its_highest_speed_needs_no_sample_of_a_low_side_that_conducts_too_briefly";
    let Some(_stamp) = stamp(name) else {
        return;
    };
    let mut chip = with_three_phase_motor(&[
        (Setting::RotorSensor, 1),
        (Setting::AlignmentTravel, 1_000),
        (Setting::VelocityLimit, 50_000),
        (Setting::AccelerationLimit, 200_000),
        (Setting::BenchSpeed, 48_000),
        (Setting::BenchCurrent, 6_000),
    ]);
    chip.run(20_000);
    write(&mut chip, 0x2001, 0, &[1]);
    write(&mut chip, 0x6060, 0, &[9]);
    write(&mut chip, 0x60ff, 0, &46_000_000_i32.to_le_bytes());
    let mut brief = [0; 3];
    for word in [6, 7].into_iter().chain([15; 1_200]) {
        write(&mut chip, 0x6040, 0, &[word, 0]);
        for (phase, register) in COMPARES.into_iter().enumerate() {
            brief[phase] += u32::from(chip.register(register) & 0xffff > TOO_BRIEF);
        }
    }
    let velocity = chip.shaft().velocity;
    println!("{velocity} rad/s, {brief:?} too brief");
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0);
    assert!((velocity - 46.0).abs() < 0.5, "{velocity} rad/s");
    assert!(brief.iter().all(|brief| *brief > 20), "{brief:?}");
}
