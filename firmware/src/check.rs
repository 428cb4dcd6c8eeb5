//! Checks whether a node would start with its settings, by role.

use crate::boards::{LIMITS, POWER_STAGE};
use crate::refusal::{Refusal, refuse};
use tautrack::motor::board_limits;
use tautrack::motor::current::{CurrentLoop, CurrentLoopError};
use tautrack::robots::Body;
use tautrack::roles::drive;
use tautrack::screw::Geometry;
use tautrack::settings::{Setting, Settings};

/// Returns a [`Refusal`] if an axle would not start with these settings.
pub fn axle(settings: &Settings) -> Result<(), Refusal> {
    current_loop(settings).map(|_| ())
}

/// Returns a [`Refusal`] if a screw would not start with these settings.
pub fn screw(settings: &Settings) -> Result<(), Refusal> {
    let length = |setting| settings.get(setting);
    let (l1, l2) = (length(Setting::LengthL1), length(Setting::LengthL2));
    Geometry::check_micrometres(l1, l2, length(Setting::LengthK))
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))?;
    if settings.get(Setting::ShaftSensor) != 0 {
        return Err(refuse("shaft_sensor", "a screw turns more than once"));
    }
    axle(settings)
}

/// Returns a [`Refusal`] if a guard of this robot would not start with these settings. Inlined
/// nowhere: a robot's model takes much stack.
#[inline(never)]
pub fn guard<B: Body>(settings: &Settings) -> Result<(), Refusal> {
    let body = B::new(settings).map(|_| ());
    body.map_err(|error| refuse("robot", format_args!("{error:?}")))
}

/// Computes the current loop for the motor in the settings. Returns a [`Refusal`] if that cannot
/// be done, or if the board does not bear the settings.
pub fn current_loop(settings: &Settings) -> Result<CurrentLoop, Refusal> {
    board_limits::check(LIMITS, settings).map_err(|error| refuse(error.limit.name, error))?;
    drive::current_loop(settings, &POWER_STAGE).map_err(|error| match error {
        CurrentLoopError::SupplyTooHigh(error) => refuse("velocity_limit", error),
        error => refuse("current loop", error),
    })
}
