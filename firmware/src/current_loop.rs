//! The PWM interrupt, and the cells in which it shares the current loop and the recording of its
//! signals with the control task.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use heapless::Vec;
use tautrack::motor::bridge::{PowerStage, Readings};
use tautrack::motor::capture::{Capture, Request, Signals};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{BridgeDemand, Config, CurrentLoop, Excitation, Means, Measurement};

/// The current loop, if there is one. An `Option` would be 500 bytes of flash memory, because its
/// initial value is not all zeros.
static LOOP: Mutex<RefCell<Vec<CurrentLoop, 1>>> = Mutex::new(RefCell::new(Vec::new()));

static CAPTURE: Mutex<RefCell<Capture>> = Mutex::new(RefCell::new(Capture::new()));
/// The recording needs samples. It is all that the interrupt reads of a recording that is off.
static CAPTURING: AtomicBool = AtomicBool::new(false);

/// Calls `use_it` with the recording.
pub fn capture<R>(use_it: impl FnOnce(&mut Capture) -> R) -> Option<R> {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let mut capture = CAPTURE.borrow(cs).try_borrow_mut().ok()?;
        let result = use_it(&mut capture);
        CAPTURING.store(capture.is_active(), Ordering::Relaxed);
        Some(result)
    })
}

/// Follows a client's request for a recording ([`Capture::request`]).
pub fn request_capture(request: Request) {
    capture(|capture| capture.request(request));
}

/// Records one PWM period.
#[cold]
fn record(signals: &Signals) {
    capture(|capture| capture.record(signals));
}

/// Installs the current loop. Before this call, the bridge stays off whatever the demand is.
pub fn install(current_loop: CurrentLoop) {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let Ok(mut installed) = LOOP.borrow(cs).try_borrow_mut() else {
            return;
        };
        installed.clear();
        // Cannot fail: there is room for one.
        let _ = installed.push(current_loop);
    });
}

/// Calls `use_it` with the current loop, if there is one.
#[inline]
fn with<R>(use_it: impl FnOnce(&mut CurrentLoop) -> R) -> Option<R> {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let mut current_loop = LOOP.borrow(cs).try_borrow_mut().ok()?;
        current_loop.first_mut().map(use_it)
    })
}

/// Takes over the current limit ([`CurrentLoop::set_limits`]).
pub fn set_limits(config: &Config) {
    with(|current_loop| current_loop.set_limits(config));
}

/// Returns the current limit and the zeros in force ([`CurrentLoop::over_current`]).
pub fn over_current() -> Option<(f32, [i32; 3])> {
    with(|current_loop| current_loop.over_current())
}

/// Sets the current that cancels the cogging torque ([`CurrentLoop::set_cogging`]).
pub fn set_cogging(periods: i32, wave: Wave) {
    with(|current_loop| current_loop.set_cogging(periods, wave));
}

/// Sets the demand that the bridge follows from the next PWM period on, with the supply voltage, V,
/// and the velocity of the output shaft, rad/s ([`CurrentLoop::demand`]).
pub fn demand(demand: BridgeDemand, supply_voltage: f32, shaft_velocity: f32) {
    with(|current_loop| current_loop.demand(demand, supply_voltage, shaft_velocity));
}

/// Excites the motor from the next PWM period on ([`CurrentLoop::excite`]).
pub fn excite(excitation: &Excitation, supply_voltage: f32) {
    with(|current_loop| current_loop.excite(excitation, supply_voltage));
}

/// Returns what the excitation has measured since the last call; `None` without a sample.
pub fn take_measurement(supply_voltage: f32) -> Option<Measurement> {
    with(|current_loop| current_loop.take_measurement(supply_voltage)).flatten()
}

/// Returns what was measured since the last call; `None` if no sample was taken.
///
/// `index` returns the count of a new pulse of the encoder's index. No PWM period begins between
/// the two: otherwise a rotor at high speed would be counts beyond a pulse that is not known yet.
pub fn take_means(index: impl FnOnce() -> Option<u32>) -> Option<Means> {
    with(|current_loop| {
        if let Some(count) = index() {
            current_loop.index_pulse(count);
        }
        current_loop.take_means()
    })
    .flatten()
}

/// Runs one PWM period: computes the command of the next period from the readings of this one.
#[inline]
pub fn pwm_period(readings: &Readings) -> PowerStage {
    with(|current_loop| {
        let stage = current_loop.period(readings);
        if CAPTURING.load(Ordering::Relaxed) {
            record(&current_loop.signals(readings, stage));
        }
        stage
    })
    .unwrap_or_default()
}
