//! What the settings pages hold after resets and power cuts. The image that is executed writes
//! them, through the model of the flash controller.

use crate::analogue::THRESHOLDS;
use crate::chip::{Chip, Cut, TIM1, Tear};
use crate::executed::{
    NODE, application, arm, armed_axle, axle, frame, read, waits_for_an_id, with_pages, write,
};
use crate::gates::log;
use crate::images::programs;
use crate::stamp;
use tautrack::settings::{Effect, FIRST_OBJECT, Setting};
use tautrack_host_tests::programs::settings_pages::{self, ADDRESS, LENGTH, Pages};
use tautrack_host_tests::robots::Role;

pub const SAVE: u16 = 0x1010;
const RESTORE: u16 = 0x1011;
/// What was found in the flash memory at start.
const IN_FLASH: u16 = 0x2020;
/// Abort code of CiA 301: not in this state of the device.
const DEVICE_STATE: u32 = 0x0800_0022;
const BENCH_MODE: u16 = 0x2001;
const CONTROLWORD: u16 = 0x6040;
const MODE: u16 = 0x6060;
/// Time for a start, or for a save, us.
const WAIT_US: u64 = 20_000;

pub fn object(setting: Setting) -> u16 {
    FIRST_OBJECT + setting.bounds().key
}

fn pages(chip: &Chip) -> Vec<u8> {
    chip.memory(ADDRESS, LENGTH)
}

/// The chip after its supply was switched off and on.
fn power_cycled(chip: &Chip) -> Chip {
    let mut next = with_pages(&programs().axle, &pages(chip));
    next.tear(&chip.torn());
    next.run(WAIT_US);
    next.take_sent();
    next
}

/// Sends a download of four bytes, and returns the command and the value of the answer, if one
/// comes.
fn download(chip: &mut Chip, index: u16, sub: u8, value: [u8; 4]) -> Option<(u8, u32)> {
    download_to(chip, NODE, index, sub, value)
}

/// The same, to any node.
pub fn download_to(
    chip: &mut Chip,
    node: u16,
    index: u16,
    sub: u8,
    value: [u8; 4],
) -> Option<(u8, u32)> {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value;
    chip.take_sent();
    chip.send(frame(0x600 + node, &[0x23, low, high, sub, a, b, c, d]));
    // A save that turns the page takes longer than others.
    for _ in 0..40 {
        chip.run(5_000);
        let sent = chip.take_sent();
        if let Some((_, answer)) = sent.iter().find(|(_, sent)| sent.id() == 0x580 + node) {
            let value = answer.data()[4..8].try_into().expect("four bytes");
            return Some((answer.data()[0], u32::from_le_bytes(value)));
        }
    }
    None
}

#[test]
fn a_saved_setting_survives_a_reset_and_a_restored_node_is_blank() {
    let Some(_stamp) = stamp("a_saved_setting_survives_a_reset_and_a_restored_node_is_blank")
    else {
        return;
    };
    for (role, program) in [
        (Role::Axle, &programs().axle),
        (Role::Screw, &programs().screw),
    ] {
        let mut chip = application(program, role);
        chip.run(45_000);
        write(
            &mut chip,
            object(Setting::PositionGain),
            0,
            &12_345_i32.to_le_bytes(),
        );
        assert_eq!(read(&mut chip, IN_FLASH) & 0xff, 7, "highest sub-index");
        assert_eq!(download(&mut chip, SAVE, 1, *b"save"), Some((0x60, 0)));
        assert_eq!(chip.resets(), 0, "the watchdog bites during the save");
        let mut chip = with_pages(program, &pages(&chip));
        chip.run(45_000);
        assert_eq!(read(&mut chip, object(Setting::PositionGain)), 12_345);
        assert_eq!(download(&mut chip, RESTORE, 1, *b"load"), Some((0x60, 0)));
        let mut chip = with_pages(program, &pages(&chip));
        chip.run(45_000);
        assert!(waits_for_an_id(&mut chip));
    }
}

