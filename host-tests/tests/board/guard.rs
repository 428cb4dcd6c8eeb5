//! What the images of the guards do on the model of the chip.

use crate::checks::{self, frame};
use crate::chip::{
    CONTROL, Chip, Cut, DMA1, DMA1_CHANNELS, DMAMUX1, Executed, FDCAN1_IT0, I2C3, I2C3_ER, I2C3_EV,
    I2C3_REQUESTS, IWDG, STM32G474, TIM2_IRQ, Tear, USART1, USART1_IRQ,
};
use crate::chips::g474;
use crate::executed::DEFECT;
use crate::gates::log_of;
use crate::guard_images::guards;
use crate::settings::{SAVE, download_to, object};
use crate::stamp;
use clap::ValueEnum;
use std::fs;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::{GUARD_ADDRESS, LENGTH, Pages};
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::programs::{Program, flash};
use tautrack_host_tests::robots::{Kind, Role};
use tautrack_host_tests::scenario::Scenario;

/// Node id of the guard.
pub const NODE: u16 = 1;
/// Time in which a guard starts, us; less than the watchdog's period.
pub const BOOT_US: u64 = 45_000;
/// Cause "emergency stop" in object 0x4007:1.
const EMERGENCY_STOPPED: u32 = 0x30;
/// Bit of port C: emergency stop.
const EMERGENCY_STOP: u16 = 1 << 10;
/// Requests of the operator.
const STOP: u8 = 2;
const RESET: u8 = 3;
/// A value of the operator's timeout that is not the default, ms.
const TIMEOUT_MS: i32 = 450;

/// Settings pages of the guard in the robot's default scenario, with more settings.
fn settings_of(robot: Kind, more: &[(Setting, i32)]) -> Vec<u8> {
    let scenario = checkout::root()
        .expect("a checkout")
        .join("host-tests/scenarios")
        .join(robot.facts().scenario_file);
    let nodes = Scenario::load(&scenario).expect("a scenario").nodes();
    let guard = nodes.into_iter().find(|node| node.role == Role::Guard);
    let mut settings = guard.expect("a guard").settings;
    settings.push((Setting::NodeId, NODE.into()));
    settings.extend_from_slice(more);
    let mut pages = Pages::erased();
    pages.save(&settings).expect("settings of a guard");
    pages.0
}

/// Chip that starts a program with these settings pages.
fn with_pages(program: &Program, pages: &[u8]) -> Chip {
    let elf = fs::read(&program.path).expect("a program");
    let segments = flash::segments(&elf).expect("an image");
    let mut chip = Chip::of(STM32G474, &segments, 0x0800_0000);
    chip.patch(GUARD_ADDRESS, pages);
    chip.set_defect(DEFECT.get());
    chip
}

pub fn guard_with(more: &[(Setting, i32)]) -> Chip {
    with_pages(&guards()[0], &settings_of(Kind::B2p2, more))
}

/// B2P2's guard, which has started.
pub fn running_guard() -> Chip {
    let mut chip = guard_with(&[]);
    chip.run(BOOT_US);
    chip
}

/// The guards of all robots with their sensor modules, which have started.
pub fn running_guards() -> impl Iterator<Item = Chip> {
    Kind::value_variants()
        .iter()
        .zip(guards())
        .map(|(robot, program)| {
            let mut chip = with_pages(program, &settings_of(*robot, &[]));
            chip.connect_modules();
            chip.run(BOOT_US);
            chip
        })
}

/// B2P2's guard with its sensor modules, which has started; calls `watcher` after every instruction
/// from power-up on.
pub fn guard_watched(watcher: impl FnMut(Executed) + Send + 'static) -> Chip {
    let mut chip = guard_with(&[]);
    chip.connect_modules();
    chip.watch(watcher);
    chip.run(BOOT_US);
    chip
}

/// An operator commands, and drives report, for 100 ms.
pub fn drive(chip: &mut Chip) {
    for sequence in 0..10 {
        for drive in 2..6 {
            chip.send(frame(0x700 + drive, &[5]));
            chip.send(frame(0x180 + drive, &[0; 8]));
            // Its position scale, with which the guard starts the network.
            chip.send(frame(0x580 + drive, &[0x4b, 0x10, 0x20, 0, 16, 0, 0, 0]));
        }
        command(chip, sequence);
        chip.run(10_000);
    }
}

/// The operator's command "stop", with the dead-man switch held.
fn command(chip: &mut Chip, sequence: u8) {
    chip.send(frame(0x200 + NODE, &[0, 0, 0, 0, 0, 0, 0x82, sequence]));
}

