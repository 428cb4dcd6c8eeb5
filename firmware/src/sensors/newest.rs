//! Newest readings of the sensors on the robot's body, from the task that reads them to the control
//! tick.

use core::cell::Cell;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::Instant;
use tautrack::sensors::{BodySensors, Fresh};

/// `None` before the first reading.
static NEWEST: Mutex<CriticalSectionRawMutex, Cell<Option<BodySensors>>> =
    Mutex::new(Cell::new(None));

/// When the control tick has last taken the readings; `None` before it did.
static TAKEN: Mutex<CriticalSectionRawMutex, Cell<Option<Instant>>> = Mutex::new(Cell::new(None));

/// Takes new readings over: `change` writes them and marks them as fresh.
pub fn put(change: impl FnOnce(&mut BodySensors)) {
    NEWEST.lock(|newest| {
        let mut readings = newest.get().unwrap_or(BodySensors {
            fresh: Fresh::NONE,
            ..BodySensors::default()
        });
        change(&mut readings);
        newest.set(Some(readings));
    });
}

/// Returns the newest readings; those are fresh that came since the previous call. `None` before
/// the first reading.
pub fn take() -> Option<BodySensors> {
    TAKEN.lock(|taken| taken.set(Some(Instant::now())));
    NEWEST.lock(|newest| {
        let readings = newest.get()?;
        newest.set(Some(BodySensors {
            fresh: Fresh::NONE,
            ..readings
        }));
        Some(readings)
    })
}

/// Returns when the control tick has last taken the readings; `None` before it did.
pub fn taken() -> Option<Instant> {
    TAKEN.lock(Cell::get)
}
