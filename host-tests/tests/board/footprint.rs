//! `cargo footprint`: its figures and its limits.

use crate::images::programs;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionKind};
use std::fs;
use std::sync::OnceLock;
use tautrack_host_tests::tools::footprint::{Footprint, measure};

/// Bytes of its flash memory that each program leaves free.
pub const SPARE: u32 = 4 * 1024;

/// The figures, measured once.
fn footprints() -> &'static [Footprint; 3] {
    static FOOTPRINTS: OnceLock<[Footprint; 3]> = OnceLock::new();
    FOOTPRINTS.get_or_init(|| measure(programs()).expect("a measurement"))
}

#[test]
fn the_figures_are_those_of_the_sections_and_symbols() {
    let programs = programs();
    let paths = [&programs.axle, &programs.screw, &programs.loader];
    for (row, program) in footprints().iter().zip(paths) {
        let elf = fs::read(&program.path).expect("a program");
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let stored: u64 = file
            .sections()
            .filter(|section| {
                let address = section.address();
                let data = section.kind() != SectionKind::UninitializedData;
                address >= 0x0800_0000 && data && section.size() > 0
            })
            .filter(|section| !section.name().is_ok_and(|name| name.starts_with(".uninit")))
            .map(|section| section.size())
            .sum();
        // The linker fills the gaps between sections inside a segment.
        let flash = u64::from(row.flash);
        assert!((stored..stored + 64).contains(&flash), "{row:?}: {stored}");
        let symbol = |name: &str| {
            let mut symbols = file.symbols();
            let found = symbols.find(|symbol| symbol.name() == Ok(name));
            found.map(|symbol| symbol.address())
        };
        let end = symbol("__euninit").or_else(|| symbol("__ebss"));
        let end = end.expect("an end of the static variables") - 0x2000_0000;
        assert!(
            end.abs_diff(row.static_ram.into()) <= 4,
            "{row:?}: {end} bytes"
        );
    }
}

#[test]
fn every_program_keeps_its_limits() {
    for row in footprints() {
        println!("{row:?}");
        assert_eq!(row.excesses(), Vec::<String>::new());
        let kib = if row.program == "loader" { 16 } else { 104 };
        assert!(row.flash_limit + SPARE <= kib * 1024, "{row:?}");
        assert!(row.stack > 0 && row.nested_stack > 0, "{row:?}");
        // An interrupt never finds more stack used than all of them together.
        assert!(row.stack <= row.nested_stack, "{row:?}");
    }
}

#[test]
fn a_program_above_a_limit_is_named() {
    let [axle, ..] = footprints();
    for broken in [
        Footprint {
            flash_limit: axle.flash - 1,
            ..axle.clone()
        },
        Footprint {
            ram_limit: axle.static_ram + axle.stack - 1,
            ..axle.clone()
        },
        Footprint {
            nested_stack: 32 * 1024,
            ..axle.clone()
        },
    ] {
        let excesses = broken.excesses();
        assert_eq!(excesses.len(), 1, "{excesses:?}");
        assert!(excesses[0].starts_with("axle: "), "{excesses:?}");
    }
}
