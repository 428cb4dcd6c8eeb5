//! Absolute sensor at the output shaft, on an I2C bus that the thread drives by software.
//!
//! No I2C controller of the chip has free pins: I2C1 would need PB7, an input of the encoder. So
//! the bus is on the inputs of the limit switches, as open drains with pull-up resistors. A
//! transfer takes less than a millisecond of the thread. Each interrupt may interrupt it, because
//! the chips wait for the clock. No wait is longer than [`LONGEST_WAIT`], and a bus that a chip
//! holds low is freed as the guard frees its own (NXP UM10204, section 3.1.16).

use core::sync::atomic::{AtomicI32, AtomicU8, AtomicU16, Ordering};
use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, OutputOpenDrain, Pull, Speed};
use embassy_stm32::peripherals::{PB3, PB4};
use embassy_time::{Duration, Ticker};
use tautrack::motor::shaft_sensor::{Condition, Kind, LENGTH, Reading};
use tautrack::units::Angle;

/// Time from one reading to the next.
const PERIOD: Duration = Duration::from_millis(10);
/// Half of a clock of the bus, core clocks: 2.5 us.
const HALF_CLOCK: u32 = 425;
/// Longest wait for a line that a pull-up resistor raises, half clocks.
const LONGEST_WAIT: u32 = 20;
/// Clocks after which a chip that was interrupted in a byte lets go of the data line.
const FREEING_CLOCKS: u32 = 9;

static CONDITION: AtomicU8 = AtomicU8::new(Condition::Absent as u8);
static NUMBER: AtomicU8 = AtomicU8::new(0);
static ERRORS: AtomicU16 = AtomicU16::new(0);
static ANGLE: AtomicI32 = AtomicI32::new(0);

/// Returns what is known of the sensor. The thread does not run meanwhile.
pub fn read() -> Reading {
    let condition = CONDITION.load(Ordering::Relaxed);
    Reading {
        condition: [
            Condition::Running,
            Condition::NoAcknowledge,
            Condition::BusStuck,
            Condition::NoMagnet,
        ]
        .into_iter()
        .find(|it| *it as u8 == condition)
        .unwrap_or_default(),
        errors: ERRORS.load(Ordering::Relaxed),
        number: NUMBER.load(Ordering::Relaxed),
        angle: Angle::from_bits(ANGLE.load(Ordering::Relaxed)),
    }
}

/// Reads the sensor for ever, in the thread.
pub fn spawn(spawner: Spawner, kind: Kind, clock: Peri<'static, PB3>, data: Peri<'static, PB4>) {
    let bus = Bus {
        clock: OutputOpenDrain::new_pull(clock, Level::High, Speed::Low, Pull::Up),
        data: OutputOpenDrain::new_pull(data, Level::High, Speed::Low, Pull::Up),
    };
    // Cannot fail: it is spawned once.
    if let Ok(token) = run(bus, kind) {
        spawner.spawn(token);
    }
}

#[embassy_executor::task]
async fn run(mut bus: Bus, kind: Kind) -> ! {
    let mut ticker = Ticker::every(PERIOD);
    loop {
        ticker.next().await;
        let condition = match bus.read(kind) {
            Ok(angle) => {
                // The number comes last: the control task may run in between.
                ANGLE.store(angle.to_bits(), Ordering::Relaxed);
                let next = NUMBER.load(Ordering::Relaxed).wrapping_add(1);
                NUMBER.store(next, Ordering::Relaxed);
                Condition::Running
            }
            Err(condition) => {
                let errors = ERRORS.load(Ordering::Relaxed).saturating_add(1);
                ERRORS.store(errors, Ordering::Relaxed);
                condition
            }
        };
        CONDITION.store(condition as u8, Ordering::Relaxed);
    }
}

/// The lines of the bus.
struct Bus {
    clock: OutputOpenDrain<'static>,
    data: OutputOpenDrain<'static>,
}

impl Bus {
    fn read(&mut self, kind: Kind) -> Result<Angle, Condition> {
        let (address, register) = kind.registers();
        let mut bytes = [0; LENGTH];
        let read = self.transfer(address << 1, register, &mut bytes);
        // Also after a failure, so that the chip waits for a start.
        let stopped = self.stop();
        read.and(stopped)?;
        kind.decode(&bytes)
    }

    fn transfer(&mut self, address: u8, register: u8, bytes: &mut [u8]) -> Result<(), Condition> {
        self.free()?;
        self.start()?;
        self.send(address)?;
        self.send(register)?;
        self.start()?;
        self.send(address | 1)?;
        let last = bytes.len() - 1;
        for (index, byte) in bytes.iter_mut().enumerate() {
            for _ in 0..8 {
                *byte = *byte << 1 | u8::from(self.bit(true)?);
            }
            // The last byte is not acknowledged: so the chip lets go of the line.
            self.bit(index == last)?;
        }
        Ok(())
    }

    /// Frees the data line if a chip holds it. A transfer that failed has left both lines anyhow.
    fn free(&mut self) -> Result<(), Condition> {
        self.data.set_high();
        self.raise_clock()?;
        for _ in 0..FREEING_CLOCKS {
            if self.data.is_high() {
                return Ok(());
            }
            self.clock.set_low();
            half_clock();
            self.raise_clock()?;
        }
        if self.data.is_high() {
            Ok(())
        } else {
            Err(Condition::BusStuck)
        }
    }

    /// Gives a start condition, also a repeated one.
    fn start(&mut self) -> Result<(), Condition> {
        self.data.set_high();
        half_clock();
        self.raise_clock()?;
        self.data.set_low();
        half_clock();
        self.clock.set_low();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Condition> {
        self.clock.set_low();
        self.data.set_low();
        half_clock();
        self.raise_clock()?;
        self.data.set_high();
        half_clock();
        Ok(())
    }

    /// Sends a byte, which the chip must acknowledge.
    fn send(&mut self, byte: u8) -> Result<(), Condition> {
        for place in (0..8).rev() {
            self.bit(byte >> place & 1 != 0)?;
        }
        if self.bit(true)? {
            Err(Condition::NoAcknowledge)
        } else {
            Ok(())
        }
    }

    /// Exchanges a bit: the level of the data line, which a chip can only lower.
    fn bit(&mut self, level: bool) -> Result<bool, Condition> {
        self.data.set_level(level.into());
        half_clock();
        self.raise_clock()?;
        let read = self.data.is_high();
        self.clock.set_low();
        Ok(read)
    }

    fn raise_clock(&mut self) -> Result<(), Condition> {
        self.clock.set_high();
        for _ in 0..LONGEST_WAIT {
            half_clock();
            if self.clock.is_high() {
                return Ok(());
            }
        }
        Err(Condition::BusStuck)
    }
}

fn half_clock() {
    cortex_m::asm::delay(HALF_CLOCK);
}
