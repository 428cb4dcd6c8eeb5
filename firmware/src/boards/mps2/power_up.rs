//! Handles the start message: creates the motor and starts the role's tasks.

use super::{chips, clock, flash};
use crate::boards::lockstep::AttachedMotor;
use crate::refusal::{Refusal, refuse};
use crate::roles::{self, Role, Spawners};
use crate::storage;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_executor::raw::Executor;
use tautrack::link::Start;
use tautrack::store::State;

static SERIAL_NUMBER: AtomicU32 = AtomicU32::new(0);

/// Serial number of the simulated board.
pub fn serial_number() -> u32 {
    SERIAL_NUMBER.load(Ordering::Relaxed)
}

/// Creates the motor and calls the role's start function, which spawns the tasks. Runs them up to
/// their first wait. Returns a [`Refusal`] if the motor model or a setting is not valid.
pub(super) fn power_up(
    role: &'static Role,
    executor: &'static Executor,
    start: &Start,
    motor: &mut Option<AttachedMotor>,
) -> Result<(), Refusal> {
    if let Some(model) = start.motor {
        let attached = AttachedMotor::new(model, start.seed);
        *motor = Some(
            attached
                .ok_or_else(|| refuse("the motor model cannot be simulated", "see its bounds"))?,
        );
    }
    chips::power_up(start.seed);
    // The simulator gives every node another seed.
    SERIAL_NUMBER.store(start.seed as u32, Ordering::Relaxed);
    flash::insert(&start.flash)
        .map_err(|()| refuse("flash", "its file cannot be read or has another length"))?;
    let (mut settings, found) = storage::load(&mut flash::Flash);
    let fills = found.state == State::Blank as u8 && !start.settings.is_empty();
    let bus = executor.spawner();
    let spawners = Spawners {
        control: bus.make_send(),
        bus,
    };
    if fills {
        for (key, value) in &start.settings {
            settings
                .set(*key, *value)
                .map_err(|error| refuse("setting", error))?;
        }
        // Settings with which the node does not start must not stay in flash.
        (role.check)(&settings)?;
        storage::create(&mut flash::Flash, &settings).map_err(|error| refuse("flash", error))?;
    }
    if let Some(motor) = motor {
        motor.choose_sensor(&settings);
    }
    if !found.has_settings() && !fills {
        roles::start_blank(spawners, role, found)?;
    } else {
        (role.start)(spawners, &settings, found)?;
    }
    clock::run_until_idle(executor);
    Ok(())
}
