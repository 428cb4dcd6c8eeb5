//! I2C3 on PC8 and PC9 as a bus controller, with the sensor modules of the guard's board (RM0440,
//! chapter on I2C, whose register names are used here).
//!
//! Not modelled: target mode, addresses of ten bits, transfers of more than 255 bytes, `SMBus`, the
//! second byte that the transmit register holds beside the shift register, clock stretching by a
//! chip, and another controller. A controller that finds the data line low waits for a free bus, or
//! loses the arbitration in a byte that it sends.

use super::{CORE_HZ, GPIO, RCC, State};
use std::collections::VecDeque;
use tautrack::link::chips::Chips;
use tautrack::link::{BodyMeasurands, STEP_US};

/// The controller.
pub const I2C3: u32 = 0x4000_7800;
/// Numbers of its interrupts: events and errors.
pub const I2C3_EV: u16 = 92;
/// The errors.
pub const I2C3_ER: u16 = 93;
/// Requests to the DMA: a byte was received, a byte is needed.
pub const I2C3_REQUESTS: [u32; 2] = [20, 21];

const CR1: u32 = I2C3;
const CR2: u32 = I2C3 + 0x04;
/// Bit timing.
pub const TIMINGR: u32 = I2C3 + 0x10;
const ISR: u32 = I2C3 + 0x18;
const ICR: u32 = I2C3 + 0x1c;
const RXDR: u32 = I2C3 + 0x24;
const TXDR: u32 = I2C3 + 0x28;
const END: u32 = I2C3 + 0x2c;

/// Bits of CR1.
const PE: u32 = 1;
const TXIE: u32 = 1 << 1;
const RXIE: u32 = 1 << 2;
const NACKIE: u32 = 1 << 4;
const STOPIE: u32 = 1 << 5;
const TCIE: u32 = 1 << 6;
const ERRIE: u32 = 1 << 7;
const TXDMAEN: u32 = 1 << 14;
const RXDMAEN: u32 = 1 << 15;
/// Bits of CR2.
const READ: u32 = 1 << 10;
const START: u32 = 1 << 13;
const STOP: u32 = 1 << 14;
const NACK: u32 = 1 << 15;
const AUTOEND: u32 = 1 << 25;
/// Bits of ISR.
const TXE: u32 = 1;
const TXIS: u32 = 1 << 1;
const RXNE: u32 = 1 << 2;
const NACKF: u32 = 1 << 4;
const STOPF: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const ARLO: u32 = 1 << 9;
const BUSY: u32 = 1 << 15;
/// Flags that ICR clears.
const CLEARABLE: u32 = NACKF | STOPF | 1 << 8 | ARLO | 1 << 10;

/// Pins of the lines in port C, and their alternate function.
const CLOCK: u32 = 8;
const DATA: u32 = 9;
const FUNCTION: u32 = 8;
const PORT: u32 = GPIO + 0x800;
/// Clocks in which the controller recognizes both edges of the clock line: 50 ns of its filter, and
/// two clocks, for each.
const EDGES: u64 = 2 * (CORE_HZ / 20_000_000 + 2);
/// Clock pulses after which a chip that holds the data line lets go of it.
const PULSES: u32 = 9;

#[derive(Clone, Copy, PartialEq, Eq, Default)]
enum Phase {
    #[default]
    Idle,
    /// Start condition and address are on the bus.
    Address,
    /// A byte is on the bus.
    Byte,
    /// The clock line is low until a byte is written or read.
    Wait,
    /// The clock line is low until a start or a stop is requested.
    Complete,
    /// The stop condition is on the bus.
    Stop,
}

/// State of the controller beyond its registers.
#[derive(Default)]
pub(super) struct Controller {
    phase: Phase,
    /// Clock at which the phase ends.
    end: u64,
    /// Number of bytes of the transfer that are left.
    left: u32,
    written: Vec<u8>,
    to_read: VecDeque<u8>,
}

/// The sensor modules on the bus.
pub(super) struct Modules {
    chips: Chips,
    acts: BodyMeasurands,
    /// Clock of the next step of the chips.
    next: u64,
    /// Clock pulses since a chip holds the data line, and the level of the clock line.
    pulses: u32,
    clock_line: bool,
}

impl State {
    /// Connects modules that were switched on now.
    pub(super) fn connect_modules(&mut self) {
        self.modules = Some(Box::new(Modules {
            chips: Chips::new(0),
            acts: BodyMeasurands {
                specific_force: [0.0, 0.0, 9.806_65],
                tilt_force: [0.0, 0.0, 9.806_65],
                ..BodyMeasurands::default()
            },
            next: self.clock,
            pulses: 0,
            clock_line: true,
        }));
    }

