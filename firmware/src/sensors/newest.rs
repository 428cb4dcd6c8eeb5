//! Newest readings of the sensors on the robot's body, from the task that reads them to the control
//! tick.

use core::cell::RefCell;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use tautrack::sensors::{BodySensors, Fresh};

/// `None` before the first reading. Each access changes it in place, because it masks interrupts.
static NEWEST: Mutex<CriticalSectionRawMutex, RefCell<Option<BodySensors>>> =
    Mutex::new(RefCell::new(None));

/// Takes new readings over: `change` writes them and marks them as fresh.
pub fn put(change: impl FnOnce(&mut BodySensors)) {
    NEWEST.lock(|newest| {
        change(newest.borrow_mut().get_or_insert(BodySensors {
            fresh: Fresh::NONE,
            ..BodySensors::default()
        }));
    });
}

/// Returns the newest readings; those are fresh that came since the previous call. `None` before
/// the first reading.
pub fn take() -> Option<BodySensors> {
    NEWEST.lock(|newest| {
        let mut newest = newest.borrow_mut();
        let readings = newest.as_mut()?;
        let taken = *readings;
        readings.fresh = Fresh::NONE;
        Some(taken)
    })
}
