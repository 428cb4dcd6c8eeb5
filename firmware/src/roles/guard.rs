//! Role `guard`: the robot's body controller and stability filter, master of the CANopen network,
//! and inclinometer after CiA 410.

use super::{Refusal, Role, Spawners, refuse, send};
use crate::boards::{Board, Selected};
use crate::sensors::condition::{self, Chip};
use crate::sensors::{Rates, newest};
use crate::serial;
use crate::storage::Flash;
use core::mem::MaybeUninit;
use static_cell::StaticCell;
use tautrack::bus::network::NmtState;
use tautrack::can::Frame;
use tautrack::math::to_i16;
use tautrack::node::guard::Guard;
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::roles::guard::{self, Found, Readings};
use tautrack::roles::guard_objects::TABLE;
use tautrack::settings::Settings;
use tautrack::stability::trust::Trust;

/// Defines one role per robot, with the guard for that robot.
macro_rules! guards {
    ($($(#[doc = $doc:literal])* $role:ident: $body:ty;)*) => {$(
        $(#[doc = $doc])*
        pub static $role: Role = Role {
            name: "guard",
            table: &TABLE,
            check: check::<$body>,
            start: {
                static GUARD: StaticCell<Guard<$body>> = StaticCell::new();
                static NODE: StaticCell<Node<$body>> = StaticCell::new();
                |spawners, settings| start(spawners, settings, &GUARD, &NODE)
            },
        };
    )*};
}

guards! {
    /// The tracked robot of Paillat et al.
    B2P2: B2p2;
    /// The tracked robot of Kurc and Szybicki.
    CRAWLER: Crawler;
    /// The wheel-legged robot of Besseron et al.
    HYLOS: Hylos;
    /// The leg-wheel robot of Nakajima.
    RT_MOVER: RtMover;
}

/// Maximum number of bytes from the serial line in one tick; 115200 baud bring 12.
const MAX_SERIAL: usize = 64;

type Node<B> = guard::Node<&'static mut Guard<B>, Flash>;

impl<B: Body> super::Node for Node<B>
where
    Guard<B>: Send,
{
    fn boot(&mut self, now_us: u64) {
        guard::Node::boot(self, now_us, &mut send);
    }

    fn receive(&mut self, frame: &Frame, now_us: u64) {
        guard::Node::receive(self, frame, now_us, &mut send);
    }

    fn tick(&mut self, now_us: u64) {
        let mut bytes = [0; MAX_SERIAL];
        let count = serial::take(&mut bytes);
        let switches = Selected::operator_switches();
        let readings = Readings {
            body: newest::take(),
            serial: bytes.get(..count).unwrap_or(&[]),
            dead_man_released: switches.dead_man_released,
            emergency_stop: switches.emergency_stop,
            chips: Chip::ALL.map(|chip| (condition::code(chip), condition::errors(chip))),
        };
        log(&guard::Node::tick(self, now_us, &readings, &mut send));
    }

    fn state(&self) -> NmtState {
        guard::Node::state(self)
    }
}

/// Logs what a tick has found.
fn log(found: &Found) {
    if let Some((code, node)) = found.fault {
        crate::logger::warn!("fault {:#06x} of node {}", code, node);
    }
    if let Some(mismatch) = found.mismatch {
        crate::logger::warn!(
            "node {}: position scale {:#06x}, the guard counts in {:#06x}",
            mismatch.node,
            mismatch.found,
            mismatch.expected
        );
    }
    if let Some(trip) = found.trip {
        crate::logger::warn!(
            "tripped: cause {:#04x}, margin {} mm",
            trip.cause.code(),
            to_i16(trip.margins[trip.edge as usize] * 1e3)
        );
    }
    if let Some((sensor, health)) = found.sensor {
        if let Some(Trust::Degraded(reason) | Trust::None(reason)) = Trust::from_code(health) {
            crate::logger::warn!("{}: {}", sensor.name(), reason.words());
        } else {
            crate::logger::info!("{}: believed", sensor.name());
        }
    }
}

/// Inlined nowhere: a robot's model takes much stack.
#[inline(never)]
fn check<B: Body>(settings: &Settings) -> Result<(), Refusal> {
    let body = B::new(settings).map(|_| ());
    body.map_err(|error| refuse("robot", format_args!("{error:?}")))
}

fn start<B: Body>(
    spawners: Spawners,
    settings: &Settings,
    guard: &'static StaticCell<Guard<B>>,
    node: &'static StaticCell<Node<B>>,
) -> Result<(), Refusal>
where
    Guard<B>: Send,
{
    let twice = || refuse("guard", "it was started before");
    let guard = create(settings, guard.try_uninit().ok_or_else(twice)?)?;
    let serial = Selected::serial_number();
    let node = node
        .try_init_with(|| guard::Node::new(settings, guard, Flash, serial))
        .ok_or_else(twice)?;
    Selected::start_sensors(spawners.bus, Rates::new(settings))
        .map_err(|error| refuse("sensors", error))?;
    super::spawn(spawners, node)
}

/// Creates the guard in `cell`. It is inlined nowhere and has no combinator between constructor and
/// cell: each copy of a guard takes 8 KiB of stack.
#[inline(never)]
fn create<B: Body>(
    settings: &Settings,
    cell: &'static mut MaybeUninit<Guard<B>>,
) -> Result<&'static mut Guard<B>, Refusal> {
    match constructed(settings) {
        Ok(guard) => Ok(cell.write(guard)),
        Err(error) => Err(refuse("robot", format_args!("{error:?}"))),
    }
}

/// [`Guard::new`], inlined nowhere.
#[inline(never)]
fn constructed<B: Body>(settings: &Settings) -> Result<Guard<B>, B::Refusal> {
    Guard::new(settings)
}