    /// What acts on the sensors of the modules, if they are connected.
    pub(super) fn acts(&mut self) -> Option<&mut BodyMeasurands> {
        self.modules.as_mut().map(|modules| &mut modules.acts)
    }

    fn held(&self) -> bool {
        let modules = self.modules.as_ref();
        modules.is_some_and(|modules| modules.chips.held())
    }

    /// Whether the port, instead of the controller, pulls this line low.
    fn pulled(&self, pin: u32) -> bool {
        self.get(PORT) >> (2 * pin) & 3 == 1 && self.get(PORT + 0x14) >> pin & 1 == 0
    }

    /// Levels of the lines in the input register of port C, while no transfer is made.
    pub(super) fn i2c_levels(&self) -> u32 {
        let clock = u32::from(!self.pulled(CLOCK));
        let data = u32::from(!self.pulled(DATA) && !self.held());
        clock << CLOCK | data << DATA
    }

    fn is_connected(&self) -> bool {
        [CLOCK, DATA].into_iter().all(|pin| {
            self.get(PORT) >> (2 * pin) & 3 == 2
                && self.get(PORT + 0x24) >> (4 * (pin - 8)) & 15 == FUNCTION
        })
    }

    /// Whether the controller has a clock.
    fn i2c_clocked(&self) -> bool {
        self.get(RCC + 0x58) & 1 << 30 != 0
    }

    /// Reads a register of the controller; `None` if it is another one.
    pub(super) fn read_i2c(&mut self, address: u32) -> Option<u32> {
        match address {
            ISR => {
                let busy = self.i2c.phase != Phase::Idle || self.held();
                Some(self.get(ISR) | if busy { BUSY } else { 0 })
            }
            RXDR => {
                self.set(ISR, self.get(ISR) & !RXNE);
                self.changed = true;
                Some(self.get(RXDR))
            }
            _ => None,
        }
    }

    /// Writes a register of the controller. Returns the register's value.
    pub(super) fn write_i2c(&mut self, address: u32, value: u32) -> u32 {
        let old = self.get(address);
        match address {
            _ if !self.i2c_clocked() => old,
            CR1 => {
                if value & PE == 0 {
                    self.i2c = Controller::default();
                    self.set(ISR, TXE);
                    self.set(CR2, self.get(CR2) & !(START | STOP | NACK));
                }
                value
            }
            TIMINGR if self.get(CR1) & PE != 0 => old,
            // Software can set TXE, but not clear it, and changes nothing else.
            ISR => old | value & TXE,
            ICR => {
                self.set(ISR, self.get(ISR) & !(value & CLEARABLE));
                0
            }
            TXDR => {
                self.set(ISR, self.get(ISR) & !TXIS);
                value
            }
            _ => value,
        }
    }

    /// Whether the address is one of the controller's registers.
    pub(super) fn is_i2c(address: u32) -> bool {
        (I2C3..END).contains(&address)
    }

    /// Core clocks of a bit.
    fn bit(&self) -> u64 {
        let timing = u64::from(self.get(TIMINGR));
        let units = (timing & 0xff) + 1 + (timing >> 8 & 0xff) + 1;
        ((timing >> 28) + 1) * units + EDGES
    }

    fn enter(&mut self, phase: Phase, bits: u64) {
        self.i2c.phase = phase;
        self.i2c.end = self.clock + bits * self.bit();
    }

    fn raise_i2c(&mut self, flags: u32) {
        self.set(ISR, self.get(ISR) | flags);
    }

    /// Advances the chips and the transfer. Returns the clock of the next event.
    pub(super) fn advance_i2c(&mut self) -> u64 {
        let clock = self.clock;
        let clock_line = !self.pulled(CLOCK);
        let mut next = u64::MAX;
        if let Some(modules) = &mut self.modules {
            while modules.next <= clock {
                modules.chips.measure(&modules.acts);
                modules.next += STEP_US * CORE_HZ / 1_000_000;
            }
            next = modules.next;
            if clock_line && !modules.clock_line && modules.chips.held() {
                modules.pulses += 1;
                if modules.pulses >= PULSES {
                    modules.pulses = 0;
                    modules.chips.pulse();
                }
            }
            modules.clock_line = clock_line;
        }
        if self.get(CR1) & PE == 0 || !self.i2c_clocked() || !self.is_connected() {
            return next;
        }
        while self.advance_transfer() {}
        match self.i2c.phase {
            Phase::Address | Phase::Byte => next.min(self.i2c.end),
            Phase::Stop if clock < self.i2c.end => next.min(self.i2c.end),
            _ => next,
        }
    }

