//! Role `axle`: the node of one motor that follows the set-points from the bus.

use super::{Refusal, Role, Spawners, dictionary, drive, refuse, start_bus, startable};
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::bus::Received;
use crate::{current_loop, storage};
use core::sync::atomic::{AtomicU8, Ordering};
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;
use tautrack::bus::cia402::State;
use tautrack::motor::current::Excitation;
use tautrack::node::axle::{Axle, Inputs, Outputs};
use tautrack::node::calibration::{self, Action, Calibrator};
use tautrack::node::cogging::CoggingSearch;
use tautrack::settings::{Setting, Settings};

dictionary!(od, "axle.rs");
#[cfg(any(test, all(target_os = "none", feature = "cost")))]
pub(crate) use od::DICTIONARY;
drive::drive_objects!(od);

/// The role `axle`.
pub static ROLE: Role = Role {
    name: "axle",
    dictionary: od::DICTIONARY,
    check: |settings| drive::current_loop(settings).map(|_| ()),
    start,
};

static GUARD: AtomicU8 = AtomicU8::new(0);

fn start(spawners: Spawners, settings: &Settings) -> Result<(), Refusal> {
    drive::install_current_loop(settings)?;
    GUARD.store(settings.id(Setting::GuardId), Ordering::Relaxed);
    start_bus(spawners.bus, settings, od::DICTIONARY, None, received)?;
    let parts = create(settings)?;
    let control = control(parts, settings.id(Setting::NodeId));
    spawners.control.spawn(startable(control)?);
    Ok(())
}

/// What the control task owns.
struct Parts {
    axle: &'static mut Axle,
    calibrator: &'static mut Calibrator,
    cogging: &'static mut CoggingSearch,
}

/// Creates the parts in static variables: so they are neither copied into the task nor through the
/// stack.
fn create(settings: &Settings) -> Result<Parts, Refusal> {
    static AXLE: StaticCell<Axle> = StaticCell::new();
    static CALIBRATOR: StaticCell<Calibrator> = StaticCell::new();
    static COGGING: StaticCell<CoggingSearch> = StaticCell::new();
    let stage = &Selected::POWER_STAGE;
    let refused = || refuse("axle", "it was started before");
    Ok(Parts {
        axle: AXLE
            .try_init_with(|| Axle::new(settings))
            .ok_or_else(refused)?,
        calibrator: CALIBRATOR
            .try_init_with(|| Calibrator::new(settings, stage))
            .ok_or_else(refused)?,
        cogging: COGGING
            .try_init_with(|| CoggingSearch::new(settings))
            .ok_or_else(refused)?,
    })
}

fn received(received: Received) {
    drive::HEARD.note(&received, GUARD.load(Ordering::Relaxed), None);
}

#[embassy_executor::task]
async fn control(parts: Parts, node: u8) -> ! {
    let Parts {
        axle,
        calibrator,
        cogging,
    } = parts;
    od::OBJECT2010.set_value(axle.scale().code() | storage::unconfigured_mark());
    od::publish_parameters(&axle.parameters());
    publish_ratings();
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        let bench_mode = bench_mode();
        if let Some(parameters) = new_parameters() {
            axle.configure(&parameters);
        }
        let inputs = drive::inputs(set_point, torque_offset, bench_mode);
        let outputs = axle.tick(&inputs);
        let excitation = calibrate(calibrator, axle, &inputs, &outputs);
        compensate(cogging, axle, &inputs, &outputs);
        drive::act(&outputs, node, excitation.as_ref());
        publish(&outputs, bench_mode);
        serve_capture();
    }
}

/// Runs a tick of the search for the current that cancels the cogging torque, if one is under way
/// or requested.
fn compensate(search: &mut CoggingSearch, axle: &Axle, inputs: &Inputs, outputs: &Outputs) {
    let requested = od::OBJECT2065.get_value() != 0;
    if !(requested || search.is_running()) {
        return;
    }
    if let Some((periods, wave)) = search.tick(requested, inputs, outputs, axle.position()) {
        current_loop::set_cogging(periods, wave);
    }
    od::publish_cogging(search.report());
    if !search.is_running() {
        od::OBJECT2065.set_value(0);
    }
}

/// Runs a tick of the calibration, if one is under way or requested. Returns how it excites the
/// motor.
fn calibrate(
    calibrator: &mut Calibrator,
    axle: &mut Axle,
    inputs: &Inputs,
    outputs: &Outputs,
) -> Option<Excitation> {
    let request = od::OBJECT2050.get_value();
    if request == calibration::request::NONE && !calibrator.is_running() {
        return None;
    }
    let disarmed =
        State::from_statusword(outputs.status.statusword) == Some(State::SwitchOnDisabled);
    let allowed = outputs.bench_mode && disarmed && outputs.faults.is_empty();
    let action = calibrator.tick(
        request,
        allowed,
        &calibration::Inputs {
            encoder: inputs.encoder,
            supply_voltage: inputs.supply_voltage,
            measured: current_loop::take_measurement(inputs.supply_voltage),
        },
    );
    od::publish_calibration(calibrator.report());
    match action {
        Action::Excite(excitation) => return Some(excitation),
        Action::Install(current_loop) => {
            current_loop::install(current_loop);
            axle.use_torque_constant(calibrator.settings());
        }
        Action::None => {}
    }
    od::OBJECT2050.set_value(calibration::request::NONE);
    None
}
