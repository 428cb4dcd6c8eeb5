//! The PWM interrupt, and the cell through which it receives demands from the control task.
//!
//! A demand is valid for [`DEMAND_CONTROL_PERIODS`] control periods. If the control task sets no
//! new demand in this time, the bridge opens.

use core::cell::{Cell, RefCell};
use critical_section::Mutex;
use tautrack::motor::current::CurrentLoop;
use tautrack::node::axle::BridgeDemand;

/// Action of the power stage on one motor for one PWM period.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Bridge {
    /// All transistors open: the winding's current decays through the diodes, and the rotor turns
    /// freely.
    #[default]
    Off,
    /// Winding shorted: the back-EMF brakes the rotor.
    Brake,
    /// Mean voltage on the winding as a fraction of the supply voltage, -1 to 1.
    Drive(f32),
}

/// Number of control periods after which a demand expires.
pub const DEMAND_CONTROL_PERIODS: u32 = 3;

/// Latest demand, and the number of PWM periods for which it is still valid.
static DEMAND: Mutex<Cell<(BridgeDemand, u32)>> = Mutex::new(Cell::new((BridgeDemand::Off, 0)));
/// Sum of the current samples since the control task last read them, A, and their number.
static SAMPLES: Mutex<Cell<(f32, u32)>> = Mutex::new(Cell::new((0.0, 0)));
/// Current loop, and the number of PWM periods for which a new demand is valid.
static LOOP: Mutex<RefCell<Option<(CurrentLoop, u32)>>> = Mutex::new(RefCell::new(None));

/// Installs the current loop. `pwm_per_control` is the number of PWM periods in a control period.
/// Before this call, the bridge stays off whatever the demand is.
#[allow(dead_code)] // `bin/ticks.rs` includes this file but never calls `install`
pub fn install(current_loop: CurrentLoop, pwm_per_control: u32) {
    let life = DEMAND_CONTROL_PERIODS.saturating_mul(pwm_per_control);
    critical_section::with(|cs| LOOP.borrow(cs).replace(Some((current_loop, life))));
}

/// Sets the demand that the bridge follows from the next PWM period on.
pub fn demand(demand: BridgeDemand) {
    critical_section::with(|cs| {
        let life = match LOOP.borrow(cs).try_borrow() {
            Ok(current_loop) => current_loop.as_ref().map_or(0, |(_, life)| *life),
            Err(_) => 0,
        };
        DEMAND.borrow(cs).set((demand, life));
    });
}

/// Returns the mean of the winding's current since the last call, A; `None` if no sample was taken.
pub fn take_mean() -> Option<f32> {
    let (sum, count) = critical_section::with(|cs| SAMPLES.borrow(cs).take());
    (count > 0).then(|| sum / count as f32)
}

/// Runs one PWM period: computes the bridge for the next period from the sampled current (A) and
/// the supply voltage (V).
#[inline]
pub fn pwm_period(sample: f32, supply_voltage: f32) -> Bridge {
    critical_section::with(|cs| {
        let (sum, count) = SAMPLES.borrow(cs).get();
        SAMPLES
            .borrow(cs)
            .set((sum + sample, count.saturating_add(1)));
        // Cannot fail: the critical section excludes any other borrow.
        let Ok(mut current_loop) = LOOP.borrow(cs).try_borrow_mut() else {
            return Bridge::Off;
        };
        let Some((current_loop, _)) = current_loop.as_mut() else {
            return Bridge::Off;
        };
        let (demand, left) = DEMAND.borrow(cs).get();
        let Some(left) = left.checked_sub(1) else {
            current_loop.reset();
            return Bridge::Off;
        };
        DEMAND.borrow(cs).set((demand, left));
        match demand {
            BridgeDemand::Current(current) => {
                Bridge::Drive(current_loop.step(sample, current, supply_voltage))
            }
            demand => {
                current_loop.reset();
                if demand == BridgeDemand::Brake && current_loop.may_brake(sample) {
                    Bridge::Brake
                } else {
                    Bridge::Off
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Mutex as TestMutex, MutexGuard, PoisonError};
    use tautrack::motor::current::Winding;

    /// Installs a current loop. The returned lock lets one test at a time use the statics.
    fn installed() -> MutexGuard<'static, ()> {
        static ONE: TestMutex<()> = TestMutex::new(());
        let guard = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        let winding = Winding {
            resistance: 0.6,
            inductance: 3e-4,
            current_limit: 10.0,
        };
        install(CurrentLoop::new(&winding, 4_000.0, 20_000.0).unwrap(), 20);
        guard
    }

    #[test]
    fn a_demand_expires_after_three_control_periods() {
        let _one = installed();
        for kind in [BridgeDemand::Current(5.0), BridgeDemand::Brake] {
            demand(kind);
            for period in 0..60 {
                assert_ne!(pwm_period(0.0, 24.0), Bridge::Off, "{kind:?} {period}");
            }
            for _ in 0..1_000 {
                assert_eq!(pwm_period(0.0, 24.0), Bridge::Off, "{kind:?}");
            }
        }
        // After the expiry, the next demand is followed as usual.
        demand(BridgeDemand::Current(5.0));
        assert_ne!(pwm_period(0.0, 24.0), Bridge::Off);
    }

    #[test]
    fn no_sample_is_not_a_current_of_zero() {
        let _one = installed();
        take_mean();
        assert_eq!(take_mean(), None);
        pwm_period(2.0, 24.0);
        pwm_period(4.0, 24.0);
        assert_eq!(take_mean(), Some(3.0));
        assert_eq!(take_mean(), None);
    }

    #[test]
    fn a_brake_opens_while_its_current_is_beyond_the_limit() {
        let _one = installed();
        demand(BridgeDemand::Brake);
        for (sample, bridge) in [
            (9.9, Bridge::Brake),
            (-9.9, Bridge::Brake),
            (10.1, Bridge::Off),
            (-80.0, Bridge::Off),
            (f32::NAN, Bridge::Off),
        ] {
            assert_eq!(pwm_period(sample, 24.0), bridge, "{sample}");
        }
    }
}
