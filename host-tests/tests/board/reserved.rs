//! No image writes a reserved bit, but those of a list: the register description of the chip names
//! every bit that has a meaning.

use crate::chips::{g431, g474};
use crate::executed::{armed_axle, read, running_screw, write};
use crate::guard;
use crate::stamp;
use std::collections::{BTreeMap, BTreeSet};
use tautrack_host_tests::simulator::chip::{Chip, STM32G431, STM32G474};

/// Registers in which an image writes reserved bits, and why this does no harm.
const KNOWN: [(&str, &str); 2] = [
    (
        "FDCAN1.txbtie",
        "the library enables the interrupts of 32 buffers; the chip has three",
    ),
    ("TIM2.sr", "the library writes 1 to leave a flag as it is"),
];
/// The same of the guard.
const KNOWN_OF_THE_GUARD: [(&str, &str); 2] = KNOWN;

/// Registers in which the image of a chip wrote reserved bits.
fn violated(described: &BTreeMap<u32, (String, u32)>, chip: &Chip) -> BTreeSet<String> {
    chip.writes()
        .iter()
        .filter_map(|write| {
            let (name, bits) = described.get(&write.address)?;
            (write.value & !bits != 0).then(|| name.clone())
        })
        .collect()
}

#[test]
pub fn no_reserved_bit_is_written_but_those_of_a_list() {
    let mut axle = armed_axle();
    axle.pins(|pins| pins.safe_torque_off = false);
    axle.run(5_000);
    axle.pins(|pins| pins.safe_torque_off = true);
    write(&mut axle, 0x6040, 0, &[0, 0]);
    axle.run(20_000);
    let mut screw = running_screw();
    read(&mut screw, 0x6041);
    let described = g431::described();
    let violated: BTreeSet<_> = [&axle, &screw]
        .into_iter()
        .flat_map(|chip| violated(&described, chip))
        .collect();
    assert_eq!(violated, names(&KNOWN));
}

#[test]
fn the_guard_writes_no_reserved_bit_but_those_of_a_list() {
    let Some(_stamp) = stamp("the_guard_writes_no_reserved_bit_but_those_of_a_list") else {
        return;
    };
    let described = g474::described();
    let mut violations = BTreeSet::new();
    for mut chip in guard::running_guards() {
        chip.send_serial(b"$GPGGA*00\r\n", 115_200);
        guard::save(&mut chip);
        violations.extend(violated(&described, &chip));
    }
    assert_eq!(violations, names(&KNOWN_OF_THE_GUARD));
}

fn names(known: &[(&str, &str)]) -> BTreeSet<String> {
    known.iter().map(|(name, _)| (*name).to_owned()).collect()
}

#[test]
fn the_description_has_the_bits_of_the_manual() {
    let described = g431::described();
    // BDTR has 30 bits (RM0440, 29.6.20), GPIOA's MODER all 32, FDCAN's TXBAR three.
    assert_eq!(
        described[&0x4001_2c44],
        ("TIM1.bdtr".to_owned(), 0x3fff_ffff)
    );
    assert_eq!(
        described[&0x4800_0000],
        ("GPIOA.moder".to_owned(), u32::MAX)
    );
    assert_eq!(described[&0x4000_64cc], ("FDCAN1.txbar".to_owned(), 7));
    assert!(described.len() > 900, "{} registers", described.len());
}

#[test]
fn the_reset_values_are_those_of_registers_that_the_chip_has() {
    for (described, part) in [
        (g431::described(), STM32G431),
        (g474::described(), STM32G474),
    ] {
        for (name, address, value) in part.reset_values() {
            let (found, bits) = &described[&address];
            assert_eq!(found, name);
            // Bits that the description leaves out, although they are set after a reset.
            let reserved = match name {
                "PWR.cr5" | "SYSCFG.cfgr1" | "FLASH.optr" => u32::MAX,
                _ => 0,
            };
            assert_eq!(value & !bits & !reserved, 0, "{name}: {bits:#x}");
        }
    }
}
