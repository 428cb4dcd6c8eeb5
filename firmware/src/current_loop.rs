//! The PWM interrupt, and the cell through which the control task tells it what to do.

use crate::boards::Bridge;
use core::cell::{Cell, RefCell};
use critical_section::Mutex;
use tautrack::motor::current::CurrentLoop;

/// What the control task wants of the motor until it says otherwise.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Demand {
    /// Open bridge.
    #[default]
    Off,
    /// Shorted winding.
    Brake,
    /// Current, A.
    Current(f32),
}

static DEMAND: Mutex<Cell<Demand>> = Mutex::new(Cell::new(Demand::Off));
static SAMPLE: Mutex<Cell<f32>> = Mutex::new(Cell::new(0.0));
static LOOP: Mutex<RefCell<Option<CurrentLoop>>> = Mutex::new(RefCell::new(None));

/// Hands over the loop; until then the bridge stays off whatever is demanded.
pub fn install(current_loop: CurrentLoop) {
    critical_section::with(|cs| LOOP.borrow(cs).replace(Some(current_loop)));
}

/// Sets what the next PWM period does.
pub fn demand(demand: Demand) {
    critical_section::with(|cs| DEMAND.borrow(cs).set(demand));
}

/// Last sample of the winding's current, A.
pub fn measured() -> f32 {
    critical_section::with(|cs| SAMPLE.borrow(cs).get())
}

/// The PWM interrupt: from the sampled current (A) and the supply (V) to the bridge of the next period.
#[inline]
pub fn pwm_period(sample: f32, bus_voltage: f32) -> Bridge {
    critical_section::with(|cs| {
        SAMPLE.borrow(cs).set(sample);
        let mut current_loop = LOOP.borrow(cs).borrow_mut();
        let Some(current_loop) = current_loop.as_mut() else {
            return Bridge::Off;
        };
        match DEMAND.borrow(cs).get() {
            Demand::Current(current) => {
                Bridge::Drive(current_loop.step(sample, current, bus_voltage))
            }
            demand => {
                current_loop.reset();
                if demand == Demand::Brake {
                    Bridge::Brake
                } else {
                    Bridge::Off
                }
            }
        }
    })
}
