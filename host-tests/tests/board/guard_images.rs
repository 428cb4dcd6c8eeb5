//! The images of the guards: where they load, and how large they are.

use crate::chips::g474;
use crate::footprint::SPARE;
use crate::stamp;
use clap::ValueEnum;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use std::fs;
use std::sync::OnceLock;
use tautrack_host_tests::programs::settings_pages::{GUARD_ADDRESS, LENGTH};
use tautrack_host_tests::programs::{Program, flash, guard_board};
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::tools::footprint::measure_guards;

/// First bank of the flash memory, of which a program may take 192 KiB.
const PROGRAM: std::ops::Range<u32> = 0x0800_0000..0x0803_0000;
const SECOND_BANK: u32 = 0x0804_0000;
const RAM_END: u32 = 0x2002_0000;

/// The guards, in the order of the robots, built once.
pub fn guards() -> &'static [Program] {
    static PROGRAMS: OnceLock<Vec<Program>> = OnceLock::new();
    PROGRAMS.get_or_init(|| {
        let names: Vec<_> = Kind::value_variants()
            .iter()
            .map(|robot| robot.facts().guard_program)
            .collect();
        guard_board(&names).unwrap_or_else(|error| panic!("{error}"))
    })
}

#[test]
fn only_the_simulator_finds_the_roles_of_the_drives_in_a_guard() {
    for program in guards() {
        let elf = fs::read(&program.path).expect("a program");
        let elf = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let names: Vec<_> = elf
            .symbols()
            .filter_map(|symbol| symbol.name().ok())
            .collect();
        let of = |role: &str| names.iter().find(|name| name.contains(role));
        assert!(of("5roles5guard").is_some(), "symbols have other names");
        assert_eq!((of("5roles4axle"), of("5roles5screw")), (None, None));
    }
}

#[test]
fn every_guard_loads_where_the_chip_starts_and_leaves_the_second_bank_to_the_settings() {
    assert_eq!(guards().len(), 4);
    for program in guards() {
        let path = program.path.display();
        let elf = fs::read(&program.path).expect("a program");
        let segments = flash::segments(&elf).expect("an image");
        assert_eq!(segments[0].address, PROGRAM.start, "{path}");
        for segment in &segments {
            let end = segment.address + segment.bytes.len() as u32;
            assert!(end <= PROGRAM.end, "{path}: {end:#x}");
        }
        let word = |index: usize| {
            let bytes = &segments[0].bytes[4 * index..4 * index + 4];
            u32::from_le_bytes(bytes.try_into().expect("a word"))
        };
        assert_eq!(word(0), RAM_END, "{path}: initial stack pointer");
        assert!(PROGRAM.contains(&word(1)) && word(1) % 2 == 1, "{path}");
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let table = file.section_by_name(".vector_table").expect("vectors");
        // 15 exceptions of the core and 102 interrupts of the chip.
        assert_eq!(table.size(), 4 * (16 + 102), "{path}");
    }
}

#[test]
fn the_settings_pages_are_the_last_ones_of_the_second_bank() {
    let memories = g474::memories();
    let bank = (SECOND_BANK, 256 * 1024);
    assert!(memories.contains(&bank), "{memories:x?}");
    assert_eq!(GUARD_ADDRESS + LENGTH as u32, SECOND_BANK + bank.1);
}

#[test]
fn every_guard_keeps_its_limits() {
    let Some(_stamp) = stamp("every_guard_keeps_its_limits") else {
        return;
    };
    for row in measure_guards().expect("a measurement") {
        println!("{row:?}");
        assert_eq!(row.excesses(), Vec::<String>::new());
        let length = PROGRAM.end - PROGRAM.start;
        assert!(row.flash_limit + SPARE <= length, "{row:?}");
        // Less the guard at the end of the stack.
        assert!((127 * 1024..128 * 1024).contains(&row.ram), "{row:?}");
        assert!(row.stack > 0 && row.stack <= row.nested_stack, "{row:?}");
    }
}
