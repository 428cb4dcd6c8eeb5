//! The PWM interrupt, and the cell in which it shares the current loop with the control task.

use core::cell::RefCell;
use critical_section::Mutex;
use tautrack::motor::bridge::{PowerStage, Readings};
use tautrack::motor::current::{BridgeDemand, CurrentLoop, Means};

static LOOP: Mutex<RefCell<Option<CurrentLoop>>> = Mutex::new(RefCell::new(None));

/// Installs the current loop. Before this call, the bridge stays off whatever the demand is.
#[allow(dead_code)] // `bin/ticks.rs` includes this file but never calls `install`
pub fn install(current_loop: CurrentLoop) {
    critical_section::with(|cs| LOOP.borrow(cs).replace(Some(current_loop)));
}

/// Calls `use_it` with the current loop, if there is one.
#[inline]
fn with<R>(use_it: impl FnOnce(&mut CurrentLoop) -> R) -> Option<R> {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let mut current_loop = LOOP.borrow(cs).try_borrow_mut().ok()?;
        current_loop.as_mut().map(use_it)
    })
}

/// Sets the demand that the bridge follows from the next PWM period on, with the supply voltage, V,
/// and the velocity of the output shaft, rad/s ([`CurrentLoop::demand`]).
pub fn demand(demand: BridgeDemand, supply_voltage: f32, shaft_velocity: f32) {
    with(|current_loop| current_loop.demand(demand, supply_voltage, shaft_velocity));
}

/// Returns what was measured since the last call; `None` if no sample was taken.
pub fn take_means() -> Option<Means> {
    with(CurrentLoop::take_means).flatten()
}

/// Runs one PWM period: computes the command of the next period from the readings of this one.
#[inline]
pub fn pwm_period(readings: &Readings) -> PowerStage {
    with(|current_loop| current_loop.period(readings)).unwrap_or_default()
}
