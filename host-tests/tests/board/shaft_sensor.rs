//! How the image of an axle reads the angle sensor at its output shaft, and what it does when the
//! sensor fails.

use crate::chip::{CORE_HZ, Chip, ShaftChip};
use crate::executed::{NODE, arm, read, with_pages, write};
use crate::images::programs;
use tautrack::bus::cia402::status::HOMED;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::Pages;

const CONTROLWORD: u16 = 0x6040;
const STATUSWORD: u16 = 0x6041;
const POSITION: u16 = 0x6064;
const CONDITION: u16 = 0x206a;
const ERRORS: u16 = 0x206b;
/// Conditions: running, no acknowledge, bus stuck, no magnet.
const RUNNING: u32 = 1;
const NO_ACKNOWLEDGE: u32 = 2;
const BUS_STUCK: u32 = 3;
const NO_MAGNET: u32 = 7;
/// Time in which the position is found, us: the start, and nine readings.
const FOUND_US: u64 = 45_000 + 90_000 + 20_000;
/// Units of the position in a turn: `position_bits` is 16.
const TURN: i32 = 1 << 16;

/// An axle with this sensor and these settings beside it, before its start.
fn axle(chip: ShaftChip, angle: u16, more: &[(Setting, i32)]) -> Chip {
    let number = match chip {
        ShaftChip::As5600 => 1,
        ShaftChip::As5048b => 2,
    };
    let mut settings = vec![
        (Setting::NodeId, NODE.into()),
        (Setting::ShaftSensor, number),
    ];
    settings.extend(more);
    let pages = Pages::of(&settings).expect("settings");
    let mut executed = with_pages(&programs().axle, &pages.0);
    executed.connect_shaft_sensor(chip);
    executed.shaft_sensor(|sensor| sensor.angle = angle);
    executed
}

/// Lets a client command an enabled drive for this time, us.
fn hold(chip: &mut Chip, time_us: u64) {
    let until = chip.clock() + time_us * (CORE_HZ / 1_000_000);
    while chip.clock() < until {
        write(chip, CONTROLWORD, 0, &[0x0f, 0]);
    }
}

fn homed(chip: &mut Chip) -> bool {
    read(chip, STATUSWORD) as u16 & HOMED != 0
}

fn condition(chip: &mut Chip) -> u32 {
    read(chip, CONDITION) & 0xff
}

fn errors(chip: &mut Chip) -> u32 {
    read(chip, ERRORS) & 0xffff
}

fn position(chip: &mut Chip) -> i32 {
    read(chip, POSITION).cast_signed()
}

#[test]
fn the_sensor_gives_the_position_at_power_up() {
    use ShaftChip::{As5048b, As5600};
    let zero = (Setting::ShaftZero, 45_000);
    let reversed = (Setting::ShaftDirection, -1);
    let travel = [
        (Setting::PositionMinimum, 5_000),
        (Setting::PositionMaximum, 9_000),
    ];
    for (chip, angle, more, turns) in [
        (As5600, 1_024, &[][..], 0.25),
        (As5600, 4_095, &[], -1.0 / 4_096.0),
        (As5600, 1_024, &[zero], 0.125),
        (As5600, 1_024, &[zero, reversed], -0.125),
        // The middle is 1.114 turns.
        (As5600, 1_024, &travel, 1.25),
        (As5600, 3_686, &travel, 3_686.0 / 4_096.0),
        (As5048b, 4_096, &[], 0.25),
        (As5048b, 15_000, &[zero], 15_000.0 / 16_384.0 - 1.125),
    ] {
        let mut executed = axle(chip, angle, more);
        executed.run(FOUND_US);
        assert_eq!(condition(&mut executed), RUNNING);
        assert!(homed(&mut executed), "{chip:?} {angle} {more:?}");
        let expected = f64::from(TURN) * turns;
        let found = f64::from(position(&mut executed));
        assert!(
            (found - expected).abs() <= 1.0,
            "{chip:?} {angle} {more:?}: {found}, {expected}"
        );
        assert_eq!(errors(&mut executed), 0);
        // Open inputs would count as actuated limit switches.
        assert_eq!(read(&mut executed, 0x60fd) & 3, 0);
    }
}

