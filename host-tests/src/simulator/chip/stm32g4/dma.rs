//! DMA1 with its request multiplexer (RM0440, chapters on DMA and DMAMUX): it moves one byte
//! between a peripheral and memory for each request. Not modelled: other sizes, circular transfers,
//! errors and the time that a byte takes.

use super::{FLASH, RAM, RCC, State};

/// First DMA controller.
pub const DMA1: u32 = 0x4002_0000;
/// Request multiplexer.
pub const DMAMUX1: u32 = 0x4002_0800;
/// Numbers of the interrupts of channels 1 and 2.
pub const DMA1_CHANNELS: [u16; 2] = [11, 12];

const FLAGS: u32 = DMA1;
const CLEAR: u32 = DMA1 + 0x04;
/// Registers of a channel: control, number of bytes left, addresses of peripheral and memory.
const CONTROL: u32 = DMA1 + 0x08;
const LEFT: u32 = 0x04;
const PERIPHERAL: u32 = 0x08;
const MEMORY: u32 = 0x0c;
/// Distance between the registers of two channels.
const CHANNEL: u32 = 0x14;
const CHANNELS: u32 = 8;

/// Bits of the control register: enable, interrupt at the end, direction, increment of the memory
/// address, and sizes.
const ENABLE: u32 = 1;
const END_INTERRUPT: u32 = 1 << 1;
const FROM_MEMORY: u32 = 1 << 4;
const INCREMENT: u32 = 1 << 7;
const SIZES: u32 = 0xf << 8;
/// Bits of a channel in the flags: any, and end.
const ANY: u32 = 1;
const ENDED: u32 = 1 << 1;

/// Bytes that each channel has moved since it was enabled.
pub(super) type Moved = [u32; CHANNELS as usize];

impl State {
    /// Write to a register of the controller. Returns the register's value.
    pub(super) fn write_dma(&mut self, address: u32, value: u32) -> u32 {
        if address == CLEAR {
            for channel in 0..CHANNELS {
                let all = value >> (4 * channel) & ANY != 0;
                let cleared = if all {
                    0xf
                } else {
                    value >> (4 * channel) & 0xe
                };
                let mut flags = self.get(FLAGS) & !(cleared << (4 * channel));
                if flags >> (4 * channel) & 0xe == 0 {
                    flags &= !(ANY << (4 * channel));
                }
                self.set(FLAGS, flags);
            }
            return 0;
        }
        let channel = address.wrapping_sub(CONTROL) / CHANNEL;
        if address == CONTROL + CHANNEL * channel && value & !self.get(address) & ENABLE != 0 {
            self.moved[channel as usize] = 0;
        }
        value
    }

    /// Address in memory of the byte that a channel moves at this request; the channel then has it
    /// behind it. `None` if no channel serves the request of this register.
    fn serve(&mut self, request: u32, register: u32, direction: u32) -> Option<u32> {
        let clocks = self.get(RCC + 0x48);
        // Controller and multiplexer.
        if clocks & 0b101 != 0b101 {
            return None;
        }
        let channel = (0..CHANNELS).find(|channel| {
            let base = CONTROL + CHANNEL * channel;
            let bits = ENABLE | FROM_MEMORY | INCREMENT | SIZES;
            self.get(DMAMUX1 + 4 * channel) & 0x7f == request
                && self.get(base) & bits == ENABLE | INCREMENT | direction
                && self.get(base + PERIPHERAL) == register
                && self.get(base + LEFT) > 0
        })?;
        let base = CONTROL + CHANNEL * channel;
        let address = self.get(base + MEMORY) + self.moved[channel as usize];
        self.moved[channel as usize] += 1;
        let left = self.get(base + LEFT) - 1;
        self.set(base + LEFT, left);
        if left == 0 {
            let flags = self.get(FLAGS) | (ANY | ENDED) << (4 * channel);
            self.set(FLAGS, flags);
        }
        Some(address)
    }

    /// Next byte for `register` of a peripheral that raises this request.
    pub(super) fn byte_from_memory(&mut self, request: u32, register: u32) -> Option<u8> {
        let address = self.serve(request, register, FROM_MEMORY)?;
        let [flash, ram] = self.memories.as_ref()?;
        let (memory, start) = if address < RAM {
            (flash, FLASH)
        } else {
            (ram, RAM)
        };
        let mut byte = [0];
        memory
            .read_at((address - start).into(), &mut byte)
            .expect("memory");
        Some(byte[0])
    }

    /// Takes a byte of `register` of a peripheral that raises this request.
    pub(super) fn byte_to_memory(&mut self, request: u32, register: u32, byte: u8) -> Option<()> {
        let address = self.serve(request, register, 0)?;
        let [_, ram] = self.memories.as_ref()?;
        ram.write_at((address - RAM).into(), &[byte]).expect("RAM");
        Some(())
    }

    /// Levels of the interrupt lines of channels 1 and 2.
    pub(super) fn dma_lines(&self) -> [bool; 2] {
        [0, 1].map(|channel| {
            let ended = self.get(FLAGS) >> (4 * channel) & ENDED != 0;
            ended && self.get(CONTROL + CHANNEL * channel) & END_INTERRUPT != 0
        })
    }
}
