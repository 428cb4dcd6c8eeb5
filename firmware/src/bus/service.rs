//! Task that serves the bus.

use super::{Bus, RECEIVED, Received};
use crate::watchdog::{self, Party};
use embassy_time::{Duration, Instant, with_timeout};

/// Maximum time that a silent bus delays [`Bus::process`], which ends transfers that a client has
/// abandoned.
const IDLE: Duration = Duration::from_millis(5);

/// Serves the bus for ever. Calls `received` for every received frame after the node has followed
/// it.
#[embassy_executor::task]
pub async fn task(mut bus: Bus, received: fn(Received)) -> ! {
    bus.process(Instant::now().as_micros());
    loop {
        let wait = match bus.heartbeat_due_us() {
            Some(due) if watchdog::control_runs(Instant::now().as_micros()) => {
                Duration::from_micros(due.saturating_sub(Instant::now().as_micros())).min(IDLE)
            }
            _ => IDLE,
        };
        let frame = with_timeout(wait, RECEIVED.next()).await;
        let now_us = Instant::now().as_micros();
        watchdog::ran(Party::Bus);
        match frame {
            Ok(frame) => received(bus.receive(frame, now_us)),
            Err(_) => {
                bus.process(now_us);
            }
        }
    }
}
