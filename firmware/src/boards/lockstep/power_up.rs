//! Handles the start message: creates the motor and starts the role's tasks.

use super::{POWER_STAGE, clock};
use crate::roles::{Refusal, Role, Spawners, refuse};
use embassy_executor::raw::Executor;
use tautrack::link::{Start, VERSION};
use tautrack::motor::model::Motor;
use tautrack::settings::Settings;

/// Creates the motor and calls the role's start function, which spawns the tasks. Runs them up to
/// their first wait. Returns a [`Refusal`] if the link version, the motor model or a setting is not
/// valid.
pub(super) fn power_up(
    role: &'static Role,
    executor: &'static Executor,
    start: &Start,
    motor: &mut Option<Motor>,
) -> Result<(), Refusal> {
    if start.version != VERSION {
        return Err(refuse(
            "the simulator speaks another version of the link",
            start.version,
        ));
    }
    if let Some(model) = start.motor {
        *motor = Some(
            Motor::new(model, POWER_STAGE, start.seed)
                .ok_or_else(|| refuse("the motor model cannot be simulated", "see its bounds"))?,
        );
    }
    let mut settings = Settings::default();
    for (key, value) in &start.settings {
        settings
            .set(*key, *value)
            .map_err(|error| refuse("setting", error))?;
    }
    let bus = executor.spawner();
    let spawners = Spawners {
        control: bus.make_send(),
        bus,
    };
    (role.start)(spawners, &settings)?;
    clock::run_until_idle(executor);
    Ok(())
}
