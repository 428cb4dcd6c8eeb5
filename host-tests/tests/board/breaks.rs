//! What opens the bridge without software, and what does not depend on the crystal.

use crate::checks::field;
use crate::chip::{ADC1_2, BDTR, CORE_HZ, Chip, Event, GPIO, MOE, TIM1, Write};
use crate::executed::{arm, armed_axle, panic_instruction, read, running_axle, write};
use crate::gates;
use crate::images::programs;
use std::fs;
use tautrack_host_tests::programs::flash;

/// Registers of the comparators 1, 2 and 4, and the number of TIM1's output 5 at each (RM0440,
/// table 195).
const COMPARATORS: [(u32, u32); 3] = [(0x4001_0200, 1), (0x4001_0204, 1), (0x4001_020c, 4)];

/// Checks that a cause opens the bridge of an armed axle within 2 us, and that it stays open.
fn opens(what: &str, cause: impl FnOnce(&mut Chip)) -> Chip {
    let mut chip = armed_axle();
    cause(&mut chip);
    chip.run(2);
    assert!(!chip.is_live(), "{what}: the bridge is live");
    chip.run(40_000);
    assert!(!chip.is_live(), "{what}: the bridge is live again");
    chip
}

#[test]
pub fn each_comparator_opens_the_bridge() {
    for phase in 0..3 {
        let mut chip = opens("comparator", |chip| {
            chip.pins(|pins| pins.over_current[phase] = true);
        });
        chip.pins(|pins| pins.over_current[phase] = false);
        chip.run(40_000);
        assert!(!chip.is_live(), "the bridge has closed by itself");
    }
}

#[test]
pub fn a_failed_crystal_opens_the_bridge_and_is_named() {
    let mut chip = armed_axle();
    chip.fail_crystal();
    chip.run(2);
    assert!(!chip.is_live());
    chip.run(2_000);
    let lines = gates::log(&chip);
    assert_eq!(
        lines.last().map(String::as_str),
        Some("the crystal has failed")
    );
    // The watchdog has a clock of its own.
    chip.run(60_000);
    assert!(chip.resets() > 0 && !chip.is_live());
}

#[test]
pub fn safe_torque_off_needs_no_clock() {
    let mut chip = armed_axle();
    // Nothing watches the crystal, so core and timers stop.
    chip.stop_clock_security();
    chip.fail_crystal();
    chip.run(10);
    assert!(chip.is_live());
    chip.pins(|pins| pins.safe_torque_off = false);
    chip.run(1);
    assert!(!chip.is_live());
}

#[test]
pub fn a_core_that_locks_up_opens_the_bridge() {
    opens("lock-up", |chip| chip.event(Event::LockUp));
}

#[test]
pub fn an_error_of_the_flash_memory_opens_the_bridge() {
    let chip = opens("flash", |chip| chip.event(Event::FlashError));
    // Not the handler alone: the timer has the break of the chip.
    assert_ne!(chip.register(TIM1 + 0x10) & 1 << 13, 0);
}

#[test]
pub fn a_low_supply_of_the_chip_opens_the_bridge() {
    opens("supply", |chip| chip.pins(|pins| pins.chip_supply = 2.8));
    let mut chip = armed_axle();
    chip.pins(|pins| pins.chip_supply = 3.1);
    chip.run(1_000);
    assert!(chip.is_live());
}

#[test]
pub fn the_comparators_have_a_filter_and_blanking_and_safe_torque_off_has_neither() {
    let chip = running_axle();
    let timer = |offset: u32| chip.register(TIM1 + offset);
    let bdtr = chip.register(BDTR);
    assert_eq!(field(bdtr, 16, 4), 0, "safe torque off has a filter");
    // 8 samples at an eighth of the clock: 0.4 us.
    assert_eq!(field(bdtr, 20, 4), 9);
    assert_eq!(field(bdtr, 24, 2), 3, "enabled, active high");
    assert_eq!(timer(0x60) & 0x3ff, 1 | 1 << 9, "the pin alone, inverted");
    assert_eq!(
        timer(0x64) & 0x3ff,
        0b1011 << 1,
        "comparators 1, 2 and 4 alone"
    );
    // Output 5 is high below 1 us of the counter.
    assert_eq!(u64::from(timer(0x48) & 0xffff), CORE_HZ / 1_000_000);
    assert_eq!(field(timer(0x50), 4, 3), 6, "PWM mode 1");
    assert_eq!(field(timer(0x20), 16, 1), 1);
    for (register, blanking) in COMPARATORS {
        let control = chip.register(register);
        assert_eq!(field(control, 19, 3), blanking, "{register:#x}");
        assert_eq!(control & 1, 1, "{register:#x}");
    }
}

#[test]
pub fn a_probe_that_halts_the_core_opens_the_bridge() {
    let mut chip = armed_axle();
    // A probe catches a fault of the core before its handler runs.
    chip.halt();
    chip.run(1_000);
    assert!(!chip.is_live());
    assert_ne!(chip.register(BDTR) & MOE, 0, "nothing has cleared the bit");
}

#[test]
pub fn a_break_just_before_the_bridge_is_enabled_opens_it_for_good() {
    for offset in [0, 7, 19, 31, 43] {
        let mut chip = armed_axle();
        chip.run(offset);
        chip.race();
        chip.run(100);
        for _ in 0..20 {
            assert!(!chip.is_live(), "{offset} us");
            chip.run(503);
        }
    }
}

