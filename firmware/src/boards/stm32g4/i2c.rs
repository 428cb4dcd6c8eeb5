//! I2C bus with 400 kbit/s, on which a board has its sensor chips.
//!
//! The library makes the transfers, with DMA. It has no function for what is here besides: bit
//! timing at this core clock, waiting for the end of the transfer before without keeping the
//! other tasks from running, and freeing the bus.

use super::clock::CORE_HZ;
use crate::sensors::SensorBus;
use embassy_stm32::i2c::{Config, Error, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::pac;
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::time::Hertz;
use embassy_time::{Duration, Timer};
use embedded_hal_async::i2c::{ErrorType, I2c as Transfers, Operation};

/// Bit rate, bit/s: "fast mode" of NXP UM10204.
const BIT_RATE: u32 = 400_000;
/// Time after which the library gives a transfer up. A transfer is given up before, by
/// [`crate::sensors`]; this ends the library's loops.
const GIVE_UP: Duration = Duration::from_millis(5);
/// Time between two looks at a bus that is not free. A stop condition takes 3 us.
const LOOK: Duration = Duration::from_micros(20);
/// Half of a clock pulse that frees the bus.
const HALF_PULSE: Duration = Duration::from_micros(10);
/// Maximum number of these pulses: a chip lets go of the data line at the end of its byte.
const PULSES: u32 = 9;

/// Core clocks in a unit of the bit timing.
const UNIT: u32 = 5;
/// Units that this time takes at least; nanoseconds.
const fn units(time_ns: u32) -> u8 {
    let clocks = time_ns as u64 * CORE_HZ as u64;
    clocks.div_ceil(UNIT as u64 * 1_000_000_000) as u8
}
/// Low and high period of the clock line (RM0440, register `I2C_TIMINGR`). Together with the 120 ns
/// in which the controller recognizes both edges, they are 2.5 us.
const LOW: u8 = units(1_350);
const HIGH: u8 = units(1_020);
/// Delay from the falling edge of the clock line to a change of the data line. The formulas of
/// RM0440 (chapter on I2C, data hold time) demand 232 ns to 316 ns in fast mode.
const HOLD: u8 = units(260);
/// Time from a change of the data line to the rising edge of the clock line: 100 ns, and 300 ns in
/// which the line rises.
const SETUP: u8 = units(400);

/// Configuration with which the board makes the library's driver. The pull-up resistors of the chip
/// (40 kiloohm) are too weak for this bit rate. They keep a bus without modules high, on which no
/// chip then acknowledges.
pub fn config() -> Config {
    let mut config = Config::default();
    config.frequency = Hertz(BIT_RATE);
    config.timeout = GIVE_UP;
    config.scl_pullup = true;
    config.sda_pullup = true;
    config
}

/// Pin of a line.
#[derive(Clone, Copy)]
pub struct Line {
    /// Its port.
    pub port: pac::gpio::Gpio,
    /// Its number in the port.
    pub pin: usize,
}

impl Line {
    fn is_high(self) -> bool {
        self.port.idr().read().idr(self.pin) == pac::gpio::vals::Idr::HIGH
    }

    /// Pulls the line low, or lets it go.
    fn set(self, high: bool) {
        self.port.bsrr().write(|w| {
            if high {
                w.set_bs(self.pin, true);
            } else {
                w.set_br(self.pin, true);
            }
        });
    }

    /// Connects the pin with the controller, or with [`Self::set`].
    fn connect(self, controller: bool) {
        // Tasks of other priorities change other pins of the port.
        critical_section::with(|_| {
            self.port.moder().modify(|w| {
                let mode = if controller {
                    Moder::ALTERNATE
                } else {
                    Moder::OUTPUT
                };
                w.set_moder(self.pin, mode);
            });
        });
    }
}

/// The bus.
pub struct Bus {
    driver: I2c<'static, Async, Master>,
    registers: pac::i2c::I2c,
    clock: Line,
    data: Line,
}

impl Bus {
    /// Sets the bit timing. `driver` has the [`config`] of this module, and the others belong to
    /// it.
    pub fn new(
        driver: I2c<'static, Async, Master>,
        registers: pac::i2c::I2c,
        clock: Line,
        data: Line,
    ) -> Self {
        // The library's timing does not fit the register's fields at 170 MHz. The timing can be
        // changed only while the controller is disabled.
        registers.cr1().modify(|w| w.set_pe(false));
        registers.timingr().write(|w| {
            w.set_presc(UNIT as u8 - 1);
            w.set_scll(LOW - 1);
            w.set_sclh(HIGH - 1);
            w.set_sdadel(HOLD);
            w.set_scldel(SETUP - 1);
        });
        registers.cr1().modify(|w| w.set_pe(true));
        Self {
            driver,
            registers,
            clock,
            data,
        }
    }

    fn is_free(&self) -> bool {
        !self.registers.isr().read().busy() && self.clock.is_high() && self.data.is_high()
    }
}

impl ErrorType for Bus {
    type Error = Error;
}

impl Transfers for Bus {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Error> {
        // The library would wait in a loop.
        while !self.is_free() {
            Timer::after(LOOK).await;
        }
        match operations {
            [Operation::Write(bytes)] => self.driver.write(address, bytes).await,
            // The library's `transaction` waits for the stop condition in a loop; these do not.
            [Operation::Write(bytes), Operation::Read(read)] => {
                self.driver.write_read(address, bytes, read).await
            }
            operations => self.driver.transaction(address, operations).await,
        }
    }
}

impl SensorBus for Bus {
    async fn recover(&mut self) {
        let Self { clock, data, .. } = *self;
        self.registers.cr1().modify(|w| w.set_pe(false));
        for line in [clock, data] {
            line.set(true);
            line.connect(false);
        }
        for _ in 0..PULSES {
            if data.is_high() {
                break;
            }
            clock.set(false);
            Timer::after(HALF_PULSE).await;
            clock.set(true);
            Timer::after(HALF_PULSE).await;
        }
        // A stop condition: the data line rises while the clock line is high.
        for (line, high) in [(clock, false), (data, false), (clock, true), (data, true)] {
            line.set(high);
            Timer::after(HALF_PULSE).await;
        }
        for line in [clock, data] {
            line.connect(true);
        }
        self.registers.cr1().modify(|w| w.set_pe(true));
    }
}
