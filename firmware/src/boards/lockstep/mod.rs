//! What the boards without hardware share: messages in, one step of virtual time, messages out.
//!
//! `motor` models the hardware of the PWM interrupt, `clock` the timer and the executor,
//! `log_buffer` the debug probe, `starvation` the watchdog. The two boards differ only in how bytes
//! come and go ([`Pipe`]).

pub mod clock;
pub mod log_buffer;
mod motor;
mod noise;
mod starvation;

use super::Bridge;
use crate::bus::{RECEIVED, TRANSMIT};
use crate::current_loop;
use crate::roles::{Refusal, Role, refuse};
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_executor::raw::Executor;
use heapless::String;
use log_buffer::LogBuffer;
use motor::Motor;
pub use starvation::{Starved, feed_watchdog};
use tautrack::link::{
    FromNode, MAX_MESSAGE, Ready, STEP_US, Sensors, Shaft, Start, Step, Stepped, ToNode, VERSION,
};
use tautrack::settings::Settings;

/// PWM rate of the simulated bridge, Hz.
pub const PWM_HZ: u32 = 20_000;

/// Log records that wait for an answer.
pub static LOG: Mutex<RefCell<LogBuffer>> = Mutex::new(RefCell::new(LogBuffer::new()));

static INPUTS: Mutex<RefCell<Inputs>> = Mutex::new(RefCell::new(Inputs {
    sensors: Sensors {
        encoder_frozen: false,
        shaft_torque: 0.0,
        bus_voltage: 0.0,
        switches: tautrack::link::Switches {
            reference: false,
            positive_limit: false,
            negative_limit: false,
        },
        body: None,
    },
    encoder: 0,
}));

struct Inputs {
    sensors: Sensors,
    encoder: i32,
}

/// Bytes from and to the simulator.
pub trait Pipe {
    /// Fills `buffer`, waiting for as long as it takes; `false` when the simulator is gone.
    fn read(&mut self, buffer: &mut [u8]) -> bool;
    /// Writes all of `bytes`; `false` when the simulator is gone.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// Sensor values of the current step.
pub fn sensors() -> Sensors {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().sensors)
}

/// Encoder at the end of the current step.
pub fn encoder() -> i32 {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().encoder)
}

/// Why a node ends.
pub enum End {
    /// The simulator is gone, or its messages make no sense.
    Finished,
    /// The watchdog was not fed: a board would reset here.
    Starved(Starved),
}

/// Answers messages until the node ends.
pub fn run(board: &'static str, role: &'static Role, pipe: &mut impl Pipe) -> End {
    let executor = clock::executor();
    let mut link = Link {
        pipe,
        buffer: [0; MAX_MESSAGE + 2],
    };
    let Some(ToNode::Start(start)) = link.receive() else {
        return End::Finished;
    };
    let mut motor = None;
    let refusal = power_up(role, executor, &start, &mut motor)
        .err()
        .unwrap_or_default();
    let refused = !refusal.is_empty();
    let ready = Ready {
        version: VERSION,
        role: String::try_from(role.name).unwrap_or_default(),
        board: String::try_from(board).unwrap_or_default(),
        refusal,
    };
    if !link.send(&FromNode::Ready(ready)) || refused {
        return End::Finished;
    }
    let mut bridge = Bridge::Off;
    while let Some(ToNode::Step(step)) = link.receive() {
        if let Some(starved) = starvation::check(step.time_us) {
            return End::Starved(starved);
        }
        if !link.send(&FromNode::Stepped(advance(
            &step,
            executor,
            motor.as_mut(),
            &mut bridge,
        ))) {
            break;
        }
    }
    End::Finished
}

/// Makes the motor and has the role spawn its tasks, which run up to their first wait.
fn power_up(
    role: &'static Role,
    executor: &'static Executor,
    start: &Start,
    motor: &mut Option<Motor>,
) -> Result<(), Refusal> {
    if start.version != VERSION {
        return Err(refuse(format_args!(
            "the simulator speaks another version of the link"
        )));
    }
    if let Some(model) = start.motor {
        *motor = Some(
            Motor::new(model, PWM_HZ, start.seed)
                .ok_or_else(|| refuse(format_args!("the motor model cannot be simulated")))?,
        );
    }
    let mut settings = Settings::default();
    for (key, value) in &start.settings {
        settings
            .set(*key, *value)
            .map_err(|error| refuse(format_args!("{error}")))?;
    }
    (role.start)(executor.spawner(), &settings)?;
    clock::run_until_idle(executor);
    Ok(())
}

/// One step: the PWM periods that lead up to its time, then the frames, then the timers.
fn advance(
    step: &Step,
    executor: &'static Executor,
    motor: Option<&mut Motor>,
    bridge: &mut Bridge,
) -> Stepped {
    let mut shaft = Shaft::default();
    if let Some(motor) = motor {
        let (voltage, torque) = (step.sensors.bus_voltage, step.sensors.shaft_torque);
        for _ in 0..u64::from(PWM_HZ) * STEP_US / 1_000_000 {
            // As with preloaded compare registers, what the interrupt decides holds from the next period on.
            let next = current_loop::pwm_period(motor.sampled_current(), voltage);
            motor.integrate(*bridge, voltage, torque);
            *bridge = next;
        }
        shaft = motor.shaft();
        if !step.sensors.encoder_frozen {
            critical_section::with(|cs| INPUTS.borrow(cs).borrow_mut().encoder = motor.encoder());
        }
    }
    critical_section::with(|cs| INPUTS.borrow(cs).borrow_mut().sensors = step.sensors);

    clock::set_now(step.time_us);
    // What a full pipe does not take is lost, as on a line without handshake.
    let _ = crate::serial::RECEIVED.try_write(&step.serial);
    for frame in &step.frames {
        RECEIVED.push(*frame);
        clock::run_until_idle(executor);
    }
    clock::fire_timers();
    clock::run_until_idle(executor);

    let mut stepped = Stepped {
        shaft,
        frames: heapless::Vec::new(),
        log: take_log(),
    };
    while !stepped.frames.is_full() {
        let Some(frame) = TRANSMIT.pop() else { break };
        let _ = stepped.frames.push(frame); // there is room: the loop's condition
    }
    stepped
}

fn take_log<const N: usize>() -> heapless::Vec<u8, N> {
    let (bytes, dropped) = critical_section::with(|cs| {
        let mut log = LOG.borrow(cs).borrow_mut();
        (log.take(), log.take_dropped())
    });
    if dropped > 0 {
        crate::logger::warn!("{} log records were lost", dropped);
    }
    bytes
}

/// Whole messages over a [`Pipe`].
struct Link<'a, P> {
    pipe: &'a mut P,
    buffer: [u8; MAX_MESSAGE + 2],
}

impl<P: Pipe> Link<'_, P> {
    fn receive(&mut self) -> Option<ToNode> {
        let mut length = [0; 2];
        if !self.pipe.read(&mut length) {
            return None;
        }
        let message = self
            .buffer
            .get_mut(..usize::from(u16::from_le_bytes(length)))?;
        if !self.pipe.read(message) {
            return None;
        }
        postcard::from_bytes(message).ok()
    }

    /// Prefix and message leave in one write: each costs a trap into the emulator.
    fn send(&mut self, message: &FromNode) -> bool {
        let Some(body) = self.buffer.get_mut(2..) else {
            return false;
        };
        let Ok(length) = postcard::to_slice(message, body).map(|used| used.len()) else {
            return false;
        };
        self.buffer[..2].copy_from_slice(&(length as u16).to_le_bytes());
        self.pipe.write(&self.buffer[..length + 2])
    }
}