/// Changes a setting and saves the settings.
pub fn save(chip: &mut Chip) {
    let value = TIMEOUT_MS.to_le_bytes();
    checks::write(chip, NODE, object(Setting::OperatorTimeout), 0, &value);
    assert_eq!(download_to(chip, NODE, SAVE, 1, *b"save"), Some((0x60, 0)));
}

#[test]
fn the_model_has_the_addresses_and_interrupts_of_this_chip() {
    for (name, address) in [
        ("USART1", USART1),
        ("IWDG", IWDG),
        ("FDCAN1", crate::chip::FDCAN),
        ("I2C3", I2C3),
        ("DMA1", DMA1),
        ("DMAMUX1", DMAMUX1),
    ] {
        assert_eq!(g474::address(name), Some(address), "{name}");
    }
    for (name, line) in [
        ("USART1", USART1_IRQ),
        ("USART3", CONTROL),
        ("TIM2", TIM2_IRQ),
        ("FDCAN1_IT0", FDCAN1_IT0),
        ("I2C3_EV", I2C3_EV),
        ("I2C3_ER", I2C3_ER),
        ("DMA1_CHANNEL1", DMA1_CHANNELS[0]),
        ("DMA1_CHANNEL2", DMA1_CHANNELS[1]),
    ] {
        assert_eq!(g474::interrupt(name), Some(line.into()), "{name}");
    }
    let requests = ["RX", "TX"].map(|signal| g474::request("I2C3", signal));
    assert_eq!(requests, I2C3_REQUESTS.map(Some));
}

#[test]
pub fn the_core_runs_at_170_mhz_from_the_crystal_of_24_mhz_with_boost() {
    checks::clocks(&running_guard(), 6);
}

#[test]
fn the_watchdog_is_started_first_and_bites_after_50_ms() {
    checks::watchdog(&running_guard());
}

#[test]
pub fn a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent() {
    checks::bit_timing(&running_guard());
}

#[test]
fn the_clock_is_more_urgent_than_the_bus_and_the_control_task_follows_before_the_sensors() {
    let chip = running_guard();
    let urgency = [TIM2_IRQ, FDCAN1_IT0, USART1_IRQ, CONTROL].map(|line| chip.priority(line));
    assert_eq!(urgency, [1, 2, 2, 3]);
    let [first, second] = DMA1_CHANNELS;
    let sensors = [I2C3_EV, I2C3_ER, first, second].map(|line| chip.priority(line));
    assert_eq!(sensors, [4; 4]);
}

#[test]
fn every_pin_has_the_function_of_the_page() {
    assert_eq!(checks::pins(&running_guard(), "guard-board.md"), 8);
}

#[test]
pub fn a_guard_without_its_bus_task_or_its_control_task_is_reset() {
    let Some(_stamp) = stamp("a_guard_without_its_bus_task_or_its_control_task_is_reset") else {
        return;
    };
    for exception in [0, 16 + CONTROL] {
        let mut chip = running_guard();
        chip.hang_in(exception);
        chip.run(30_000);
        assert_eq!(chip.resets(), 0, "{exception}");
        chip.run(30_000);
        assert_eq!(chip.resets(), 1, "{exception}");
        chip.run(BOOT_US);
        let lines = log_of(&guards()[0], &chip);
        let named = lines.iter().any(|line| line == "reset by watchdog");
        assert!(named, "{lines:?}");
    }
}

#[test]
fn frames_pass_both_ways_on_every_robot() {
    let Some(_stamp) = stamp("frames_pass_both_ways_on_every_robot") else {
        return;
    };
    for mut chip in running_guards() {
        assert_eq!(chip.resets(), 0, "the watchdog bites during the start");
        let sent = chip.take_sent();
        let boot_up = frame(0x700 + NODE, &[0]);
        assert!(sent.iter().any(|(_, it)| *it == boot_up), "{sent:x?}");
        // Device type: an inclinometer after CiA 410.
        let device = checks::read(&mut chip, NODE, 0x1000, 0);
        assert_eq!(device & 0xffff, 410);
        chip.run(100_000);
        let sent = chip.take_sent();
        let syncs = sent.iter().filter(|(_, it)| it.id() == 0x080);
        assert!(syncs.count() >= 5, "{sent:x?}");
    }
}

/// Cause of the trip (object 0x4007:1) while the guard is tripped (0x4006:4); 0 if it is not.
fn cause(chip: &mut Chip) -> u32 {
    match checks::read(chip, NODE, 0x4006, 4) & 0xff {
        0 => 0,
        _ => checks::read(chip, NODE, 0x4007, 1) & 0xff,
    }
}

