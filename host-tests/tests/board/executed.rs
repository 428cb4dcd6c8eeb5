//! What the images do on the model of the chip: what they write to the registers, when the bridge
//! is live, what is on the bus.

pub use crate::checks::frame;
use crate::checks::{self, field};
use crate::chip::{
    ADC_CONTROL, ADC1_2, BDTR, CONTROL, CORE_HZ, Chip, Defect, Executed, FDCAN1_IT0, GPIO, MOE,
    TIM1, TIM2_IRQ,
};
use crate::images::programs;
use crate::stamp;
use std::cell::Cell;
use std::fs;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::{ADDRESS, LENGTH, Pages};
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::programs::{Program, flash};
use tautrack_host_tests::robots::Role;
use tautrack_host_tests::scenario::Scenario;

const APPLICATION: u32 = 0x0800_4000;
const LOADER: u32 = 0x0800_0000;
/// Scenario that has the settings of the nodes.
const SCENARIO: &str = "host-tests/scenarios/staircase.toml";
/// Node id of the chip.
pub const NODE: u16 = 5;
/// RAM that static variables and stack may take, bytes.
const MAX_RAM: usize = 25 * 1024;
/// Time in which a node starts, us; less than the watchdog's period.
const BOOT_US: u64 = 45_000;
/// Largest number of instructions of the current interrupt, entry and library included.
const MAX_CURRENT_INTERRUPT: u32 = 560;

thread_local! {
    /// Defect of the images that this thread's tests execute.
    pub static DEFECT: Cell<Option<Defect>> = const { Cell::new(None) };
}

/// Chip that runs an application as node [`NODE`] of B2P2, without the loader.
pub fn application(program: &Program, role: Role) -> Chip {
    let mut settings = Scenario::load(&checkout::root().expect("a checkout").join(SCENARIO))
        .expect("a scenario")
        .nodes()
        .into_iter()
        .find(|node| node.role == role)
        .expect("a node")
        .settings;
    settings.push((Setting::NodeId, NODE.into()));
    let mut pages = Pages::erased();
    pages.save(&settings).expect("settings of a node");
    with_pages(program, &pages.0)
}

/// Chip that runs an application with this contents of its settings pages, without the loader.
pub fn with_pages(program: &Program, pages: &[u8]) -> Chip {
    let elf = fs::read(&program.path).expect("a program");
    let mut chip = Chip::new(&flash::segments(&elf).expect("an image"), APPLICATION);
    chip.patch(ADDRESS, pages);
    chip.set_defect(DEFECT.get());
    chip
}

pub fn axle() -> Chip {
    application(&programs().axle, Role::Axle)
}

/// An axle that has run for 20 ms.
pub fn running_axle() -> Chip {
    let mut chip = axle();
    chip.run(20_000);
    chip
}

/// Writes an object by SDO, and waits for the answer.
pub fn write(chip: &mut Chip, object: u16, sub: u8, value: &[u8]) {
    checks::write(chip, NODE, object, sub, value);
}

/// Reads an object of up to four bytes by SDO.
pub fn read(chip: &mut Chip, object: u16) -> u32 {
    checks::read(chip, NODE, object, 0)
}

/// A screw that has started.
pub fn running_screw() -> Chip {
    let mut chip = application(&programs().screw, Role::Screw);
    chip.run(BOOT_US);
    chip
}

/// An axle that is enabled in bench mode, with a standing motor.
pub fn armed_axle() -> Chip {
    let mut chip = running_axle();
    arm(&mut chip);
    chip
}

/// The same; calls `watcher` after every instruction from power-up on.
pub fn armed_axle_watched(watcher: impl FnMut(Executed) + Send + 'static) -> Chip {
    let mut chip = axle();
    chip.watch(watcher);
    chip.run(20_000);
    arm(&mut chip);
    chip
}

/// Enables the drive in bench mode.
pub fn arm(chip: &mut Chip) {
    write(chip, 0x2001, 0, &[1]);
    write(chip, 0x6060, 0, &[9]);
    for control in [0x06_u8, 0x07, 0x0f] {
        write(chip, 0x6040, 0, &[control, 0]);
        chip.run(3_000);
    }
    let (status, error) = (read(chip, 0x6041), read(chip, 0x603f));
    assert!(
        chip.is_live(),
        "statusword {status:#06x}, error {error:#06x}"
    );
}

