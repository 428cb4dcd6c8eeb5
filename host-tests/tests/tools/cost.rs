//! Tests the counts of the control code on the core, and that the control ticks reach no forbidden
//! functions.

use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol, SymbolKind};
use std::fs;
use tautrack_host_tests::programs;
use tautrack_host_tests::tools::cost::ceilings::Ceilings;
use tautrack_host_tests::tools::cost::counts::{Count, count};

#[test]
fn every_count_keeps_its_ceiling() {
    let counts = count().unwrap_or_else(|error| panic!("{error}"));
    let maxima = [&counts[0], &counts[1]].map(|count| (&count.name[..], count.maximum));
    assert_eq!(maxima, [("empty call", 0), ("ten nops", 10)]);
    let excesses = Ceilings::read().expect("ceilings").excesses(&counts);
    assert!(excesses.is_empty(), "\n{}", excesses.join("\n"));
}

#[test]
fn a_count_above_its_ceiling_and_a_ceiling_without_a_count_are_named() {
    let ceilings = Ceilings::read().expect("ceilings");
    let counts = ceilings.instructions.iter().map(|(name, ceiling)| Count {
        name: name.clone(),
        minimum: 0,
        maximum: *ceiling,
        mean: 0,
    });
    let mut counts: Vec<_> = counts.collect();
    assert_eq!(ceilings.excesses(&counts), Vec::<String>::new());
    counts[0].maximum += 1;
    let missing = counts.remove(1).name;
    let excesses = ceilings.excesses(&counts);
    assert_eq!(excesses.len(), 2, "{excesses:?}");
    assert!(excesses[0].starts_with(&counts[0].name), "{excesses:?}");
    assert!(excesses[1].starts_with(&missing), "{excesses:?}");
}

/// Parts of the names of functions that no control tick may reach, and what these functions are.
const FORBIDDEN: [(&str, &str); 12] = [
    ("__aeabi_d", "double precision in software"),
    ("__aeabi_f2d", "double precision in software"),
    ("df3", "double precision in software"),
    ("ldivmod", "64-bit division"),
    ("divdi3", "64-bit division"),
    ("moddi", "64-bit division"),
    ("divti3", "128-bit division"),
    ("u64_div_rem", "64-bit division"),
    ("a_tick_can_panic", "a panic"),
    ("panic", "a panic"),
    ("4core3fmt", "formatting"),
    ("alloc", "allocation"),
];

#[test]
fn no_tick_reaches_double_precision_long_division_panics_formatting_or_allocation() {
    let programs = programs::instruments().unwrap_or_else(|error| panic!("{error}"));
    let elf = fs::read(programs.ticks.path).expect("it was built");
    let elf = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
    let functions: Vec<_> = elf
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text)
        .filter_map(|symbol| symbol.name().ok())
        .collect();
    for tick in ["4Axle14tick_following", "5guard10evaluation"] {
        let linked = functions.iter().any(|function| function.contains(tick));
        assert!(linked, "no function of {tick} is linked");
    }
    let reached: Vec<String> = functions
        .iter()
        .flat_map(|name| {
            // The hash at the end of a name is any text of 16 hexadecimal digits.
            let name = name.rsplit_once("17h").map_or(*name, |(name, _)| name);
            let found = FORBIDDEN
                .iter()
                .filter(move |(part, _)| name.contains(part));
            found.map(move |(_, what)| format!("{what}: {name}"))
        })
        .collect();
    assert!(reached.is_empty(), "\n{}", reached.join("\n"));
}
