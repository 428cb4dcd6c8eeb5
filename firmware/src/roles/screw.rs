//! Role `screw`: the node of the driving screw, an axle that follows the chassis joint. It receives
//! the joint's motion directly from the joint's node, without the guard.

use super::{Refusal, Role, Spawners, dictionary, drive, refuse, start_bus, startable};
use crate::boards::CONTROL_HZ;
use crate::bus::{Listen, Received};
use crate::storage;
use core::sync::atomic::{AtomicU8, AtomicU16, Ordering};
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;
use tautrack::bus::pdo::{DriveMotion, transmit};
use tautrack::node::screw::{Inputs, Screw};
use tautrack::screw::{Geometry, GeometryError};
use tautrack::settings::{Setting, Settings};

dictionary!(od, "screw.rs");
drive::drive_objects!(od);

/// The role `screw`.
pub static ROLE: Role = Role {
    name: "screw",
    dictionary: od::DICTIONARY,
    check,
    start,
};

/// Communication parameter of the receive PDO for the joint's motion.
const JOINT_PARAMETER: u16 = 0x1403;

static GUARD: AtomicU8 = AtomicU8::new(0);
static JOINT: AtomicU16 = AtomicU16::new(0);

fn check(settings: &Settings) -> Result<(), Refusal> {
    let length = |setting| settings.get(setting);
    let (l1, l2) = (length(Setting::LengthL1), length(Setting::LengthL2));
    Geometry::from_micrometres(l1, l2, length(Setting::LengthK))
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))?;
    drive::current_loop(settings).map(|_| ())
}

fn start(spawners: Spawners, settings: &Settings) -> Result<(), Refusal> {
    let screw = create(settings)?;
    drive::install_current_loop(settings)?;
    let listen = Listen {
        parameter: JOINT_PARAMETER,
        id: transmit(1) + u16::from(settings.id(Setting::JointId)),
    };
    GUARD.store(settings.id(Setting::GuardId), Ordering::Relaxed);
    JOINT.store(listen.id, Ordering::Relaxed);
    start_bus(
        spawners.bus,
        settings,
        od::DICTIONARY,
        Some(listen),
        received,
    )?;
    let control = control(screw, settings.id(Setting::NodeId));
    spawners.control.spawn(startable(control)?);
    Ok(())
}

/// Creates the screw in a static variable. Its table is large: so it is neither copied into the
/// task nor through the stack.
fn create(settings: &Settings) -> Result<&'static mut Screw, Refusal> {
    static SCREW: StaticCell<Result<Screw, GeometryError>> = StaticCell::new();
    SCREW
        .try_init_with(|| Screw::new(settings))
        .ok_or_else(|| refuse("screw", "it was started before"))?
        .as_mut()
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))
}

fn received(received: Received) {
    let joint = JOINT.load(Ordering::Relaxed);
    drive::HEARD.note(&received, GUARD.load(Ordering::Relaxed), Some(joint));
    if received.wrote && received.frame.id() == joint {
        drive::HEARD.note_joint(DriveMotion {
            position: od::OBJECT2100.get_position(),
            velocity: od::OBJECT2100.get_velocity(),
        });
    }
}

#[embassy_executor::task]
async fn control(screw: &'static mut Screw, node: u8) -> ! {
    od::OBJECT2010.set_value(screw.scale().code() | storage::unconfigured_mark());
    od::publish_parameters(&screw.axle().parameters());
    publish_ratings();
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        let bench_mode = bench_mode();
        if let Some(parameters) = new_parameters() {
            screw.configure(&parameters);
        }
        let outputs = screw.tick(&Inputs {
            axle: drive::inputs(set_point, torque_offset, bench_mode),
            joint: drive::HEARD.take_joint(),
            slack: od::OBJECT2101.get_value(),
        });
        drive::act(&outputs, node, None);
        publish(&outputs, bench_mode);
        serve_capture();
    }
}