/// Address of an instruction with which the axle's program panics.
pub fn panic_instruction() -> u32 {
    /// The instruction UDF as the compiler writes it.
    const UNDEFINED: [u8; 2] = 0xdefe_u16.to_le_bytes();
    let elf = fs::read(&programs().axle.path).expect("a program");
    let segments = flash::segments(&elf).expect("an image");
    let place = |part: &flash::Segment| {
        let mut instructions = part.bytes.chunks_exact(2);
        let found = instructions.position(|it| it == UNDEFINED)?;
        Some(part.address + 2 * found as u32)
    };
    segments.iter().find_map(place).expect("a panic")
}

#[test]
pub fn the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states() {
    // Crystal of 8 MHz.
    checks::clocks(&running_axle(), 2);
}

#[test]
pub fn the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break() {
    let chip = running_axle();
    let timer = |offset: u32| chip.register(TIM1 + offset);
    assert_eq!(field(timer(0), 0, 1), 1, "counter enabled");
    assert_ne!(field(timer(0), 5, 2), 0, "centre-aligned");
    let period = 2 * u64::from(timer(0x2c)) * (u64::from(timer(0x28)) + 1);
    assert_eq!(CORE_HZ / period, 20_000);
    assert_eq!(CORE_HZ % period, 0);
    assert_eq!(timer(0x30), 1, "one update in a period");
    let bdtr = timer(0x44);
    // The default dead time of 600 ns is 102 core clocks.
    assert_eq!(field(bdtr, 0, 8), 102);
    assert_eq!(field(bdtr, 8, 2), 2, "lock level");
    assert_eq!(field(bdtr, 10, 2), 3, "idle levels are driven");
    assert_eq!(
        field(bdtr, 12, 3),
        0b011,
        "break is enabled, active high, latched"
    );
    // The pin, inverted.
    assert_eq!(timer(0x60) & 0x3ff, 1 | 1 << 9);
    for (register, shift) in [(0x18, 0), (0x18, 8), (0x1c, 0), (0x1c, 8)] {
        let mode = field(timer(register), shift, 8);
        assert_eq!(mode & 0x7b, 0x68, "PWM mode 1 with preload");
    }
    assert_eq!(
        field(timer(0x20), 0, 12),
        0x555,
        "all six outputs, not inverted"
    );
    assert_eq!(field(timer(4), 8, 6), 0, "idle level low");
    assert_eq!(field(timer(4), 20, 4), 7, "TRGO2 is channel 4");
}

#[test]
pub fn the_gates_are_pulled_low_and_as_slow_as_pc13_must_be() {
    let chip = running_axle();
    // Ports A, B and C.
    for (port, pin) in [(0, 8), (0, 9), (0, 10), (0, 12), (1, 15), (2, 13)] {
        let registers = GPIO + 0x400 * port;
        assert_eq!(field(chip.register(registers), 2 * pin, 2), 2, "alternate");
        assert_eq!(field(chip.register(registers + 8), 2 * pin, 2), 0, "speed");
        assert_eq!(field(chip.register(registers + 0xc), 2 * pin, 2), 2, "pull");
    }
}

#[test]
pub fn the_trigger_of_the_samples_is_low_for_four_clocks_of_the_converters() {
    let chip = running_axle();
    // Channel 4 is low while the counter is above its compare value, on the way up and down.
    let low = 2 * (chip.register(TIM1 + 0x2c) - chip.register(TIM1 + 0x40));
    let control = chip.register(ADC_CONTROL);
    assert_eq!(field(control, 16, 2), 0, "clock of the core, divided");
    let dividers = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
    let divider = dividers[field(control, 18, 4) as usize];
    assert!(CORE_HZ / u64::from(divider) <= 60_000_000, "{divider}");
    assert!(low >= 4 * divider, "{low} clocks, {divider} each");
}

