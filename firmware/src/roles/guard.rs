//! The guard: body controller, stability filter, master of the network, and the inclinometer of CiA 410.

use super::{Refusal, Role, dictionary, refuse, start_bus};
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::bus::{self, FrameQueue, Heard};
use crate::serial;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::Spawner;
use embassy_time::{Duration, Instant, Ticker};
use heapless::Vec;
use static_cell::StaticCell;
use tautrack::bus::network::{self, Emergency};
use tautrack::bus::pdo::{GuardPosition, OperatorCommand};
use tautrack::can::Frame;
use tautrack::estimate::state::{Estimator, State};
use tautrack::math::{to_i16, to_i32};
use tautrack::node::guard::{Guard, Inputs, Outputs, ScaleMismatch, Telemetry};
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

dictionary!(od, "guard.rs");

/// One role per robot: the guard that is built for it.
macro_rules! guards {
    ($($(#[doc = $doc:literal])* $role:ident: $body:ty;)*) => {$(
        $(#[doc = $doc])*
        pub static $role: Role = Role {
            name: "guard",
            start: {
                static GUARD: StaticCell<Guard<$body>> = StaticCell::new();
                |spawner, settings| start(spawner, settings, &GUARD)
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

/// A guard whatever its robot.
trait Tick {
    fn tick(&mut self, inputs: &Inputs<'_>);
    fn outputs(&self) -> &Outputs;
    fn telemetry(&self) -> Telemetry;
    fn estimator(&self) -> &Estimator;
    fn scale_mismatch(&self) -> Option<ScaleMismatch>;
}

impl<B: Body> Tick for Guard<B> {
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
}

/// The operator's command, and the sub-index of its sequence number.
const COMMAND: u16 = 0x4000;
const SEQUENCE: u8 = 5;

/// Most frames between two ticks: a 1 Mbit/s bus carries fewer in 1 ms.
const MAX_HEARD: usize = 32;

/// Most bytes of the serial line that one tick takes: 115200 baud bring 12.
const MAX_SERIAL: usize = 64;

/// Frames for the next tick.
static HEARD: FrameQueue<MAX_HEARD> = FrameQueue::new();
/// The operator's objects were written since the tick before.
static OPERATOR: AtomicBool = AtomicBool::new(false);

fn start<B: Body>(
    spawner: Spawner,
    settings: &Settings,
    cell: &'static StaticCell<Guard<B>>,
) -> Result<(), Refusal> {
    let guard = Guard::new(settings).map_err(|error| refuse(format_args!("robot: {error:?}")))?;
    let guard = cell
        .try_init(guard)
        .ok_or_else(|| refuse(format_args!("the guard was started before")))?;
    start_bus(spawner, settings, od::DICTIONARY, None, heard)?;
    super::spawn(spawner, control(guard, settings.id(Setting::NodeId)))
}

fn heard(heard: Heard) {
    HEARD.push(heard.frame);
    // By process data, or by a client that writes the command's objects one by one: the sequence
    // number comes last and makes the command count.
    let complete = match heard.sdo_index {
        Some(index) => index == COMMAND && heard.frame.data().get(3) == Some(&SEQUENCE),
        None => true,
    };
    if heard.wrote && complete {
        OPERATOR.store(true, Ordering::Relaxed);
    }
}

#[embassy_executor::task]
async fn control(guard: &'static mut dyn Tick, node: u8) -> ! {
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    let mut frames = Vec::<Frame, MAX_HEARD>::new();
    let mut bytes = [0; MAX_SERIAL];
    loop {
        ticker.next().await;
        frames.clear();
        while let Some(frame) = HEARD.pop() {
            let _ = frames.push(frame); // as many as the queue holds
        }
        // An error is an empty pipe.
        let count = serial::RECEIVED.try_read(&mut bytes).unwrap_or(0);
        guard.tick(&Inputs {
            now_us: Instant::now().as_micros(),
            body: Selected::body(),
            operator: OPERATOR
                .swap(false, Ordering::Relaxed)
                .then(operator_command),
            emergency_stop: od::OBJECT4008.get_value() != 0,
            frames: &frames,
            serial: bytes.get(..count).unwrap_or(&[]),
        });
        crate::watchdog::control_ran(Instant::now().as_micros());
        let outputs = guard.outputs();
        publish(outputs);
        if !outputs.frames.is_empty() {
            publish_balance(&guard.telemetry());
        }
        if let Some((state, position)) = &outputs.robot {
            publish_robot(state, *position, guard.estimator());
        }
        if let Some(code) = outputs.emergency {
            crate::logger::warn!("fault {:#06x} of node {}", code, outputs.state.fault_node);
            publish_mismatch(guard.scale_mismatch());
            bus::send(network::emergency(Emergency { node, code }));
        }
        outputs.frames.iter().copied().for_each(bus::send);
    }
}

/// The command as the objects hold it.
fn operator_command() -> OperatorCommand {
    OperatorCommand {
        forward: od::OBJECT4000.get_forward_speed(),
        yaw_rate: od::OBJECT4000.get_yaw_rate(),
        posture: od::OBJECT4000.get_posture(),
        request: od::OBJECT4000.get_request(),
        sequence: od::OBJECT4000.get_sequence(),
    }
}

/// What the tick tells, as objects. The SYNC that the same tick sends finds them there.
fn publish(outputs: &Outputs) {
    od::OBJECT1001.set_value(u8::from(outputs.state.fault_code != 0));
    od::OBJECT4001.set_state(outputs.state.state);
    od::OBJECT4001.set_verdict(outputs.state.verdict);
    od::OBJECT4001.set_scale(outputs.state.scale);
    od::OBJECT4001.set_fault_node(outputs.state.fault_node);
    od::OBJECT4001.set_fault_code(outputs.state.fault_code);
    od::OBJECT4001.set_heading(outputs.state.heading);
    od::OBJECT4002.set_value(outputs.motion.odometry);
    od::OBJECT6010.set_value(outputs.motion.pitch);
    od::OBJECT6020.set_value(outputs.motion.roll);
    od::OBJECT4003.set_back(outputs.margins.back);
    od::OBJECT4003.set_front(outputs.margins.front);
    od::OBJECT4003.set_left(outputs.margins.left);
    od::OBJECT4003.set_right(outputs.margins.right);
    od::OBJECT4004.set_asked_speed(outputs.passed.asked_speed);
    od::OBJECT4004.set_passed_speed(outputs.passed.passed_speed);
    od::OBJECT4004.set_asked_posture(outputs.passed.asked_posture);
    od::OBJECT4004.set_passed_posture(outputs.passed.passed_posture);
    od::OBJECT4005.set_refused(outputs.refused);
    od::OBJECT4005.set_scaled(outputs.scaled);
    od::OBJECT4009.set_value(outputs.faulty_drives);
}

/// The drive whose position scale is not the guard's, with both scales.
fn publish_mismatch(mismatch: Option<ScaleMismatch>) {
    let (node, expected, found) = mismatch.map_or((0, 0, 0), |mismatch| {
        (mismatch.node, mismatch.expected, mismatch.found)
    });
    od::OBJECT400A.set_node(node);
    od::OBJECT400A.set_expected(expected);
    od::OBJECT400A.set_found(found);
    if node != 0 {
        crate::logger::warn!(
            "node {}: position scale {:#06x}, the guard counts in {:#06x}",
            node,
            found,
            expected
        );
    }
}

/// What changes once per SYNC and is read through SDO.
fn publish_balance(balance: &Telemetry) {
    let milli = |value: f32| to_i16(value * 1e3);
    let centi = |value: f32| to_i16(value * 1e2);
    let limit = |value: f32| (value * 1e3) as u16; // saturates
    od::OBJECT4006.set_band(balance.band as u8);
    od::OBJECT4006.set_trust(balance.trust.code());
    od::OBJECT4006.set_with_force(u8::from(balance.with_force));
    od::OBJECT4006.set_tripped(u8::from(balance.tripped));
    od::OBJECT4006.set_refusal(
        balance
            .refusal
            .map_or(0, tautrack::stability::parameters::Refusal::code),
    );
    od::OBJECT4006.set_forward_limit(limit(balance.limits.forward));
    od::OBJECT4006.set_backward_limit(limit(balance.limits.backward));
    od::OBJECT4006.set_left_limit(limit(balance.limits.left));
    od::OBJECT4006.set_right_limit(limit(balance.limits.right));
    let Some(kept) = balance
        .snapshot
        .filter(|_| balance.trips != od::OBJECT4006.get_trips())
    else {
        return;
    };
    od::OBJECT4006.set_trips(balance.trips);
    let [back, front, left, right] = kept.margins.map(milli);
    od::OBJECT4007.set_cause(kept.cause.code());
    od::OBJECT4007.set_edge(kept.edge as u8);
    od::OBJECT4007.set_time((kept.time_us / 1_000) as u32);
    od::OBJECT4007.set_back(back);
    od::OBJECT4007.set_front(front);
    od::OBJECT4007.set_left(left);
    od::OBJECT4007.set_right(right);
    od::OBJECT4007.set_asked_speed(milli(kept.asked.forward));
    od::OBJECT4007.set_asked_yaw_rate(milli(kept.asked.yaw_rate));
    od::OBJECT4007.set_passed_speed(milli(kept.speed));
    let [pitch, roll] = kept
        .sensors
        .inclination
        .map(|angle| centi(angle.to_degrees()));
    od::OBJECT4007.set_pitch(pitch);
    od::OBJECT4007.set_roll(roll);
    let [x, y, z] = kept.sensors.specific_force.map(centi);
    od::OBJECT4007.set_force_x(x);
    od::OBJECT4007.set_force_y(y);
    od::OBJECT4007.set_force_z(z);
    crate::logger::warn!(
        "tripped: cause {:#04x}, margin {} mm",
        kept.cause.code(),
        milli(kept.margins[kept.edge as usize])
    );
}

/// The robot's state, once per SYNC.
fn publish_robot(state: &State, position: GuardPosition, estimator: &Estimator) {
    for (number, reading) in state.iter().enumerate() {
        let value = match number {
            // North, east, up in mm, the screw in um.
            0..=2 => to_i32(reading.value * 1e3),
            7 => to_i32(reading.value * 1e6),
            _ => Angle::from_radians(reading.value).to_bits(),
        };
        // The arrays have as many elements as the state has coordinates.
        let _ = od::OBJECT4010.set(number, value);
        let _ = od::OBJECT4011.set(number, reading.validity as u8);
        let _ = od::OBJECT4012.set(number, reading.age_ms);
    }
    let (place, altitude_mm) = estimator.position().origin().unwrap_or_default();
    od::OBJECT4013.set_latitude(place.latitude);
    od::OBJECT4013.set_longitude(place.longitude);
    od::OBJECT4013.set_altitude(altitude_mm.unwrap_or(0));
    let [believed, doubted] = estimator.position().counts();
    od::OBJECT4013.set_fixes(believed);
    od::OBJECT4013.set_doubted_fixes(doubted);
    let sentences = estimator.sentences();
    od::OBJECT4013.set_sentences(sentences.taken);
    od::OBJECT4013.set_refused_sentences(sentences.all_refused());
    od::OBJECT4014.set_north(position.north);
    od::OBJECT4014.set_east(position.east);
    od::OBJECT4014.set_up(position.up);
    od::OBJECT4014.set_validity(position.validity);
    od::OBJECT4014.set_age(position.age);
}
