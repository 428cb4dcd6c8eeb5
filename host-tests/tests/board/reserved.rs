//! No image writes a reserved bit, but those of a list: the register description of the chip names
//! every bit that has a meaning.

use crate::executed::{armed_axle, read, running_screw, write};
use std::collections::{BTreeMap, BTreeSet};
use stm32_metapac::metadata::ir::{Array, BitOffset, Block, BlockItemInner, FieldSet, IR};
use stm32_metapac::metadata::{METADATA, Peripheral};
use tautrack_host_tests::simulator::chip::{Chip, RESET_VALUES};

/// Registers in which an image writes reserved bits, and why this does no harm.
const KNOWN: [(&str, &str); 2] = [
    (
        "FDCAN1.txbtie",
        "the library enables the interrupts of 32 buffers; the chip has three",
    ),
    ("TIM2.sr", "the library writes 1 to leave a flag as it is"),
];

/// Name and meaningful bits of the registers, by their addresses.
fn described() -> BTreeMap<u32, (String, u32)> {
    let mut found = BTreeMap::new();
    for peripheral in METADATA.peripherals {
        if let Some(registers) = &peripheral.registers {
            let wanted = plain(registers.block);
            let block = registers
                .ir
                .blocks
                .iter()
                .find(|it| plain(it.name) == wanted);
            if let Some(block) = block {
                describe(peripheral, registers.ir, block, &mut found);
            }
        }
    }
    found
}

/// A name without what distinguishes its spellings.
fn plain(name: &str) -> String {
    name.replace('_', "").to_lowercase()
}

fn describe(
    peripheral: &Peripheral,
    ir: &IR,
    block: &Block,
    found: &mut BTreeMap<u32, (String, u32)>,
) {
    if let Some(parent) = block.extends {
        let parent = plain(parent);
        let parent = ir.blocks.iter().find(|it| plain(it.name) == parent);
        describe(peripheral, ir, parent.expect("a parent"), found);
    }
    for item in block.items {
        let BlockItemInner::Register(register) = &item.inner else {
            continue;
        };
        let bits = match register.fieldset {
            Some(name) => fields(ir, name),
            None => u32::MAX >> (32 - register.bit_size),
        };
        for offset in places(item.array.as_ref()) {
            let address = peripheral.address as u32 + item.byte_offset + offset;
            let name = format!("{}.{}", peripheral.name, item.name);
            found.entry(address & !3).or_insert((name, 0)).1 |= bits << (8 * (address & 3));
        }
    }
}

/// Bits that the fields of a register take.
fn fields(ir: &IR, name: &str) -> u32 {
    let set: &FieldSet = ir
        .fieldsets
        .iter()
        .find(|it| plain(it.name) == plain(name))
        .expect("a set of fields");
    let inherited = set.extends.map_or(0, |parent| fields(ir, parent));
    set.fields.iter().fold(inherited, |bits, field| {
        let place = match &field.bit_offset {
            BitOffset::Regular(at) => (u64::from(u32::MAX) >> (32 - field.bit_size)) << at.offset,
            BitOffset::Cursed(at) => at
                .ranges
                .iter()
                .cloned()
                .flatten()
                .fold(0, |bits, bit| bits | 1 << bit),
        };
        places(field.array.as_ref()).fold(bits, |bits, at| bits | (place << at) as u32)
    })
}

/// Offsets of the elements of an array.
fn places(array: Option<&Array>) -> impl Iterator<Item = u32> {
    match array {
        None => vec![0],
        Some(Array::Regular(array)) => (0..array.len).map(|n| n * array.stride).collect(),
        Some(Array::Cursed(array)) => array.offsets.to_vec(),
    }
    .into_iter()
}

/// Registers in which the image of a chip wrote reserved bits.
fn violated(chip: &Chip) -> BTreeSet<String> {
    let described = described();
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
    let violated: BTreeSet<_> = [&axle, &screw].into_iter().flat_map(violated).collect();
    let known = KNOWN.map(|(name, _)| name.to_owned()).into();
    assert_eq!(violated, known);
}

#[test]
fn the_description_has_the_bits_of_the_manual() {
    let described = described();
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
    let described = described();
    for (name, address, value) in RESET_VALUES {
        let (found, bits) = &described[&address];
        assert_eq!(found, name);
        // Bits that the description leaves out, although they are set after a reset.
        let reserved = match name {
            "PWR.cr5" | "SYSCFG.cfgr1" => u32::MAX,
            _ => 0,
        };
        assert_eq!(value & !bits & !reserved, 0, "{name}: {bits:#x}");
    }
}