#[test]
pub fn every_gate_is_off_until_the_drive_is_armed() {
    let mut chip = axle();
    chip.run(200_000);
    let live: Vec<_> = chip
        .writes()
        .into_iter()
        .filter(|write| write.address == BDTR && write.value & MOE != 0)
        .collect();
    // The constructor of the library sets the bit while no output is enabled.
    let enabled = chip
        .writes()
        .iter()
        .find(|write| write.address == TIM1 + 0x20 && write.value & 0x555 != 0)
        .map(|write| write.clock)
        .expect("outputs are enabled");
    assert!(live.iter().all(|write| write.clock < enabled), "{live:x?}");
    assert!(!chip.is_live());
    // This checks that an armed drive is live.
    armed_axle();
}

#[test]
pub fn a_panic_opens_the_bridge_and_the_watchdog_resets_the_chip() {
    let mut chip = armed_axle();
    chip.jump(panic_instruction());
    chip.run(20);
    assert!(!chip.is_live());
    assert_eq!(chip.resets(), 0);
    chip.run(80_000);
    assert_eq!(chip.resets(), 1);
    assert!(!chip.is_live());
}

#[test]
fn a_hard_fault_opens_the_bridge_and_the_watchdog_resets_the_chip() {
    let mut chip = armed_axle();
    chip.jump(0xf000_0000);
    chip.run(20);
    assert!(!chip.is_live());
    chip.run(80_000);
    assert_eq!(chip.resets(), 1);
    assert!(!chip.is_live());
}

#[test]
pub fn a_bus_task_that_hangs_is_reset_within_the_period_of_the_watchdog() {
    let mut chip = armed_axle();
    chip.hang();
    // The interrupts still run, so the control task and the current loop do.
    chip.run(30_000);
    assert_eq!(chip.resets(), 0);
    chip.run(30_000);
    assert_eq!(chip.resets(), 1);
    assert!(!chip.is_live());
}

#[test]
pub fn the_watchdog_is_started_first_and_bites_after_50_ms() {
    checks::watchdog(&running_axle());
}

#[test]
pub fn safe_torque_off_opens_the_bridge_until_the_drive_is_disabled() {
    let mut chip = armed_axle();
    chip.pins(|pins| pins.safe_torque_off = false);
    chip.run(2);
    assert!(!chip.is_live());
    chip.run(50_000);
    assert!(!chip.is_live());
}

#[test]
fn an_over_voltage_opens_the_bridge_within_four_pwm_periods() {
    let mut chip = armed_axle();
    // 32.2 V, behind the divider of 169 and 18 kiloohm.
    chip.pins(|pins| pins.supply = 3_847);
    chip.run(200);
    assert!(!chip.is_live());
    chip.run(3_000);
    assert_eq!(read(&mut chip, 0x603f), 0x3210);
}

#[test]
pub fn the_current_interrupt_is_the_most_urgent_one() {
    let chip = running_axle();
    let urgency = [ADC1_2, TIM2_IRQ, FDCAN1_IT0, CONTROL].map(|line| chip.priority(line));
    assert_eq!(urgency, [0, 1, 2, 3]);
}

#[test]
pub fn the_current_interrupt_takes_at_most_560_instructions() {
    let chip = armed_axle();
    println!("current interrupt: {} instructions", chip.current_interrupt);
    assert!(chip.current_interrupt > 100);
    assert!(
        chip.current_interrupt <= MAX_CURRENT_INTERRUPT,
        "{}",
        chip.current_interrupt
    );
}

#[test]
pub fn the_current_interrupt_takes_at_most_a_fifth_of_its_period_with_all_wait_states() {
    let mut chip = armed_axle();
    chip.count_wait_states();
    chip.run(10_000);
    let (clocks, period) = (chip.current_interrupt_clocks, CORE_HZ / 20_000);
    println!("current interrupt: {clocks} of {period} clocks");
    assert!(clocks > u64::from(chip.current_interrupt));
    assert!(clocks <= period / 5, "{clocks} of {period} clocks");
}