#[test]
pub fn an_open_emergency_stop_trips_the_guard_until_the_operator_resets() {
    let mut chip = running_guard();
    chip.run(50_000);
    assert_eq!(cause(&mut chip), 0);
    chip.pins(|pins| pins.port_c |= EMERGENCY_STOP);
    chip.run(50_000);
    assert_eq!(cause(&mut chip), EMERGENCY_STOPPED);
    // A reset does not help while it is open.
    for (open, wanted) in [(true, EMERGENCY_STOPPED), (false, 0)] {
        chip.pins(|pins| pins.port_c = if open { EMERGENCY_STOP } else { 0 });
        chip.run(50_000);
        assert_eq!(cause(&mut chip), EMERGENCY_STOPPED, "it is latched");
        // Three commands with consecutive sequence numbers make a request.
        for (sequence, request) in (0_u8..).zip([STOP, RESET, RESET, RESET]) {
            checks::write(&mut chip, NODE, 0x4000, 4, &[request]);
            checks::write(&mut chip, NODE, 0x4000, 5, &[sequence]);
            chip.run(20_000);
        }
        chip.run(50_000);
        assert_eq!(cause(&mut chip), wanted, "after a reset");
    }
}

/// A fix of the GNSS receiver, with its checksum.
fn sentence(time: u32) -> Vec<u8> {
    let body =
        format!("GPGGA,12{time:04}.00,4530.0000,N,00730.0000,E,4,12,0.6,500.0,M,48.0,M,1.0,0000");
    let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{checksum:02X}\r\n").into_bytes()
}

#[test]
fn every_sentence_of_the_gnss_receiver_reaches_the_guard() {
    let Some(_stamp) = stamp("every_sentence_of_the_gnss_receiver_reaches_the_guard") else {
        return;
    };
    let mut chip = running_guard();
    let counts = |chip: &mut Chip| [6, 7].map(|sub| checks::read(chip, NODE, 0x4013, sub));
    assert_eq!(counts(&mut chip), [0, 0]);
    for time in 0..20 {
        chip.send_serial(&sentence(time), 115_200);
        chip.run(20_000);
    }
    // All of them are taken, none is refused.
    assert_eq!(counts(&mut chip), [20, 0]);
    assert_eq!(chip.resets(), 0);
}

#[test]
fn a_saved_setting_survives_a_reset() {
    let mut chip = running_guard();
    save(&mut chip);
    assert_eq!(chip.resets(), 0, "the watchdog bites during the save");
    let mut chip = with_pages(&guards()[0], &chip.memory(GUARD_ADDRESS, LENGTH));
    chip.run(BOOT_US);
    let timeout = checks::read(&mut chip, NODE, object(Setting::OperatorTimeout), 0);
    assert_eq!(timeout as i32, TIMEOUT_MS);
}

/// Saves a changed setting on a chip with this cut. Returns it without power, if it was cut.
fn saving(cut: Option<Cut>) -> Chip {
    let mut chip = running_guard();
    let value = TIMEOUT_MS.to_le_bytes();
    checks::write(&mut chip, NODE, object(Setting::OperatorTimeout), 0, &value);
    chip.flash(|flash| flash.cut = cut);
    let answer = download_to(&mut chip, NODE, SAVE, 1, *b"save");
    let dead = chip.flash(|flash| flash.is_dead());
    assert!(dead || answer == Some((0x60, 0)), "{answer:x?}");
    chip
}

#[test]
fn a_power_cut_in_any_write_of_a_save_leaves_the_old_or_the_new_setting() {
    let Some(_stamp) =
        stamp("a_power_cut_in_any_write_of_a_save_leaves_the_old_or_the_new_setting")
    else {
        return;
    };
    let timeout =
        |chip: &mut Chip| checks::read(chip, NODE, object(Setting::OperatorTimeout), 0) as i32;
    let old = timeout(&mut running_guard());
    assert_ne!(old, TIMEOUT_MS);
    let operations = saving(None).flash(|flash| flash.operations);
    assert!(operations > 1, "{operations}");
    // The erases, the header and its neighbours, and some of the items between.
    let cuts = (0..operations).filter(|at| *at < 3 || at % 8 == 0 || operations - at <= 5);
    for at in cuts {
        for tear in [Tear::Nothing, Tear::Half, Tear::All] {
            let cut = saving(Some(Cut { at, tear }));
            let mut chip = with_pages(&guards()[0], &cut.memory(GUARD_ADDRESS, LENGTH));
            chip.run(BOOT_US);
            let found = timeout(&mut chip);
            let whole = found == old || found == TIMEOUT_MS;
            assert!(whole, "{tear:?} of operation {at}: {found}");
        }
    }
}
