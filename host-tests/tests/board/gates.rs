//! The gates are off after every kind of failure, and the node reports the cause of its reset.

use crate::checks;
use crate::chip::Chip;
use crate::executed::{NODE, armed_axle, panic_instruction, read, write};
use crate::images::programs;
use defmt_decoder::Table;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol};
use std::fs;
use tautrack_host_tests::programs::Program;

/// Lines that the axle has written to its log since the chip has this RAM.
pub fn log(chip: &Chip) -> Vec<String> {
    log_of(&programs().axle, chip)
}

/// The same of any program.
pub fn log_of(program: &Program, chip: &Chip) -> Vec<String> {
    let elf = fs::read(&program.path).expect("a program");
    let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
    let block = file
        .symbols()
        .find(|symbol| symbol.name() == Ok("_SEGGER_RTT"))
        .expect("a block that a probe finds")
        .address() as u32;
    // Behind identification and counts: name, buffer, its size, and where the next byte goes.
    let word = |offset: u32| {
        let bytes = chip.memory(block + offset, 4);
        u32::from_le_bytes(bytes.try_into().expect("a word"))
    };
    let (buffer, written) = (word(28), word(36));
    let table = Table::parse(&elf).expect("log texts").expect("log texts");
    let mut decoder = table.new_stream_decoder();
    decoder.received(&chip.memory(buffer, written as usize));
    let mut lines = Vec::new();
    while let Ok(record) = decoder.decode() {
        lines.push(record.display_message().to_string());
    }
    lines
}

/// Checks that the bridge stays open for a second, though a client commands the enabled state.
fn stays_open(chip: &mut Chip, what: &str) {
    for _ in 0..10 {
        chip.run(50_000);
        assert!(!chip.is_live(), "{what}: the bridge is live");
        write(chip, 0x6040, 0, &[0x0f, 0]);
        assert!(!chip.is_live(), "{what}: the bridge is live");
    }
}

fn resets_and_stays_open(what: &str, fail: impl FnOnce(&mut Chip), cause: &str) {
    let mut chip = armed_axle();
    fail(&mut chip);
    chip.run(20);
    assert!(!chip.is_live(), "{what}: the bridge is live");
    chip.run(110_000);
    assert!(!chip.is_live(), "{what}: the bridge is live");
    let lines = log(&chip);
    assert!(lines.iter().any(|line| line == cause), "{what}: {lines:?}");
    stays_open(&mut chip, what);
}

#[test]
pub fn after_a_panic_the_gates_stay_off_and_the_watchdog_is_named() {
    let panic = panic_instruction();
    let fail = |chip: &mut Chip| chip.jump(panic);
    resets_and_stays_open("panic", fail, "reset by watchdog");
}

/// Runs an axle until the watchdog is about to reset it. Returns the last line of its log.
fn last_line(fail: impl FnOnce(&mut Chip)) -> Option<String> {
    let mut chip = armed_axle();
    fail(&mut chip);
    chip.run(1_000);
    log(&chip).pop()
}

#[test]
fn the_log_names_the_address_of_a_panic_and_tells_it_from_a_hard_fault() {
    let panic = panic_instruction();
    let line = last_line(|chip| chip.jump(panic));
    assert_eq!(line, Some(format!("panic at {panic:#x}")));
    let line = last_line(|chip| chip.jump(0xf000_0000));
    assert_eq!(line, Some("hard fault at 0xf0000000".to_owned()));
}

#[test]
pub fn after_a_hard_fault_the_gates_stay_off_and_the_watchdog_is_named() {
    let fail = |chip: &mut Chip| chip.jump(0xf000_0000);
    resets_and_stays_open("hard fault", fail, "reset by watchdog");
}

#[test]
pub fn a_stack_that_overflows_opens_the_bridge_and_overwrites_nothing() {
    let elf = fs::read(&programs().axle.path).expect("a program");
    let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
    let end = file.symbols().find(|it| it.name() == Ok("__euninit"));
    let end = end.expect("an end of the static variables").address() as u32;
    let mut chip = armed_axle();
    let before = chip.memory(end, 1_024);
    chip.overflow_stack(end + 1_040);
    // The thread wakes at the next current interrupt.
    chip.run(100);
    assert!(!chip.is_live(), "the bridge is live");
    assert_eq!(chip.resets(), 0);
    assert_eq!(chip.memory(end, 512), before[..512], "the stack went on");
    let line = log(&chip).pop();
    assert_eq!(line.as_deref(), Some("the stack has overflowed"));
    chip.run(110_000);
    assert!(chip.resets() > 0 && !chip.is_live());
    assert_eq!(read(&mut chip, 0x603f), 0x5220);
}

#[test]
fn the_last_faults_survive_a_reset_with_what_was_measured() {
    let entry = |chip: &mut Chip, sub| checks::read(chip, NODE, 0x1003, sub);
    let shown = |chip: &mut Chip, sub| checks::read(chip, NODE, 0x2021, sub);
    let mut chip = armed_axle();
    // 32.2 V, behind the divider of 169 and 18 kiloohm.
    chip.pins(|pins| pins.supply = 3_847);
    chip.run(3_000);
    // Above the code is the cause of the reset: power-up.
    let over_voltage = 1 << 16 | 0x3210;
    assert_eq!(entry(&mut chip, 0), 1);
    assert_eq!(entry(&mut chip, 1), over_voltage);
    chip.pins(|pins| pins.supply = 2_866);
    chip.brown_out();
    chip.run(45_000);
    assert_eq!(entry(&mut chip, 1), over_voltage);
    chip.jump(panic_instruction());
    chip.run(110_000);
    assert_eq!(entry(&mut chip, 0) & 0xff, 2);
    // The watchdog, after the program had failed.
    assert_eq!(entry(&mut chip, 1), 5 << 16 | 0x5220);
    assert_eq!(entry(&mut chip, 2), over_voltage);
    checks::write(&mut chip, NODE, 0x2021, 1, &[2]);
    assert_eq!(shown(&mut chip, 2) & 0xffff, 0x3210);
    let millivolts = shown(&mut chip, 5) & 0xffff;
    assert!((31_900..32_500).contains(&millivolts), "{millivolts} mV");
    checks::write(&mut chip, NODE, 0x1003, 0, &[0]);
    chip.brown_out();
    chip.run(45_000);
    assert_eq!(entry(&mut chip, 0) & 0xff, 0);
}

#[test]
pub fn after_a_brown_out_the_gates_stay_off_and_it_is_named() {
    resets_and_stays_open(
        "brown-out",
        Chip::brown_out,
        "reset by power-up or brown-out",
    );
}

#[test]
pub fn after_a_reset_by_the_watchdog_the_gates_stay_off_and_it_is_named() {
    let mut chip = armed_axle();
    chip.hang();
    chip.run(60_000);
    assert_eq!(chip.resets(), 1);
    assert!(!chip.is_live());
    chip.run(60_000);
    let lines = log(&chip);
    assert!(
        lines.iter().any(|line| line == "reset by watchdog"),
        "{lines:?}"
    );
    stays_open(&mut chip, "watchdog");
}

#[test]
pub fn a_current_interrupt_that_stops_is_a_reset() {
    let mut chip = armed_axle();
    // Without the trigger there is no current interrupt; the other two parties go on.
    chip.stop_trigger();
    chip.run(60_000);
    assert_eq!(chip.resets(), 1);
    assert!(!chip.is_live());
}
