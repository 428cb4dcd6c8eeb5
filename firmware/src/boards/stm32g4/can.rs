//! FDCAN with classic frames at 1 Mbit/s. After a bus-off, the controller waits for 128 idle
//! sequences as ISO 11898-1 requires, and takes part again. Frames that wait for the bus for too
//! long are dropped ([`MAX_WAIT`]).

use super::clock::CORE_HZ;
use crate::boards::portable;
use crate::bus::{RECEIVED, TRANSMIT};
use core::num::{NonZeroU8, NonZeroU16};
use embassy_executor::Spawner;
use embassy_stm32::can::config::NominalBitTiming;
use embassy_stm32::can::{
    self, CanConfigurator, CanRx, CanTx, IT0InterruptHandler, IT1InterruptHandler, TxPin,
};
use embassy_stm32::peripherals::{FDCAN1, PA11};
use embassy_stm32::{Peri, bind_interrupts, pac};
use embassy_time::{Duration, with_timeout};
use tautrack::bus::node::Condition;

/// Buffers of the controller's queue.
const BUFFERS: usize = 3;
/// Bit rate, bit/s.
const BIT_RATE: u32 = 1_000_000;
/// Core clocks of a bit.
const BIT_CLOCKS: u32 = CORE_HZ / BIT_RATE;
/// Core clocks from the sample point to the end of a bit: it is sampled at 80 %. The receiver may
/// move the sample point by as much to follow a sender.
const AFTER_SAMPLE: u8 = (BIT_CLOCKS / 5) as u8;
/// Core clocks from the synchronisation segment (one clock) to the sample point.
const BEFORE_SAMPLE: u8 = BIT_CLOCKS as u8 - 1 - AFTER_SAMPLE;

/// Time after which the frames that wait are out of date, if the bus has taken none: nobody
/// acknowledges, or a bus-off. The controller holds three frames, so a frame is at most four times
/// as old when it is sent. It is longer than a full bus delays the least urgent frame.
const MAX_WAIT: Duration = Duration::from_millis(20);

bind_interrupts!(struct Interrupts {
    FDCAN1_IT0 => IT0InterruptHandler<FDCAN1>;
    FDCAN1_IT1 => IT1InterruptHandler<FDCAN1>;
});

/// Controller that takes part in the bus.
pub struct Bus {
    transmitter: CanTx<'static>,
    receiver: CanRx<'static>,
}

/// Starts the controller.
pub fn start(
    controller: Peri<'static, FDCAN1>,
    receive: Peri<'static, PA11>,
    transmit: Peri<'static, impl TxPin<FDCAN1>>,
) -> Bus {
    let mut configurator = CanConfigurator::new(controller, receive, transmit, Interrupts);
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

/// Condition of the controller since the last call.
pub fn condition() -> Condition {
    // Reading the status resets the code of the last error, which nobody else uses.
    let status = pac::FDCAN1.psr().read();
    let lost = pac::FDCAN1.ir().read().rfl(0);
    if lost {
        pac::FDCAN1.ir().write(|w| w.set_rfl(0, true));
    }
    Condition {
        overrun: lost,
        passive: status.ep(),
        off: status.bo(),
    }
}

#[embassy_executor::task]
async fn receive(mut receiver: CanRx<'static>) -> ! {
    loop {
        // An error is one of the bus. The controller recovers from it by itself.
        if let Ok(envelope) = receiver.read().await
            && let Some(frame) = portable::received(&envelope.frame)
        {
            RECEIVED.push(frame);
        }
    }
}

#[embassy_executor::task]
async fn transmit(mut transmitter: CanTx<'static>) -> ! {
    loop {
        let mut waits = false;
        let next = async {
            let frame = TRANSMIT.next().await;
            waits = true;
            if let Some(frame) = portable::to_send(&frame) {
                write(&mut transmitter, frame).await;
            }
        };
        if with_timeout(MAX_WAIT, next).await.is_err() {
            pac::FDCAN1.txbcr().write(|w| {
                (0..BUFFERS).for_each(|buffer| w.set_cr(buffer, true));
            });
            while waits && TRANSMIT.pop().is_some() {}
        }
    }
}

/// Puts a frame into the controller's queue.
async fn write(transmitter: &mut CanTx<'static>, frame: can::Frame) {
    // Returns a waiting frame of lower priority, which the new one has replaced.
    let mut waiting = transmitter.write(&frame).await;
    while let Some(replaced) = waiting {
        waiting = transmitter.write(&replaced).await;
    }
}