#[test]
fn a_node_id_from_lss_survives_a_reset() {
    let mut chip = with_pages(&programs().axle, &[0xff; LENGTH]);
    chip.run(WAIT_US);
    assert!(waits_for_an_id(&mut chip));
    // Configuration; node id 5; store; waiting.
    for request in [[0x04, 1], [0x11, NODE as u8], [0x17, 0], [0x04, 0]] {
        let [command, value] = request;
        chip.send(frame(0x7e5, &[command, value, 0, 0, 0, 0, 0, 0]));
        chip.run(WAIT_US);
    }
    let stored = frame(0x7e4, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    let boot_up = frame(0x700 + NODE, &[0]);
    let sent = chip.take_sent();
    for wanted in [stored, boot_up] {
        assert!(sent.iter().any(|(_, frame)| *frame == wanted), "{sent:x?}");
    }
    let mut chip = with_pages(&programs().axle, &pages(&chip));
    chip.run(WAIT_US);
    let sent = chip.take_sent();
    assert!(sent.iter().any(|(_, frame)| *frame == boot_up), "{sent:x?}");
}

#[test]
fn the_settings_pages_are_not_written_while_the_drive_is_armed() {
    let Some(_stamp) = stamp("the_settings_pages_are_not_written_while_the_drive_is_armed") else {
        return;
    };
    let mut chip = armed_axle();
    write(
        &mut chip,
        object(Setting::PositionGain),
        0,
        &12_345_i32.to_le_bytes(),
    );
    for (object, signature) in [(SAVE, b"save"), (RESTORE, b"load")] {
        let answer = download(&mut chip, object, 1, *signature);
        assert_eq!(answer, Some((0x80, DEVICE_STATE)), "{object:#x}");
    }
    assert_eq!(chip.flash(|flash| flash.operations), 0);
    assert!(chip.is_live());
}

/// Saves two changed settings on a chip with this cut. Returns it without power, if it was cut.
fn saving(pages: &[u8], cut: Option<Cut>) -> Chip {
    let mut chip = with_pages(&programs().axle, pages);
    chip.run(WAIT_US);
    for (setting, value) in NEW {
        write(&mut chip, object(setting), 0, &value.to_le_bytes());
    }
    assert_eq!(chip.flash(|flash| flash.operations), 0);
    chip.flash(|flash| flash.cut = cut);
    let answer = download(&mut chip, SAVE, 1, *b"save");
    let cut = chip.flash(|flash| flash.is_dead());
    assert_eq!(chip.resets(), 0, "the watchdog bites during the save");
    assert!(cut || answer == Some((0x60, 0)), "{answer:x?}");
    chip
}

const NEW: [(Setting, i32); 2] = [(Setting::PositionGain, 7), (Setting::VelocityGain, 9)];

#[test]
fn a_power_cut_in_any_write_of_a_save_leaves_old_or_new_settings() {
    let Some(_stamp) = stamp("a_power_cut_in_any_write_of_a_save_leaves_old_or_new_settings")
    else {
        return;
    };
    let start = pages(&axle());
    let old = NEW.map(|(setting, _)| {
        let mut chip = with_pages(&programs().axle, &start);
        chip.run(WAIT_US);
        read(&mut chip, object(setting)) as i32
    });
    let operations = saving(&start, None).flash(|flash| flash.operations);
    assert!(operations > 5, "{operations}");
    for at in 0..operations {
        for tear in [Tear::Nothing, Tear::Half, Tear::All] {
            let chip = saving(&start, Some(Cut { at, tear }));
            let mut chip = power_cycled(&chip);
            assert_eq!(chip.resets(), 0, "{tear:?} of operation {at}");
            for ((setting, new), old) in NEW.into_iter().zip(old) {
                let value = read(&mut chip, object(setting)) as i32;
                let whole = value == new || value == old;
                assert!(whole, "{tear:?} of operation {at}: {value}");
            }
            // The next save succeeds.
            let answer = download(&mut chip, SAVE, 1, *b"save");
            assert_eq!(answer, Some((0x60, 0)), "{tear:?} of operation {at}");
        }
    }
}

#[test]
fn a_torn_word_that_a_save_reads_is_no_event_of_the_processor() {
    /// Flag of a break by the processor in the status register of the timer.
    const PROCESSOR: u32 = 1 << 13;
    let start = pages(&axle());
    let (at, tear) = (2, Tear::Half);
    let chip = saving(&start, Some(Cut { at, tear }));
    let mut chip = power_cycled(&chip);
    for control in [0x06, 0x07] {
        write(&mut chip, CONTROLWORD, 0, &[control, 0]);
    }
    chip.send(frame(0x600 + NODE, b"\x23\x10\x10\x01save"));
    let (errors, mut flagged) = (chip.flash_errors(), 0);
    for _ in 0..100_000 {
        chip.run(1);
        let flag = chip.register(TIM1 + 0x10) & PROCESSOR != 0;
        flagged = if flag { flagged + 1 } else { 0 };
        assert!(flagged < 3, "the flag stays");
    }
    assert!(chip.flash_errors() > errors, "no torn word was read");
    assert_eq!((chip.resets(), read(&mut chip, 0x603f)), (0, 0));
}

/// The command to arm comes just before that to save, at every phase of the control task, which
/// interrupts the task that saves.
#[test]
fn nothing_arms_a_drive_while_its_flash_is_written() {
    let Some(_stamp) = stamp("nothing_arms_a_drive_while_its_flash_is_written") else {
        return;
    };
    let (mut saved, mut armed) = (0, 0);
    let cases = (0..1_000).step_by(100);
    for (phase_us, gap_us) in cases.flat_map(|phase| [(phase, 0), (phase, 500)]) {
        let mut chip = axle();
        chip.run(20_000);
        write(&mut chip, BENCH_MODE, 0, &[1]);
        write(&mut chip, MODE, 0, &[9]);
        for control in [0x06, 0x07] {
            write(&mut chip, CONTROLWORD, 0, &[control, 0]);
        }
        let (setting, value) = NEW[0];
        write(&mut chip, object(setting), 0, &value.to_le_bytes());
        chip.run(phase_us);
        let enable = [0x2b, 0x40, 0x60, 0, 0x0f, 0, 0, 0];
        chip.send(frame(0x600 + NODE, &enable));
        chip.run(gap_us);
        chip.send(frame(0x600 + NODE, b"\x23\x10\x10\x01save"));
        let mut writes = 0;
        for _ in 0..1_500 {
            let live = chip.is_live();
            let before = chip.flash(|flash| flash.operations);
            chip.run(10);
            let after = chip.flash(|flash| flash.operations);
            let idle = after == before;
            assert!(
                idle || !(live || chip.is_live()),
                "flash is written under power: phase {phase_us} us, gap {gap_us} us"
            );
            writes += after - before;
            armed += usize::from(chip.is_live() && !live);
        }
        saved += usize::from(writes > 0);
    }
    assert!(saved > 0 && armed > 0, "{saved} saved, {armed} armed");
}

#[test]
fn no_flash_operation_begins_while_the_bridge_is_live() {
    let mut chip = armed_axle();
    let mut random = 1_u32;
    let mut draw = |bound: u32| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        u64::from((random >> 8) % bound)
    };
    let save = frame(
        0x600 + NODE,
        &[&[0x23, 0x10, 0x10, 1], &b"save"[..]].concat(),
    );
    let disarm = frame(0x600 + NODE, &[0x2b, 0x40, 0x60, 0, 0, 0, 0, 0]);
    let (mut saved, mut operations) = (0, 0);
    for round in 0..50_i32 {
        // Between two ticks, and around the PWM period in which the bridge opens.
        chip.run(draw(1_000));
        let after = draw(2_300);
        for (delay, frame) in if draw(8) == 0 {
            [(after, save), (0, disarm)]
        } else {
            [(after, disarm), (0, save)]
        } {
            chip.send(frame);
            chip.run(delay);
        }
        chip.run(40_000);
        let now = chip.flash(|memory| memory.operations);
        saved += u32::from(now != operations);
        operations = now;
        assert_eq!(
            chip.changed_while_live(),
            0,
            "round {round}, after {after} us"
        );
        let gain = object(Setting::PositionGain);
        write(&mut chip, gain, 0, &(10_000 + round).to_le_bytes());
        arm(&mut chip);
    }
    assert!(saved > 10, "{saved}");
}