#[test]
fn without_a_sensor_the_axle_is_not_homed_and_says_why() {
    let mut chip = axle(ShaftChip::As5600, 1_024, &[]);
    chip.shaft_sensor(|sensor| sensor.powered = false);
    chip.run(3 * FOUND_US);
    assert_eq!(condition(&mut chip), NO_ACKNOWLEDGE);
    assert!(!homed(&mut chip) && errors(&mut chip) > 20);
    // It is connected later.
    chip.shaft_sensor(|sensor| sensor.powered = true);
    chip.run(FOUND_US);
    assert!(homed(&mut chip) && condition(&mut chip) == RUNNING);
}

#[test]
fn without_a_magnet_no_angle_counts() {
    for kind in [ShaftChip::As5600, ShaftChip::As5048b] {
        let mut chip = axle(kind, 1_024, &[]);
        chip.shaft_sensor(|sensor| sensor.magnet = false);
        chip.run(FOUND_US);
        assert_eq!(condition(&mut chip), NO_MAGNET);
        assert!(!homed(&mut chip), "{kind:?}");
        chip.shaft_sensor(|sensor| sensor.magnet = true);
        chip.run(FOUND_US);
        assert!(homed(&mut chip), "{kind:?}");
    }
}

#[test]
fn angles_that_jump_do_not_count_until_eight_in_a_row_agree() {
    let mut chip = axle(ShaftChip::As5600, 1_024, &[]);
    // By 0.6 degrees, every 50 ms.
    for jump in 0..20 {
        chip.shaft_sensor(|sensor| sensor.angle = 1_024 + 7 * (jump % 2));
        chip.run(50_000);
        assert!(!homed(&mut chip), "{jump}");
    }
    chip.run(FOUND_US);
    assert!(homed(&mut chip));
    assert!((position(&mut chip) - 1_031 * TURN / 4_096).abs() <= 1);
}

#[test]
fn a_sensor_that_fails_in_motion_leaves_the_position_to_the_encoder() {
    let mut chip = axle(ShaftChip::As5600, 1_024, &[]);
    chip.run(FOUND_US);
    assert!(homed(&mut chip));
    arm(&mut chip);
    // 4 degrees.
    chip.shaft_sensor(|sensor| sensor.angle = 1_069);
    hold(&mut chip, FOUND_US);
    chip.shaft_sensor(|sensor| sensor.powered = false);
    hold(&mut chip, FOUND_US);
    assert_eq!(condition(&mut chip), NO_ACKNOWLEDGE);
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0, "no fault");
    assert!(homed(&mut chip) && chip.is_live());
    assert!((position(&mut chip) - TURN / 4).abs() <= 1);
}

#[test]
fn a_sensor_that_jumps_in_motion_is_a_fault_and_the_drive_holds() {
    let mut chip = axle(ShaftChip::As5600, 1_024, &[]);
    chip.run(FOUND_US);
    arm(&mut chip);
    chip.shaft_sensor(|sensor| sensor.angle = 3_000);
    hold(&mut chip, FOUND_US);
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0x7306);
    assert!(homed(&mut chip) && chip.is_live());
    assert!((position(&mut chip) - TURN / 4).abs() <= 1);
    // Without power, it is no fault any more once both agree.
    chip.shaft_sensor(|sensor| sensor.angle = 1_024);
    chip.run(50_000);
    write(&mut chip, CONTROLWORD, 0, &[0, 0]);
    write(&mut chip, CONTROLWORD, 0, &[0x80, 0]);
    chip.run(5_000);
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0);
}

#[test]
fn a_line_that_is_held_low_is_named_and_ends_no_task_and_nine_clocks_free_it() {
    let mut chip = axle(ShaftChip::As5600, 1_024, &[]);
    chip.shaft_sensor(|sensor| sensor.holds_data = u32::MAX);
    chip.run(FOUND_US);
    assert_eq!(condition(&mut chip), BUS_STUCK);
    assert!(!homed(&mut chip));
    for held in [1, 9] {
        chip.shaft_sensor(|sensor| sensor.holds_data = held);
        let before = errors(&mut chip);
        chip.run(50_000);
        assert_eq!(condition(&mut chip), RUNNING, "{held}");
        assert!(errors(&mut chip) <= before + 1, "{held}");
    }
    chip.shaft_sensor(|sensor| sensor.holds_clock = true);
    chip.run(FOUND_US);
    assert_eq!(condition(&mut chip), BUS_STUCK);
    assert_eq!(chip.resets(), 0);
    chip.shaft_sensor(|sensor| sensor.holds_clock = false);
    chip.run(FOUND_US);
    assert!(homed(&mut chip) && condition(&mut chip) == RUNNING);
}
