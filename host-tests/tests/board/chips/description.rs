//! What the manufacturer's data say about the pins and registers of a chip, whose data the module
//! that includes this file names `metapac`.

use super::metapac::metadata::ir::{Array, BitOffset, Block, BlockItemInner, FieldSet, IR};
use super::metapac::metadata::{METADATA, Peripheral};
use std::collections::{BTreeMap, BTreeSet};

/// Number of the alternate function that connects the pin with this signal, `TIM1_CH1`.
pub fn alternate(pin: &str, signal: &str) -> Option<u32> {
    let (peripheral, signal) = signal.split_once('_').expect("peripheral and signal");
    METADATA
        .peripherals
        .iter()
        .filter(|known| known.name == peripheral)
        .flat_map(|known| known.pins)
        .find(|known| known.pin == pin && known.signal == signal)
        .and_then(|known| known.af)
        .map(u32::from)
}

/// Pins that have this signal.
pub fn pins(peripheral: &str, signal: &str) -> BTreeSet<&'static str> {
    METADATA
        .peripherals
        .iter()
        .filter(|known| known.name == peripheral)
        .flat_map(|known| known.pins)
        .filter(|known| known.signal == signal)
        .map(|known| known.pin)
        .collect()
}

/// Number of the interrupt with this name.
pub fn interrupt(name: &str) -> Option<u32> {
    let mut lines = METADATA.interrupts.iter();
    lines.find(|line| line.name == name).map(|line| line.number)
}

/// Number of the request to the DMA that this signal of a peripheral raises.
pub fn request(peripheral: &str, signal: &str) -> Option<u32> {
    METADATA
        .peripherals
        .iter()
        .filter(|known| known.name == peripheral)
        .flat_map(|known| known.dma_channels)
        .find(|known| known.signal == signal)
        .and_then(|known| known.request)
}

/// Address of a peripheral.
pub fn address(name: &str) -> Option<u32> {
    let mut peripherals = METADATA.peripherals.iter();
    let found = peripherals.find(|known| known.name == name);
    found.map(|known| known.address as u32)
}

/// Address and length of each memory.
pub fn memories() -> BTreeSet<(u32, u32)> {
    METADATA
        .memory
        .iter()
        .flat_map(|arrangement| arrangement.iter())
        .map(|memory| (memory.address, memory.size))
        .collect()
}

/// Name and meaningful bits of the registers, by their addresses.
pub fn described() -> BTreeMap<u32, (String, u32)> {
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