#[test]
fn static_variables_and_stack_take_at_most_25_kib() {
    let mut axle = armed_axle();
    axle.run(100_000);
    let mut screw = application(&programs().screw, Role::Screw);
    screw.run(BOOT_US);
    read(&mut screw, 0x6041);
    screw.run(100_000);
    for (name, chip) in [("axle", axle), ("screw", screw)] {
        let used = chip.used_ram();
        println!("{name}: {used} bytes of RAM");
        assert!((4_000..=MAX_RAM).contains(&used), "{name}: {used}");
    }
}

#[test]
pub fn a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent() {
    checks::bit_timing(&running_axle());
}

#[test]
pub fn frames_pass_both_ways() {
    let screw = || application(&programs().screw, Role::Screw);
    for (name, mut chip) in [("axle", axle()), ("screw", screw())] {
        chip.run(BOOT_US);
        assert_eq!(
            chip.resets(),
            0,
            "{name}: the watchdog bites during the start"
        );
        let sent = chip.take_sent();
        let boot_up = frame(0x700 + NODE, &[0]);
        assert!(
            sent.iter().any(|(_, frame)| *frame == boot_up),
            "{name}: {sent:x?}"
        );
        // Device type: a servo drive after CiA 402.
        chip.send(frame(0x600 + NODE, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
        chip.run(5_000);
        let sent = chip.take_sent();
        let answer = sent
            .iter()
            .find(|(_, frame)| frame.id() == 0x580 + NODE)
            .unwrap_or_else(|| panic!("{name} does not answer: {sent:x?}"));
        assert_eq!(answer.1.data()[..4], [0x43, 0x00, 0x10, 0], "{name}");
        assert_eq!(answer.1.data()[4..6], 402_u16.to_le_bytes(), "{name}");
    }
}

/// Whether a node without settings runs: it sends nothing by itself, and says by LSS that it has no
/// node id.
pub fn waits_for_an_id(chip: &mut Chip) -> bool {
    let silent = chip.take_sent().is_empty();
    for request in [[0x04, 1, 0, 0, 0, 0, 0, 0], [0x5e, 0, 0, 0, 0, 0, 0, 0]] {
        chip.send(frame(0x7e5, &request));
        chip.run(5_000);
    }
    let answer = frame(0x7e4, &[0x5e, 0xff, 0, 0, 0, 0, 0, 0]);
    silent && chip.take_sent().iter().any(|(_, sent)| *sent == answer)
}

#[test]
fn damaged_settings_count_as_none() {
    let mut chip = axle();
    chip.patch(ADDRESS, &[0x5a; LENGTH]);
    chip.run(20_000);
    assert!(waits_for_an_id(&mut chip));
}

#[test]
pub fn every_pin_has_the_function_of_the_page() {
    assert_eq!(checks::pins(&running_axle(), "hardware.md"), 28);
}

#[test]
fn the_can_transceiver_is_on_and_the_terminator_off() {
    let chip = running_axle();
    // Output data register of port C. Both pins act when they are high.
    let output = chip.register(crate::chip::GPIO + 0x400 * 2 + 0x14);
    assert_eq!(output & (1 << 11 | 1 << 14), 0);
}

#[test]
fn the_loader_starts_a_complete_image_and_no_other() {
    let Some(_stamp) = stamp("the_loader_starts_a_complete_image_and_no_other") else {
        return;
    };
    let loader = fs::read(&programs().loader.path).expect("the loader");
    let elf = fs::read(&programs().axle.path).expect("the axle");
    let sealed = flash::sealed(elf).expect("an image");
    let mut segments = flash::segments(&loader).expect("an image");
    segments.extend(flash::segments(&sealed).expect("an image"));
    let boots = |damage: Option<(u32, u8)>| {
        let mut chip = Chip::new(&segments, LOADER);
        if let Some((address, value)) = damage {
            chip.patch(address, &[value]);
        }
        chip.run(60_000);
        waits_for_an_id(&mut chip)
    };
    assert!(boots(None));
    assert!(!boots(Some((APPLICATION + 0x1_0000, 0x5a))));
    assert!(!boots(Some((APPLICATION + 0x1e0, 0))));
}