/// Largest compare value: the low side conducts for 0.5 us, 85 clocks, behind a dead time of 102.
const HIGHEST: u32 = 4_250 - 94;
/// Core clocks of a PWM period.
const PERIOD: u64 = CORE_HZ / 20_000;
/// The newest code of the current of phase a.
const ADC1_PHASE_A: u32 = 0x5000_0080;
/// Compare registers of the half bridges.
const COMPARES: [u32; 3] = [TIM1 + 0x34, TIM1 + 0x38, TIM1 + 0x3c];

#[test]
pub fn a_bridge_that_is_armed_again_begins_without_voltage() {
    let mut chip = armed_axle();
    // A current that no voltage ends makes the current loop give all the voltage that it has.
    let zero = chip.register(ADC1_PHASE_A) as u16;
    chip.pins(|pins| pins.phase_a = zero + 40);
    let high = |chip: &Chip| {
        let compares = COMPARES.map(|compare| chip.register(compare));
        compares.into_iter().any(|compare| compare > 3_000)
    };
    for _ in 0..60 {
        if !high(&chip) {
            chip.run(100);
        }
    }
    assert!(chip.is_live() && high(&chip));
    chip.pins(|pins| pins.phase_a = zero);
    write(&mut chip, 0x6040, 0, &[0, 0]);
    write(&mut chip, 0x6040, 0, &[0x80, 0]);
    let stopped = chip.clock();
    arm(&mut chip);
    // The last start of the counter is an underflow.
    let writes = chip.writes();
    let start = writes
        .iter()
        .rfind(|write| write.address == TIM1 && write.value & 1 != 0);
    let start = start.expect("a start").clock;
    let live =
        |write: &&Write| write.clock > stopped && write.address == BDTR && write.value & MOE != 0;
    let armed = writes.iter().find(live).expect("an arming").clock;
    let underflow = armed - (armed - start) % PERIOD;
    for compare in COMPARES {
        let before = |write: &&Write| write.address == compare && write.clock < underflow;
        let acts = writes.iter().rfind(before).expect("a compare value");
        assert_eq!(acts.value, 2_125, "{compare:#x}");
    }
}

#[test]
pub fn each_low_side_conducts_long_enough_for_a_sample_and_the_driver_of_its_high_side() {
    for codes in [[60, -60], [-60, 60]] {
        let mut chip = armed_axle();
        let from = chip.clock();
        // Currents that no voltage ends: the current loop gives all the voltage that it has.
        chip.pins(|pins| {
            pins.phase_a = pins.phase_a.wrapping_add_signed(codes[0]);
            pins.phase_b = pins.phase_b.wrapping_add_signed(codes[1]);
        });
        chip.run(6_000);
        let writes = chip.writes();
        let compares = writes
            .iter()
            .filter(|write| write.clock > from && COMPARES.contains(&write.address));
        let largest = compares
            .map(|write| write.value)
            .max()
            .expect("compare values");
        assert!((3_700..=HIGHEST).contains(&largest), "{codes:?}: {largest}");
    }
}

/// What happens to a chip.
type Cause = fn(&mut Chip);

/// Fault of the drive (object 0x603f), and whether the log has it.
fn fault(chip: &mut Chip) -> (u32, bool) {
    let code = read(chip, 0x603f);
    let line = format!("fault {code:#06x}");
    (code, gates::log(chip).contains(&line))
}

#[test]
pub fn the_drive_says_at_once_what_has_opened_its_bridge_also_without_a_current() {
    let causes: [(u32, Cause); 3] = [
        (0xff20, |chip| {
            chip.pins(|pins| pins.safe_torque_off = false);
        }),
        (0x2340, |chip| chip.pins(|pins| pins.over_current[2] = true)),
        (0x5220, |chip| chip.pins(|pins| pins.chip_supply = 2.8)),
    ];
    for (code, cause) in causes {
        let mut chip = armed_axle();
        cause(&mut chip);
        chip.run(2_000);
        assert_eq!(fault(&mut chip), (code, true));
    }
}

#[test]
pub fn a_drive_that_was_reset_after_a_failure_says_so() {
    let failures: [Cause; 6] = [
        |chip| chip.event(Event::FlashError),
        |chip| chip.event(Event::LockUp),
        |chip| chip.hang_in(16 + ADC1_2),
        Chip::hang,
        |chip| chip.jump(panic_instruction()),
        |chip| {
            chip.fail_crystal();
            chip.run(10_000);
            chip.mend_crystal();
        },
    ];
    for fail in failures {
        let mut chip = armed_axle();
        fail(&mut chip);
        while chip.resets() == 0 {
            chip.run(1_000);
        }
        chip.run(45_000);
        assert_eq!(fault(&mut chip), (0x5220, true));
        // A reset of the fault ends it.
        write(&mut chip, 0x6040, 0, &[0, 0]);
        write(&mut chip, 0x6040, 0, &[0x80, 0]);
        chip.run(5_000);
        assert_eq!(read(&mut chip, 0x603f), 0);
    }
}

#[test]
fn the_loader_flashes_its_led_when_the_flash_memory_has_an_error() {
    let loader = fs::read(&programs().loader.path).expect("the loader");
    let segments = flash::segments(&loader).expect("an image");
    let mut chip = Chip::new(&segments, 0x0800_0000);
    chip.run(100);
    chip.event(Event::FlashError);
    chip.run(200_000);
    // Output data of port C, PC6.
    let writes = chip.writes();
    let led = writes.iter().filter(|write| write.address == GPIO + 0x814);
    let levels: Vec<_> = led.map(|write| write.value >> 6 & 1).collect();
    assert!(levels.contains(&0) && levels.contains(&1), "{levels:?}");
}