    /// Takes the next step of the transfer, if it is due. Returns whether it was.
    fn advance_transfer(&mut self) -> bool {
        let (control, request) = (self.get(CR1), self.get(CR2));
        let flags = self.get(ISR);
        let [received, needed] = I2C3_REQUESTS;
        if flags & RXNE != 0 && control & RXDMAEN != 0 {
            let byte = self.get(RXDR) as u8;
            if self.byte_to_memory(received, RXDR, byte).is_some() {
                self.set(ISR, flags & !RXNE);
                return true;
            }
        }
        if flags & TXIS != 0
            && control & TXDMAEN != 0
            && let Some(byte) = self.byte_from_memory(needed, TXDR)
        {
            self.set(TXDR, byte.into());
            self.set(ISR, flags & !TXIS);
            return true;
        }
        let over = self.clock >= self.i2c.end;
        match self.i2c.phase {
            Phase::Idle | Phase::Complete if request & START != 0 => {
                if self.i2c.phase == Phase::Idle && self.held() {
                    return false;
                }
                self.set(ISR, flags & !TC);
                self.i2c.left = request >> 16 & 0xff;
                self.enter(Phase::Address, 10);
            }
            Phase::Complete if request & STOP != 0 => {
                self.set(ISR, flags & !TC);
                self.set(CR2, request & !STOP);
                self.enter(Phase::Stop, 1);
            }
            Phase::Address if over => self.address_ended(request),
            Phase::Byte if over => self.byte_ended(request),
            Phase::Wait if flags & (TXIS | RXNE) == 0 => self.enter(Phase::Byte, 9),
            Phase::Stop if over && !self.held() => {
                self.i2c.phase = Phase::Idle;
                self.raise_i2c(STOPF);
            }
            _ => return false,
        }
        true
    }

    fn address_ended(&mut self, request: u32) {
        if self.held() {
            return self.lose_arbitration();
        }
        self.set(CR2, request & !START);
        let address = (request >> 1 & 0x7f) as u8;
        let mut bytes = vec![0; self.i2c.left as usize];
        let answer = self.modules.as_mut().and_then(|modules| {
            let chips = &mut modules.chips;
            if request & READ != 0 {
                chips.read(address, &mut bytes).ok()
            } else {
                chips.write(address, &[]).ok()
            }
        });
        self.i2c.written.clear();
        self.i2c.to_read = bytes.into();
        if answer.is_none() {
            self.raise_i2c(NACKF);
            self.enter(Phase::Stop, 1);
        } else if self.i2c.left == 0 {
            self.bytes_ended(request);
        } else if request & READ != 0 {
            self.enter(Phase::Byte, 9);
        } else {
            self.raise_i2c(TXIS);
            self.i2c.phase = Phase::Wait;
        }
    }

    fn byte_ended(&mut self, request: u32) {
        let reads = request & READ != 0;
        if reads {
            let byte = self.i2c.to_read.pop_front().unwrap_or(0);
            let byte = if self.held() { 0 } else { byte };
            self.set(RXDR, byte.into());
            self.raise_i2c(RXNE);
        } else if self.held() {
            return self.lose_arbitration();
        } else {
            self.i2c.written.push(self.get(TXDR) as u8);
        }
        self.i2c.left -= 1;
        if self.i2c.left == 0 {
            self.bytes_ended(request);
        } else {
            self.i2c.phase = Phase::Wait;
            if !reads {
                self.raise_i2c(TXIS);
            }
        }
    }

    fn bytes_ended(&mut self, request: u32) {
        let written = std::mem::take(&mut self.i2c.written);
        if let (Some(modules), false) = (&mut self.modules, written.is_empty()) {
            let address = (request >> 1 & 0x7f) as u8;
            // The chip has acknowledged its address.
            let _ = modules.chips.write(address, &written);
        }
        if request & AUTOEND != 0 {
            self.enter(Phase::Stop, 1);
        } else {
            self.raise_i2c(TC);
            self.i2c.phase = Phase::Complete;
        }
    }

    /// The data line is low while the controller sends a high level.
    fn lose_arbitration(&mut self) {
        self.i2c.phase = Phase::Idle;
        self.set(CR2, self.get(CR2) & !(START | STOP));
        self.raise_i2c(ARLO);
    }

    /// Levels of the interrupt lines for events and errors; `None` while the controller is off.
    pub(super) fn i2c_lines(&self) -> Option<[bool; 2]> {
        if !self.i2c_clocked() {
            return None;
        }
        let (control, flags) = (self.get(CR1), self.get(ISR));
        let causes = [
            (TXIE, TXIS),
            (RXIE, RXNE),
            (NACKIE, NACKF),
            (STOPIE, STOPF),
            (TCIE, TC),
        ];
        let event = causes
            .into_iter()
            .any(|(enable, flag)| control & enable != 0 && flags & flag != 0);
        Some([event, control & ERRIE != 0 && flags & ARLO != 0])
    }
}
