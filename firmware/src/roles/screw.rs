//! Role `screw`: the node of the driving screw, an axle that follows the chassis joint. It receives
//! the joint's motion directly from the joint's node, without the guard.

use super::drive::Measurements;
use super::{Refusal, Role, Spawners, dictionary, drive, refuse, start_bus, startable};
use crate::boards::CONTROL_HZ;
use crate::bus::{Listen, Received, Written};
use core::sync::atomic::{AtomicU16, Ordering};
use embassy_time::{Duration, Ticker};
use static_cell::{ConstStaticCell, StaticCell};
use tautrack::bus::pdo::{DriveMotion, transmit};
use tautrack::node::screw::{self, Inputs};
use tautrack::screw::Geometry;
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

static JOINT: AtomicU16 = AtomicU16::new(0);

fn check(settings: &Settings) -> Result<(), Refusal> {
    let length = |setting| settings.get(setting);
    let (l1, l2) = (length(Setting::LengthL1), length(Setting::LengthL2));
    Geometry::check_micrometres(l1, l2, length(Setting::LengthK))
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))?;
    drive::current_loop(settings).map(|_| ())
}

fn start(spawners: Spawners, settings: &Settings) -> Result<(), Refusal> {
    let screw = create(settings, create_geometry(settings)?)?;
    drive::install_current_loop(settings)?;
    let listen = Listen {
        parameter: JOINT_PARAMETER,
        id: transmit(1) + u16::from(settings.id(Setting::JointId)),
    };
    drive::HEARD.start(settings, listen.id);
    JOINT.store(listen.id, Ordering::Relaxed);
    start_bus(
        spawners.bus,
        settings,
        od::DICTIONARY,
        Some(listen),
        received,
        |_| true,
    )?;
    let measurements = Measurements::create(settings)?;
    let control = control(screw, measurements, settings.id(Setting::NodeId));
    spawners.control.spawn(startable(control)?);
    Ok(())
}

/// A screw whose geometry, with a large table, is in a static variable.
type Screw = tautrack::node::screw::Screw<&'static Geometry>;

/// Creates the geometry in a static variable: so it is not copied through the stack.
fn create_geometry(settings: &Settings) -> Result<&'static Geometry, Refusal> {
    static GEOMETRY: ConstStaticCell<Option<Geometry>> = ConstStaticCell::new(None);
    let place = GEOMETRY
        .try_take()
        .ok_or_else(|| refuse("screw", "it was started before"))?;
    screw::geometry_in(place, settings)
        .map_err(|error| refuse("geometry", format_args!("{error:?}")))
}

/// Creates the screw in a static variable: so it is not copied into the task.
#[inline(never)]
fn create(settings: &Settings, geometry: &'static Geometry) -> Result<&'static mut Screw, Refusal> {
    static SCREW: StaticCell<Screw> = StaticCell::new();
    SCREW
        .try_init_with(|| Screw::with_geometry(settings, geometry))
        .ok_or_else(|| refuse("screw", "it was started before"))
}

fn received(received: Received) {
    let joint = JOINT.load(Ordering::Relaxed);
    drive::HEARD.note(&received);
    if received.wrote == Written::ProcessData && received.frame.id() == joint {
        drive::HEARD.note_joint(DriveMotion {
            position: od::OBJECT2100.get_position(),
            velocity: od::OBJECT2100.get_velocity(),
        });
    }
}

#[embassy_executor::task]
async fn control(screw: &'static mut Screw, mut measurements: Measurements, node: u8) -> ! {
    publish_start(screw.axle());
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        let inputs = Inputs {
            axle: inputs(screw.axle_mut()),
            joint: drive::HEARD.take_joint(),
            slack: od::OBJECT2101.get_value(),
        };
        if inputs.axle.guard_received {
            // A slack is for bench mode.
            od::OBJECT2101.set_value(0);
        }
        let outputs = screw.tick(&inputs);
        let axle = screw.axle_mut();
        finish(&mut measurements, axle, &inputs.axle, &outputs, node);
    }
}
