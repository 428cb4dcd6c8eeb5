//! What tests measure on a running chip, and what they do to it.

use super::{Chip, FLASH, PAINT, State, Wiring};
use rsemu::cpu::arm::v7m::ArmV7m;
use rsemu::cpu::arm::v7m::sys::{Exception, fpccr};
use std::sync::MutexGuard;
use tautrack::can::Frame;

const RAM: u32 = 0x2000_0000;
/// Cause of a reset in the register of the causes: brown-out.
const BROWN_OUT: u32 = 1 << 27;

/// State of the core after an instruction, or after an exception entry.
#[derive(Clone, Copy, Debug)]
pub struct Executed {
    /// Time, core clocks.
    pub clock: u64,
    /// Address of the next instruction.
    pub next: u32,
    /// Number of the exception that runs; 0 in the thread.
    pub exception: u16,
    /// The main stack pointer.
    pub stack_pointer: u32,
    /// Whether all interrupts are masked (PRIMASK or FAULTMASK).
    pub masked: bool,
}

/// The core after a reset. A reset of rsemu's core keeps what the chip's does not: which interrupts
/// are enabled, and a floating-point context that waits to be stored.
pub(super) fn new_core(core: &ArmV7m) -> ArmV7m {
    let new = ArmV7m::new(core.config());
    if let Some(space) = core.space() {
        new.attach_space(space);
    }
    store_at_entry(&new);
    new
}

/// Makes the core store the floating-point registers at each entry of an exception.
///
/// The silicon puts this off until the exception uses one of them. This version of rsemu then
/// clears the flags of a floating-point comparison, and does not restore them.
pub(super) fn store_at_entry(core: &ArmV7m) {
    core.with_sys(|system| system.fpccr &= !fpccr::LSPEN);
}

/// Function that is called after every instruction.
pub type Watcher = Box<dyn FnMut(Executed) + Send>;

impl Chip {
    /// Calls `watcher` after every instruction from now on.
    pub fn watch(&mut self, watcher: impl FnMut(Executed) + Send + 'static) {
        self.watcher = Some(Box::new(watcher));
    }

    pub(super) fn observe(&mut self, clock: u64) {
        if let Some(watcher) = &mut self.watcher {
            let registers = self.cpu.regs();
            watcher(Executed {
                clock,
                next: registers.r[15],
                exception: (registers.xpsr & 0x1ff) as u16,
                stack_pointer: registers.msp,
                masked: registers.primask || registers.faultmask,
            });
        }
    }

    /// Largest number of bytes that the stack has taken, if static variables end at `static_end`.
    pub fn deepest_stack(&self, static_end: u32) -> u32 {
        let mut bytes = vec![0; self.part.ram as usize];
        self.ram.read_at(0, &mut bytes).expect("RAM");
        let free = &bytes[(static_end - RAM) as usize..];
        let unused = free.iter().take_while(|byte| **byte == PAINT).count();
        (free.len() - unused) as u32
    }

    /// Counts the wait states of the flash memory from now on.
    pub fn count_wait_states(&self) {
        self.timed_flash.count();
    }

    /// Makes the stack go on at `end`, and the thread push words on it without an end. Interrupts
    /// still run.
    pub fn overflow_stack(&mut self, end: u32) {
        while self.cpu.current_exception() != Exception(0) {
            self.run(1);
        }
        // `push {r0-r7, lr}`, and back. The bottom of the stack has what the thread left there.
        let code = RAM + self.part.ram as u32 - 16;
        self.set_ram(code, &[0xff, 0xb5, 0xfd, 0xe7]);
        self.cpu.set_pc(code);
        self.cpu.set_reg(13, end);
    }

    /// Connects the CAN transceiver.
    pub fn wire(&mut self, wiring: Wiring) {
        self.locked().wire(wiring);
    }

    /// Sends frames to the chip back to back, as fast as the bus can.
    pub fn burst(&mut self, frames: impl IntoIterator<Item = Frame>) {
        self.locked().burst(frames);
    }

    /// Number of frames that came while the receive FIFO was full.
    pub fn lost_frames(&self) -> u32 {
        self.locked().lost()
    }

    /// Resets the chip as a short drop of its supply does. RAM keeps its contents.
    pub fn brown_out(&mut self) {
        let mut state = self.locked();
        state.reset(false);
        state.set(super::RCC + 0x94, BROWN_OUT);
        drop(state);
        self.cpu = new_core(&self.cpu);
    }

    /// Stops the timer of the bridge, so that no current is converted any more.
    pub fn stop_trigger(&mut self) {
        let mut state = self.locked();
        let control = state.get(super::TIM1);
        state.set(super::TIM1, control & !1);
    }

    /// Bytes of RAM or flash memory from `address`.
    pub fn memory(&self, address: u32, length: usize) -> Vec<u8> {
        let (memory, start) = if address < RAM {
            (&self.flash, FLASH)
        } else {
            (&self.ram, RAM)
        };
        let mut bytes = vec![0; length];
        memory
            .read_at((address - start).into(), &mut bytes)
            .expect("memory of the chip");
        bytes
    }

    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("a state")
    }
}
