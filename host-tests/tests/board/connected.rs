//! A connected board against the model of its chip: the registers that the program has set.
//!
//! The test only reads, through the program probe-rs. Flash the board first, without a motor:
//! `cargo flash-node axle --robot b2p2 --node-id 2`. Without such a board it is skipped, and says
//! so on the terminal.

use crate::chip::{BDTR, Chip, Defect, FDCAN, FLASH_CONTROL, GPIO, IWDG, PWR, RCC, TIM1};
use crate::executed::{DEFECT, running_axle};
use crate::images::APPLICATION;
use std::io::{Write, stderr};
use std::process::Command;

/// Register, and its bits that only the program decides.
const REGISTERS: [(&str, u32, u32); 24] = [
    ("PLL", RCC + 0x0c, 0x7f00_7ff3),
    ("system clock", RCC + 0x08, 0xf),
    ("boost", PWR + 0x80, 1 << 8),
    ("wait states", FLASH_CONTROL, 0xf),
    ("PWM mode", TIM1, 0x61),
    ("trigger", TIM1 + 0x04, 0xf << 20),
    ("channels a and b", TIM1 + 0x18, u32::MAX),
    ("channel c", TIM1 + 0x1c, 0xff),
    ("outputs", TIM1 + 0x20, 0x0fff),
    ("period", TIM1 + 0x2c, u32::MAX),
    ("repetition", TIM1 + 0x30, u32::MAX),
    ("moment of the samples", TIM1 + 0x40, u32::MAX),
    ("dead time, break, output enable", BDTR, u32::MAX),
    ("break inputs", TIM1 + 0x60, 0x3ff),
    ("watchdog prescaler", IWDG + 0x04, 7),
    ("watchdog reload", IWDG + 0x08, 0xfff),
    ("bit timing", FDCAN + 0x1c, u32::MAX),
    ("sequence of ADC1", 0x5000_004c, u32::MAX),
    ("sequence of ADC2", 0x5000_014c, u32::MAX),
    ("op-amp 1", 0x4001_0300, 0x7fff),
    ("op-amp 2", 0x4001_0304, 0x7fff),
    ("pins of port A", GPIO, u32::MAX),
    ("functions of PA8 to PA15", GPIO + 0x24, u32::MAX),
    ("pins of port B", GPIO + 0x400, u32::MAX),
];

/// Registers that differ between the model and what `read` returns.
fn differences(model: &Chip, mut read: impl FnMut(u32) -> u32) -> Vec<String> {
    REGISTERS
        .into_iter()
        .map(|(name, address, bits)| (name, model.register(address) & bits, read(address) & bits))
        .filter(|(_, model, board)| model != board)
        .map(|(name, model, board)| format!("{name}: model {model:#010x}, board {board:#010x}"))
        .collect()
}

/// Word of a connected board's memory; `None` without a board.
fn word(address: u32) -> Option<u32> {
    let output = Command::new("probe-rs")
        .args(["read", "--chip", "STM32G431CBTx", "b32"])
        .args([format!("{address:#010x}"), "1".to_owned()])
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    parse(&String::from_utf8_lossy(&output.stdout))
}

/// Word in the answer of `probe-rs read`.
fn parse(answer: &str) -> Option<u32> {
    u32::from_str_radix(answer.split_whitespace().last()?, 16).ok()
}

#[test]
fn a_connected_board_has_the_registers_of_the_model() {
    let header = APPLICATION.start as u32 + 0x1e0;
    if word(header) != Some(u32::from_le_bytes(*b"TTIM")) {
        // Not a macro of the standard library: the test's output would be captured.
        let _ = writeln!(
            stderr(),
            "SKIPPED a_connected_board_has_the_registers_of_the_model: no flashed motor board is \
             connected, or probe-rs is missing"
        );
        return;
    }
    let differences = differences(&running_axle(), |address| word(address).expect("a board"));
    assert!(differences.is_empty(), "{differences:#?}");
}

#[test]
fn a_board_that_differs_from_the_model_is_noticed() {
    let model = running_axle();
    assert_eq!(parse("00008003 \n"), Some(0x8003));
    let same = running_axle();
    assert_eq!(differences(&model, |it| same.register(it)), [""; 0]);
    DEFECT.set(Some(Defect::Register {
        address: BDTR,
        mask: 0xff,
        value: 0,
    }));
    let other = running_axle();
    DEFECT.set(None);
    let found = differences(&model, |it| other.register(it));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("dead time"), "{found:?}");
}
