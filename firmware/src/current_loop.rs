//! The PWM interrupt, and the cell through which the control task tells it what to do.

use core::cell::{Cell, RefCell};
use critical_section::Mutex;
use tautrack::motor::current::CurrentLoop;
pub use tautrack::node::axle::Bridge as Demand;

/// What the power stage does with one motor for one PWM period.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Bridge {
    /// All transistors open: the winding's current dies in the diodes, the rotor turns freely.
    #[default]
    Off,
    /// Winding shorted: the rotor is braked by its own back-EMF.
    Brake,
    /// Mean voltage on the winding as a share of the supply, -1 to 1.
    Drive(f32),
}

static DEMAND: Mutex<Cell<Demand>> = Mutex::new(Cell::new(Demand::Off));
/// Sum of the samples since the control task last looked, and their number.
static SAMPLES: Mutex<Cell<(f32, u32)>> = Mutex::new(Cell::new((0.0, 0)));
static LOOP: Mutex<RefCell<Option<CurrentLoop>>> = Mutex::new(RefCell::new(None));

/// Hands over the loop; until then the bridge stays off whatever is demanded.
#[allow(dead_code)] // the program `ticks` takes this file without its constructors
pub fn install(current_loop: CurrentLoop) {
    critical_section::with(|cs| LOOP.borrow(cs).replace(Some(current_loop)));
}

/// Sets what the next PWM period does.
pub fn demand(demand: Demand) {
    critical_section::with(|cs| DEMAND.borrow(cs).set(demand));
}

/// Mean of the winding's current since the last call, A; 0 without a sample.
pub fn take_mean() -> f32 {
    let (sum, count) = critical_section::with(|cs| SAMPLES.borrow(cs).take());
    if count == 0 { 0.0 } else { sum / count as f32 }
}

/// The PWM interrupt: from the sampled current (A) and the supply (V) to the bridge of the next period.
#[inline]
pub fn pwm_period(sample: f32, bus_voltage: f32) -> Bridge {
    critical_section::with(|cs| {
        let (sum, count) = SAMPLES.borrow(cs).get();
        SAMPLES
            .borrow(cs)
            .set((sum + sample, count.saturating_add(1)));
        // Never in use elsewhere: the critical section sees to it.
        let Ok(mut current_loop) = LOOP.borrow(cs).try_borrow_mut() else {
            return Bridge::Off;
        };
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