#[test]
fn a_node_has_the_defaults_of_its_board_and_refuses_what_the_board_does_not_bear() {
    let mut chip = axle();
    chip.run(WAIT_US);
    for (setting, default) in [
        (Setting::OverVoltage, 25_000),
        (Setting::RegenerationVoltage, 23_000),
        (Setting::BridgeTemperature, 800),
    ] {
        assert_eq!(read(&mut chip, object(setting)), default, "{setting:?}");
    }
    for (setting, value) in [
        (Setting::OverVoltage, 31_000),
        (Setting::DeadTime, 0),
        (Setting::BridgeTemperature, 300),
        (Setting::BrakeReleaseTime, 40),
        (Setting::MotorTemperature, 900),
    ] {
        let mut pages = Pages::erased();
        pages
            .save(&[(Setting::NodeId, NODE.into()), (setting, value)])
            .expect("settings");
        let mut chip = with_pages(&programs().axle, &pages.0);
        chip.run(WAIT_US);
        let refused = format!("refused: {}", setting.description().name);
        assert!(log(&chip).contains(&refused), "{:?}", log(&chip));
    }
}

#[test]
fn a_stored_value_counts_although_it_is_the_default_of_the_table_and_not_of_the_board() {
    let zero = Setting::CurrentZeroA;
    let value = zero.bounds().default;
    // As `cargo flash-node` writes it.
    let stored = Pages::of(&[(Setting::NodeId, NODE.into()), (zero, value)]).expect("settings");
    let mut chip = with_pages(&programs().axle, &stored.0);
    chip.run(WAIT_US);
    assert_eq!(read(&mut chip, object(zero)), value.unsigned_abs());
    // As a client saves it.
    let mut chip = axle();
    chip.run(WAIT_US);
    assert_ne!(read(&mut chip, object(zero)), value.unsigned_abs());
    write(&mut chip, object(zero), 0, &value.to_le_bytes());
    let saved = download(&mut chip, SAVE, 1, *b"save");
    assert_eq!(saved.map(|(command, _)| command), Some(0x60));
    let mut chip = power_cycled(&chip);
    assert_eq!(read(&mut chip, object(zero)), value.unsigned_abs());
}

#[test]
fn a_written_current_limit_moves_the_threshold_of_the_comparators_at_once() {
    let mut chip = axle();
    chip.run(WAIT_US);
    let codes = |chip: &Chip| THRESHOLDS.map(|register| chip.register(register));
    let before = codes(&chip);
    let limit = read(&mut chip, object(Setting::CurrentLimit));
    let half = limit.cast_signed() / 2;
    write(
        &mut chip,
        object(Setting::CurrentLimit),
        0,
        &half.to_le_bytes(),
    );
    chip.run(2_000);
    let after = codes(&chip);
    // A start with this limit sets the same.
    assert_ne!(before, after);
    let saved = download(&mut chip, SAVE, 1, *b"save");
    assert_eq!(saved.map(|(command, _)| command), Some(0x60));
    assert_eq!(codes(&power_cycled(&chip)), after);
}

/// The board's program checks only the bounds of the table, and what the board can measure, before
/// it uses a value at once.
#[test]
fn no_setting_that_takes_effect_at_once_has_narrower_bounds_on_the_board() {
    for limit in settings_pages::motor_board::LIMITS {
        assert_eq!(limit.setting.effect(), Effect::Restart, "{}", limit.name);
    }
}
