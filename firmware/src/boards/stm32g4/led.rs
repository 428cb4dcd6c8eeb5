//! The LED shows the state of the node as a number of flashes per second.

use super::reset;
use crate::boards::Selected;
use crate::roles;
use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Pin, Speed};
use embassy_time::Timer;

/// State that the LED shows, by its number of flashes.
#[derive(Clone, Copy)]
enum Pattern {
    /// NMT state "operational": the guard controls the node.
    Operational = 1,
    /// The node runs and waits for the guard.
    Waiting = 2,
    /// An input of the board prevents motion.
    Stopped = 3,
    /// The node refuses its settings.
    Refused = 4,
}

impl Pattern {
    fn now(started: bool) -> Self {
        if !started {
            Self::Refused
        } else if Selected::stopped() {
            Self::Stopped
        } else if roles::operational() {
            Self::Operational
        } else {
            Self::Waiting
        }
    }
}

/// Spawns the task of the LED. It feeds the watchdog of a node that was not `started`, because no
/// other task does.
pub fn spawn(spawner: Spawner, pin: Peri<'static, impl Pin>, started: bool) {
    let led = Output::new(pin, Level::Low, Speed::Low);
    if let Ok(task) = blink(led, started) {
        spawner.spawn(task);
    }
}

#[embassy_executor::task]
async fn blink(mut led: Output<'static>, started: bool) -> ! {
    /// Tenths of a second in a cycle, which are fewer than the watchdog's period.
    const SLOTS: u32 = 10;
    loop {
        let flashes = Pattern::now(started) as u32;
        for slot in 0..4 * SLOTS {
            let (tenth, quarter) = (slot / 4, slot % 4);
            led.set_level((quarter < 2 && tenth < 2 * flashes && tenth % 2 == 0).into());
            if !started {
                reset::feed_watchdog();
            }
            Timer::after_millis(25).await;
        }
    }
}
