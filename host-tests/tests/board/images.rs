//! The images that are flashed: where they load, how large they are, and what is not in them.

use crate::guard_images::guards;
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use std::fs;
use std::sync::OnceLock;
use tautrack_host_tests::programs::{MotorBoard, Program, guard_board, motor_board};
use tautrack_host_tests::robots::Kind;

/// The application's flash memory.
pub const APPLICATION: std::ops::Range<u64> = 0x0800_4000..0x0801_e000;
/// The loader's flash memory.
const LOADER: std::ops::Range<u64> = 0x0800_0000..0x0800_4000;
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2000_8000;
/// Bytes that static variables may take: 25 KiB with the stack, of which the executed images use
/// less than 6 KiB.
const MAX_STATIC_RAM: u64 = 18 * 1024;

/// The programs, built once.
pub fn programs() -> &'static MotorBoard {
    static PROGRAMS: OnceLock<MotorBoard> = OnceLock::new();
    PROGRAMS.get_or_init(|| motor_board().unwrap_or_else(|error| panic!("{error}")))
}

/// Name and bytes of each application.
fn applications() -> [(&'static str, Vec<u8>); 2] {
    let programs = programs();
    [("axle", &programs.axle), ("screw", &programs.screw)]
        .map(|(name, program)| (name, fs::read(&program.path).expect("a program")))
}

/// Load address and length of what is flashed.
fn segments(elf: &[u8]) -> Vec<(u64, u64)> {
    let file = ElfFile32::<Endianness>::parse(elf).expect("an ELF file");
    let endian = file.endian();
    let headers = file
        .elf_header()
        .program_headers(endian, elf)
        .expect("program headers");
    headers
        .iter()
        .filter(|header| header.p_type(endian) == object::elf::PT_LOAD)
        .map(|header| {
            let address = header.p_paddr(endian).into();
            (address, u64::from(header.p_filesz(endian)))
        })
        .filter(|(_, length)| *length > 0)
        .collect()
}

#[test]
fn every_image_fits_its_part_of_the_flash_memory() {
    for (name, elf) in applications() {
        let segments = segments(&elf);
        assert!(!segments.is_empty());
        for (address, length) in segments {
            let end = address + length;
            let inside = APPLICATION.contains(&address) && end <= APPLICATION.end;
            assert!(inside, "{name}: {address:#x} to {end:#x}");
        }
    }
    let loader = fs::read(&programs().loader.path).expect("the loader");
    for (address, length) in segments(&loader) {
        assert!(LOADER.contains(&address) && address + length <= LOADER.end);
    }
}

#[test]
fn static_variables_leave_room_for_the_stack() {
    for (name, elf) in applications() {
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let used: u64 = file
            .sections()
            .filter(|section| RAM.contains(&section.address()))
            .map(|section| section.size())
            .sum();
        assert!(used > 0 && used <= MAX_STATIC_RAM, "{name}: {used} bytes");
    }
}

#[test]
fn the_vector_table_and_the_header_are_where_the_loader_reads_them() {
    for (name, elf) in applications() {
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let section = |wanted: &str| {
            file.section_by_name(wanted)
                .unwrap_or_else(|| panic!("{name} has no {wanted}"))
        };
        let table = section(".vector_table");
        assert_eq!(table.address(), APPLICATION.start, "{name}");
        let word = |index: usize| {
            let data = table.data().expect("bytes");
            u64::from(u32::from_le_bytes(
                data[4 * index..4 * index + 4].try_into().expect("a word"),
            ))
        };
        assert_eq!(word(0), RAM.end, "{name}: initial stack pointer");
        assert!(
            APPLICATION.contains(&word(1)) && word(1) % 2 == 1,
            "{name}: reset vector"
        );
        // 15 exceptions of the core and 102 interrupts of the chip.
        assert_eq!(table.size(), 4 * (16 + 102), "{name}");
        let header = section(".image_header");
        assert_eq!(header.address(), APPLICATION.start + 0x1e0, "{name}");
        assert_eq!(&header.data().expect("bytes")[..4], b"TTIM", "{name}");
    }
}

#[test]
fn no_image_contains_the_link_of_the_simulator_or_formats_numbers() {
    for (name, elf) in applications() {
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let mut count = 0;
        for symbol in file.symbols() {
            let symbol = symbol.name().unwrap_or_default();
            count += 1;
            for forbidden in [
                "lockstep",
                "postcard",
                "semihosting",
                "tautrack4link",
                "motor5model",
                "float_to_decimal",
                "flt2dec",
            ] {
                assert!(!symbol.contains(forbidden), "{name}: {symbol}");
            }
        }
        assert!(count > 100, "{name} has no symbols");
    }
}

/// Cargo builds a program again if a variable that a build script reads has another value.
#[test]
fn no_image_makes_cargo_build_another_one_again() {
    let written = |program: &Program| {
        let metadata = fs::metadata(&program.path).expect("a program");
        metadata.modified().expect("a time")
    };
    let images = || {
        let [axle, guard] = [&programs().axle, &guards()[0]];
        [axle, guard].map(written)
    };
    let before = images();
    motor_board().expect("programs of the motor board");
    guard_board(&[Kind::B2p2.facts().guard_program]).expect("a guard");
    assert_eq!(images(), before);
}
