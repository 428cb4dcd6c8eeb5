//! Role `guard`: the robot's body controller and stability filter, master of the CANopen network,
//! and inclinometer after CiA 410.

use super::dead_man::DeadMan;
use super::{Refusal, Role, Spawners, dictionary, milli, refuse, start_bus, startable};
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::bus::{self, FrameQueue, Received, Written};
use crate::sensors::condition::{self, Chip};
use crate::sensors::{Rates, newest};
use crate::{serial, storage};
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_time::{Duration, Instant, Ticker};
use heapless::Vec;
use static_cell::StaticCell;
use tautrack::bus::network::{self, Emergency};
use tautrack::bus::pdo::{GuardPosition, OperatorCommand};
use tautrack::can::Frame;
use tautrack::estimate::state::{Estimator, State};
use tautrack::math::to_i32;
use tautrack::node::guard::commissioning::{self, Report};
use tautrack::node::guard::{Guard, Inputs, Outputs, ScaleMismatch, Telemetry};
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::sensors::Sensor;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::sensor_watch::SensorState;
use tautrack::stability::trust::Trust;
use tautrack::units::Angle;

dictionary!(od, "guard.rs");

/// Defines one role per robot, with the guard for that robot.
macro_rules! guards {
    ($($(#[doc = $doc:literal])* $role:ident: $body:ty;)*) => {$(
        $(#[doc = $doc])*
        pub static $role: Role = Role {
            name: "guard",
            dictionary: od::DICTIONARY,
            check: check::<$body>,
            start: {
                static GUARD: StaticCell<Guard<$body>> = StaticCell::new();
                |spawners, settings| start(spawners, settings, &GUARD)
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

/// Guard of any robot. The control task may run on an executor of its own.
trait Tick: Send {
    fn tick(&mut self, inputs: &Inputs<'_>);
    fn outputs(&self) -> &Outputs;
    fn telemetry(&self) -> Telemetry;
    fn estimator(&self) -> &Estimator;
    fn scale_mismatch(&self) -> Option<ScaleMismatch>;
    fn sensor(&self, sensor: Sensor) -> SensorState;
    fn commission(&mut self, request: u8);
    fn commissioning(&self) -> &Report;
}

impl<B: Body> Tick for Guard<B>
where
    Self: Send,
{
    fn tick(&mut self, inputs: &Inputs<'_>) {
        Guard::tick(self, inputs);
    }

    fn outputs(&self) -> &Outputs {
        Guard::outputs(self)
    }

    fn telemetry(&self) -> Telemetry {
        Guard::telemetry(self)
    }

    fn estimator(&self) -> &Estimator {
        Guard::estimator(self)
    }

    fn scale_mismatch(&self) -> Option<ScaleMismatch> {
        Guard::scale_mismatch(self)
    }

    fn sensor(&self, sensor: Sensor) -> SensorState {
        Guard::sensor(self, sensor)
    }

    fn commission(&mut self, request: u8) {
        Guard::commission(self, request);
    }

    fn commissioning(&self) -> &Report {
        Guard::commissioning(self)
    }
}

/// Code of the guard's highest state in which no drive is led up or holds for it.
const READY: u8 = 1;

/// Object of the operator's command, and the sub-index of its sequence number.
const COMMAND: u16 = 0x4000;
const SEQUENCE: u8 = 5;

/// Maximum number of frames between two ticks; a 1 Mbit/s bus carries fewer in 1 ms.
const MAX_RECEIVED: usize = 32;

/// Maximum number of bytes from the serial line in one tick; 115200 baud bring 12.
const MAX_SERIAL: usize = 64;

/// Received frames for the next tick.
static HEARD: FrameQueue<MAX_RECEIVED> = FrameQueue::new();
/// Whether the operator's objects were written since the last tick.
static OPERATOR: AtomicBool = AtomicBool::new(false);

/// Inlined nowhere: a robot's model takes much stack.
#[inline(never)]
fn check<B: Body>(settings: &Settings) -> Result<(), Refusal> {
    let body = B::new(settings).map(|_| ());
    body.map_err(|error| refuse("robot", format_args!("{error:?}")))
}

fn start<B: Body>(
    spawners: Spawners,
    settings: &Settings,
    cell: &'static StaticCell<Guard<B>>,
) -> Result<(), Refusal>
where
    Guard<B>: Send,
{
    let cell = cell
        .try_uninit()
        .ok_or_else(|| refuse("guard", "it was started before"))?;
    let guard = create(settings, cell)?;
    if !storage::found_at_start().is_whole() {
        guard.doubt_settings();
    }
    start_bus(
        spawners.bus,
        settings,
        od::DICTIONARY,
        None,
        received,
        bus::is_own_command,
    )?;
    Selected::start_sensors(spawners.bus, Rates::new(settings))
        .map_err(|error| refuse("sensors", error))?;
    let control = control(guard, settings.id(Setting::NodeId));
    spawners.control.spawn(startable(control)?);
    Ok(())
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

fn received(received: Received) {
    HEARD.push(received.frame);
    // The command comes as process data, or from a client that writes its objects one by one. The
    // client writes the sequence number last, which completes the command.
    if let Written::ProcessData | Written::Object(COMMAND, SEQUENCE) = received.wrote {
        OPERATOR.store(true, Ordering::Relaxed);
    }
}

#[embassy_executor::task]
async fn control(guard: &'static mut dyn Tick, node: u8) -> ! {
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    let mut frames = Vec::<Frame, MAX_RECEIVED>::new();
    let mut bytes = [0; MAX_SERIAL];
    let mut sensors = Sensor::ALL.into_iter().cycle();
    let mut step = commissioning::request::NONE;
    let mut dead_man = DeadMan::default();
    loop {
        ticker.next().await;
        frames.clear();
        while let Some(frame) = HEARD.pop() {
            let _ = frames.push(frame); // cannot fail: same capacity as the queue
        }
        // An error means that the pipe is empty.
        let count = serial::RECEIVED.try_read(&mut bytes).unwrap_or(0);
        let switches = Selected::operator_switches();
        guard.tick(&Inputs {
            now_us: Instant::now().as_micros(),
            body: newest::take(),
            operator: dead_man.command(
                switches.dead_man_released,
                OPERATOR.swap(false, Ordering::Relaxed),
                operator_command,
            ),
            emergency_stop: od::OBJECT4008.get_value() != 0 || switches.emergency_stop,
            writes_flash: storage::is_writing(),
            frames: &frames,
            serial: bytes.get(..count).unwrap_or(&[]),
        });
        crate::watchdog::control_ran(Instant::now().as_micros());
        let requested = od::OBJECT2110.get_value();
        if requested != step {
            guard.commission(requested);
            step = requested;
        }
        if step != commissioning::request::NONE {
            od::publish_commissioning(guard.commissioning());
        }
        let outputs = guard.outputs();
        storage::set_armed(outputs.state.state > READY);
        publish(outputs);
        if !outputs.frames.is_empty() {
            publish_balance(&guard.telemetry());
            if let Some(sensor) = sensors.next() {
                publish_sensor(sensor, guard.sensor(sensor));
            }
            publish_chips();
        }
        if let Some((state, position)) = &outputs.robot {
            publish_robot(state, *position, guard.estimator());
        }
        if let Some(code) = outputs.emergency {
            crate::logger::warn!("fault {:#06x} of node {}", code, outputs.state.fault_node);
            publish_mismatch(guard.scale_mismatch());
            bus::send(network::emergency(Emergency { node, code }));
        }
        outputs.frames.iter().copied().for_each(bus::send_as_master);
    }
}

/// Reads the operator's command from the objects.
fn operator_command() -> OperatorCommand {
    OperatorCommand {
        forward: od::OBJECT4000.get_forward_speed(),
        yaw_rate: od::OBJECT4000.get_yaw_rate(),
        posture: od::OBJECT4000.get_posture(),
        request: od::OBJECT4000.get_request(),
        sequence: od::OBJECT4000.get_sequence(),
    }
}

/// Writes the outputs of a tick into the objects, before the SYNC of the same tick is sent.
fn publish(outputs: &Outputs) {
    od::OBJECT1001.set_value(u8::from(outputs.state.fault_code != 0));
    od::publish_outputs(outputs);
}

/// Writes the node whose position scale differs from the guard's into the objects; zeros if there
/// is none.
fn publish_mismatch(mismatch: Option<ScaleMismatch>) {
    od::publish_mismatch(&mismatch.unwrap_or_default());
    if let Some(mismatch) = mismatch {
        crate::logger::warn!(
            "node {}: position scale {:#06x}, the guard counts in {:#06x}",
            mismatch.node,
            mismatch.found,
            mismatch.expected
        );
    }
}

/// Writes the values that change once per SYNC and are read through SDO.
fn publish_balance(balance: &Telemetry) {
    let trips = od::OBJECT4006.get_trips();
    od::publish_balance(balance);
    if let Some(trip) = balance.snapshot.filter(|_| balance.trips != trips) {
        od::publish_trip(&trip);
        crate::logger::warn!(
            "tripped: cause {:#04x}, margin {} mm",
            trip.cause.code(),
            milli(trip.margins[trip.edge as usize])
        );
    }
}

/// Writes health, rate and age of one sensor into the objects. One sensor's turn comes in each
/// SYNC period.
fn publish_sensor(sensor: Sensor, state: SensorState) {
    let place = sensor as usize;
    let health = od::OBJECT2100.array.get(place);
    if health.is_some_and(|before| before.load() != state.health) {
        let name = sensor.name();
        if let Some(Trust::Degraded(reason) | Trust::None(reason)) = Trust::from_code(state.health)
        {
            crate::logger::warn!("{}: {}", name, reason.words());
        } else {
            crate::logger::info!("{}: believed", name);
        }
    }
    // The arrays have an element for each sensor.
    od::OBJECT2100.set(place, state.health);
    od::OBJECT2101.set(place, state.rate);
    od::OBJECT2102.set(place, state.age_ms);
}

/// Writes condition and errors of the sensor chips into the objects.
fn publish_chips() {
    for chip in Chip::ALL {
        // The arrays have an element for each chip.
        od::OBJECT2112.set(chip as usize, condition::code(chip));
        od::OBJECT2113.set(chip as usize, condition::errors(chip));
    }
}

/// Writes the robot's state into the objects, once per SYNC.
fn publish_robot(state: &State, position: GuardPosition, estimator: &Estimator) {
    for (number, reading) in state.iter().enumerate() {
        let value = match number {
            // North, east and up in mm, the screw in um.
            0..=2 => to_i32(reading.value * 1e3),
            7 => to_i32(reading.value * 1e6),
            _ => Angle::from_radians(reading.value).to_bits(),
        };
        // The arrays have as many elements as the state has coordinates.
        od::OBJECT4010.set(number, value);
        od::OBJECT4011.set(number, reading.validity as u8);
        od::OBJECT4012.set(number, reading.age_ms);
    }
    od::publish_estimator(estimator);
    od::publish_position(&position);
}
