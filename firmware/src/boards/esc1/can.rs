//! FDCAN with classic frames at 1 Mbit/s. After a bus-off, the controller waits for 128 idle
//! sequences as ISO 11898-1 requires, and takes part again.

use super::Interrupts;
use super::clock::CORE_HZ;
use crate::bus::{RECEIVED, TRANSMIT};
use core::num::{NonZeroU8, NonZeroU16};
use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::can::config::NominalBitTiming;
use embassy_stm32::can::{self, CanConfigurator, CanRx, CanTx};
use embassy_stm32::peripherals::{FDCAN1, PA11, PB9};
use embedded_can::{Id, StandardId};
use tautrack::can::Frame;

/// Bit rate, bit/s.
const BIT_RATE: u32 = 1_000_000;
/// Core clocks of a bit.
const BIT_CLOCKS: u32 = CORE_HZ / BIT_RATE;
/// Core clocks from the sample point to the end of a bit: it is sampled at 80 %. The receiver may
/// move the sample point by as much to follow a sender.
const AFTER_SAMPLE: u8 = (BIT_CLOCKS / 5) as u8;
/// Core clocks from the synchronisation segment (one clock) to the sample point.
const BEFORE_SAMPLE: u8 = BIT_CLOCKS as u8 - 1 - AFTER_SAMPLE;

/// Controller that takes part in the bus.
pub struct Bus {
    transmitter: CanTx<'static>,
    receiver: CanRx<'static>,
}

/// Starts the controller.
pub fn start(
    controller: Peri<'static, FDCAN1>,
    receive: Peri<'static, PA11>,
    transmit: Peri<'static, PB9>,
    interrupts: Interrupts,
) -> Bus {
    let mut configurator = CanConfigurator::new(controller, receive, transmit, interrupts);
    let timing = NominalBitTiming {
        prescaler: NonZeroU16::MIN,
        seg1: non_zero(BEFORE_SAMPLE),
        seg2: non_zero(AFTER_SAMPLE),
        sync_jump_width: non_zero(AFTER_SAMPLE),
    };
    configurator.set_config(
        configurator
            .config()
            .set_nominal_bit_timing(timing)
            .set_automatic_bus_off_recovery(true),
    );
    let (transmitter, receiver, _) = configurator.into_normal_mode().split();
    Bus {
        transmitter,
        receiver,
    }
}

const fn non_zero(value: u8) -> NonZeroU8 {
    match NonZeroU8::new(value) {
        Some(value) => value,
        None => NonZeroU8::MIN,
    }
}

impl Bus {
    /// Spawns the tasks that move frames between controller and queues.
    pub fn spawn(self, spawner: Spawner) {
        if let (Ok(receive), Ok(transmit)) = (receive(self.receiver), transmit(self.transmitter)) {
            spawner.spawn(receive);
            spawner.spawn(transmit);
        }
    }
}

#[embassy_executor::task]
async fn receive(mut receiver: CanRx<'static>) -> ! {
    loop {
        // An error is one of the bus. The controller recovers from it by itself.
        if let Ok(envelope) = receiver.read().await
            && let Id::Standard(id) = envelope.frame.id()
            && let Some(frame) = Frame::new(id.as_raw(), envelope.frame.data())
        {
            RECEIVED.push(frame);
        }
    }
}

#[embassy_executor::task]
async fn transmit(mut transmitter: CanTx<'static>) -> ! {
    loop {
        let frame = TRANSMIT.next().await;
        let id = StandardId::new(frame.id());
        if let Some(frame) = id.and_then(|id| can::Frame::new_data(id, frame.data()).ok()) {
            // Returns a waiting frame of lower priority, which the new one has replaced.
            let mut waiting = transmitter.write(&frame).await;
            while let Some(replaced) = waiting {
                waiting = transmitter.write(&replaced).await;
            }
        }
    }
}
