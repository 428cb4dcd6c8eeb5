//! The serial line of the guard's board: USART1 without its FIFO, as the receiver alone.

use super::{CORE_HZ, RCC, State};
use std::collections::VecDeque;

/// The port.
pub const USART1: u32 = 0x4001_3800;
const BAUD_DIVIDER: u32 = USART1 + 0x0c;
const STATUS: u32 = USART1 + 0x1c;
const CLEAR: u32 = USART1 + 0x20;
const DATA: u32 = USART1 + 0x24;
/// Bits of the status: overrun, and a byte that waits.
const OVERRUN: u32 = 1 << 3;
const NOT_EMPTY: u32 = 1 << 5;
/// Bits of the control register: port and receiver are enabled, and so is the interrupt.
const ENABLED: u32 = 1 << 2 | 1;
const INTERRUPT: u32 = 1 << 5;

/// Bytes on the line, each with the clock at its end.
pub(super) type Line = VecDeque<(u64, u8)>;

impl State {
    /// Sends bytes without a pause at this bit rate. A receiver with another rate gets other bytes.
    pub(super) fn send_serial(&mut self, bytes: &[u8], baud: u64) {
        let byte_clocks = 10 * CORE_HZ / baud;
        let mut at = self.serial.back().map_or(self.clock, |last| last.0);
        for byte in bytes {
            at += byte_clocks;
            self.serial.push_back((at, *byte));
        }
        let divider = u64::from(self.get(BAUD_DIVIDER)).max(1);
        let error = (CORE_HZ / divider).abs_diff(baud);
        if error * 50 > baud {
            self.serial.iter_mut().for_each(|(_, byte)| *byte = !*byte);
        }
        self.changed = true;
    }

    /// Receives the bytes that have ended. Returns the clock of the next one.
    pub(super) fn advance_serial(&mut self) -> u64 {
        while self.serial.front().is_some_and(|(at, _)| *at <= self.clock) {
            let (_, byte) = self.serial.pop_front().expect("a byte");
            let clocked = self.get(RCC + 0x60) & 1 << 14 != 0;
            if !clocked || self.get(USART1) & ENABLED != ENABLED {
                continue;
            }
            let status = self.get(STATUS);
            if status & NOT_EMPTY != 0 {
                self.set(STATUS, status | OVERRUN);
            } else {
                self.set(DATA, byte.into());
                self.set(STATUS, status | NOT_EMPTY);
            }
        }
        self.serial.front().map_or(u64::MAX, |(at, _)| *at)
    }

    /// Reads a register of the port; `None` if it is another one.
    pub(super) fn read_serial(&mut self, address: u32) -> Option<u32> {
        if address != DATA {
            return None;
        }
        self.set(STATUS, self.get(STATUS) & !NOT_EMPTY);
        self.changed = true;
        Some(self.get(DATA))
    }

    /// Writes the register that clears flags.
    pub(super) fn clear_serial(&mut self, address: u32, value: u32) {
        if address == CLEAR {
            self.set(STATUS, self.get(STATUS) & !(value & OVERRUN));
        }
    }

    /// Level of the interrupt line.
    pub(super) fn serial_line(&self) -> bool {
        self.get(USART1) & INTERRUPT != 0 && self.get(STATUS) & (OVERRUN | NOT_EMPTY) != 0
    }
}
