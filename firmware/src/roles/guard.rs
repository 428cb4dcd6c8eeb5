//! Role `guard`: the robot's body controller and stability filter, master of the CANopen network,
//! and inclinometer after CiA 410.

use super::{Role, Spawners, send};
use crate::boards::{Board, Selected};
use crate::refusal::{Refusal, refuse};
use crate::sensors::{Published, Rates};
use crate::storage::Storage;
use crate::{check, log_lines, serial};
use core::mem::MaybeUninit;
use static_cell::StaticCell;
use tautrack::bus::network::NmtState;
use tautrack::bus::node::Condition;
use tautrack::can::Frame;
use tautrack::fault_log::FaultLog;
use tautrack::node::guard::Guard;
use tautrack::robots::Body;
use tautrack::roles::guard::{self, Readings};
use tautrack::roles::guard_objects::TABLE;
use tautrack::roles::settings::Found;
use tautrack::settings::Settings;

/// Defines one role per robot, `<folder>::ROLE`, with the guard for that robot.
macro_rules! guards {
    ($($folder:ident::$body:ident: $about:literal,)*) => {$(
        #[doc = $about]
        pub mod $folder {
            use super::{Guard, Node, Role, StaticCell, TABLE, check, start};
            use tautrack::robots::$folder::$body;

            /// The role `guard` of this robot.
            pub static ROLE: Role = Role {
                name: "guard",
                table: &TABLE,
                shaft_sensor: false,
                check: check::guard::<$body>,
                start: {
                    static GUARD: StaticCell<Guard<$body>> = StaticCell::new();
                    static NODE: StaticCell<Node<$body>> = StaticCell::new();
                    |spawners, settings, found| start(spawners, settings, found, &GUARD, &NODE)
                },
            };
        }
    )*};
}

tautrack::every_robot!(guards);

/// Maximum number of bytes from the serial line in one tick; 115200 baud bring 12.
const MAX_SERIAL: usize = 64;

type Node<B> = guard::Node<&'static mut Guard<B>, Storage<<Selected as Board>::Storage>>;

/// What the sensors' task tells the node.
static SENSORS: Published = Published::new();

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

    fn note_bus(&mut self, condition: Condition) {
        guard::Node::note_bus(self, condition, &mut send);
    }

    fn tick(&mut self, now_us: u64) -> bool {
        let mut bytes = [0; MAX_SERIAL];
        let count = serial::take(&mut bytes);
        let switches = Selected::operator_switches();
        let readings = Readings {
            body: SENSORS.newest.take(),
            serial: bytes.get(..count).unwrap_or(&[]),
            dead_man_released: switches.dead_man_released,
            emergency_stop: switches.emergency_stop,
            chips: SENSORS.conditions.codes(),
        };
        let found = guard::Node::tick(self, now_us, &readings, &mut send);
        log_lines::guard(&found);
        found.restart
    }

    fn state(&self) -> NmtState {
        guard::Node::state(self)
    }

    fn errors(&mut self) -> &mut FaultLog {
        guard::Node::errors(self)
    }
}

fn start<B: Body>(
    spawners: Spawners,
    settings: &Settings,
    found: Found,
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
        .try_init_with(|| {
            let storage = Storage::new(settings, found, check::guard::<B>, Selected::storage());
            guard::Node::new(settings, guard, storage, serial)
        })
        .ok_or_else(twice)?;
    Selected::start_sensors(spawners.bus, Rates::new(settings), &SENSORS)
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
