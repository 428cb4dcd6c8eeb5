//! A node with its board as a value, in the process of the simulator. It has the same control code,
//! drivers and settings as a node that is flashed; what carries frames and readings is a call.
//!
//! `clock` is the time of the node that runs, `log` its log records, `motor` the board of a drive,
//! `body` the sensor chips and the serial line of a guard, and `roles` creates the node of each
//! role.

mod body;
mod clock;
mod files;
mod log;
mod motor;
mod roles;

pub use roles::*;

use super::lockstep::{AttachedMotor, Flash, LogBuffer};
use crate::refusal::{Refusal, refuse};
use crate::storage::{self, Storage};
use body::Body;
use clock::Clock;
use motor::Motor;
use roles::Device;
use std::boxed::Box;
use std::collections::VecDeque;
use tautrack::bus::lss::{self, Action, Slave};
use tautrack::can::Frame;
use tautrack::link::{Start, Step, Stepped};
use tautrack::roles::settings::Found;
use tautrack::settings::Settings;
use tautrack::store::State;

/// Name of the board.
pub const NAME: &str = "host";

/// Maximum number of frames that wait for the bus.
const WAITING: usize = 64;

/// Frames that wait for the bus, oldest first. Those that do not fit are lost.
#[derive(Default)]
struct Outbox(VecDeque<Frame>);

impl Outbox {
    fn push(&mut self, frame: Frame) {
        if self.0.len() < WAITING {
            self.0.push_back(frame);
        }
    }
}

/// What a node is connected to.
struct Board {
    motor: Motor,
    body: Body,
    outbox: Outbox,
    serial_number: u32,
}

/// A powered node.
pub struct Node {
    role: &'static Role,
    board: Board,
    life: Life,
    clock: Clock,
    log: Box<LogBuffer>,
}

/// What a node does.
enum Life {
    /// It waits for a node id, which it saves in this flash.
    Blank(Slave, Box<Flash>, Found),
    /// It runs.
    Running(Box<dyn Device>),
    /// It got a node id, and refused to start with it.
    Refused,
}

impl Node {
    /// Powers a node up.
    ///
    /// # Errors
    /// [`Refusal`]: the motor model or a setting is not valid.
    pub fn start(role: &'static Role, start: &Start) -> Result<Self, Refusal> {
        log::install();
        let mut motor = Motor::default();
        if let Some(model) = start.motor {
            let attached = AttachedMotor::new(model, start.seed);
            motor.attach(
                attached.ok_or_else(|| {
                    refuse("the motor model cannot be simulated", "see its bounds")
                })?,
            );
        }
        let mut node = Self {
            role,
            board: Board {
                motor,
                body: Body::new(start.seed),
                outbox: Outbox::default(),
                // The simulator gives every node another seed.
                serial_number: start.seed as u32,
            },
            life: Life::Refused,
            clock: Clock::default(),
            log: Box::new(LogBuffer::new()),
        };
        node.during(0, |node| node.power_up(start))?;
        Ok(node)
    }

    fn power_up(&mut self, start: &Start) -> Result<(), Refusal> {
        let mut flash = Flash::blank();
        flash
            .insert(&start.flash, files::FILES)
            .map_err(|()| refuse("flash", "its file cannot be read or has another length"))?;
        let (mut settings, found) = storage::load(&mut flash);
        let fills = found.state == State::Blank as u8 && !start.settings.is_empty();
        if fills {
            for (key, value) in &start.settings {
                settings
                    .set(*key, *value)
                    .map_err(|error| refuse("setting", error))?;
            }
            // Settings with which the node does not start must not stay in flash.
            (self.role.check)(&settings)?;
            storage::create(&mut flash, &settings).map_err(|error| refuse("flash", error))?;
        }
        self.board.motor.choose_sensor(&settings);
        if !found.has_settings() && !fills {
            let [vendor, product, revision] = tautrack::roles::identity(self.role.table);
            let slave = Slave::new([vendor, product, revision, self.board.serial_number]);
            self.life = Life::Blank(slave, Box::new(flash), found);
            return Ok(());
        }
        self.run(&settings, found, flash, 0)
    }

    /// Starts the node with these settings.
    fn run(
        &mut self,
        settings: &Settings,
        found: Found,
        flash: Flash,
        now_us: u64,
    ) -> Result<(), Refusal> {
        let storage = Storage::new(settings, found, self.role.check, flash);
        let mut device = (self.role.create)(settings, storage, &mut self.board)?;
        device.boot(now_us, &mut self.board.outbox);
        self.life = Life::Running(device);
        Ok(())
    }

    /// Advances the node by one step, and writes the results to `stepped`. A node that is to
    /// restart must not be used any more.
    pub fn step(&mut self, step: &Step, stepped: &mut Stepped) {
        let Step {
            time_us,
            sensors,
            serial,
            frames,
        } = step;
        self.during(*time_us, |node| {
            stepped.restart = false;
            stepped.shaft = node.board.motor.step(sensors);
            node.board.body.measure(sensors.body.as_ref(), serial);
            for frame in frames {
                node.receive(frame, *time_us);
            }
            // A node that got its id in this step begins with the next one.
            node.board.body.poll();
            if let Life::Running(device) = &mut node.life {
                stepped.restart = device.tick(*time_us, &mut node.board);
            }
        });
        stepped.log.clear();
        self.log.take(&mut stepped.log);
        let lost = self.log.take_dropped();
        if lost > 0 {
            log::warn_of_lost(&mut self.log, lost);
        }
        stepped.frames.clear();
        while !stepped.frames.is_full() {
            let Some(frame) = self.board.outbox.0.pop_front() else {
                break;
            };
            let _ = stepped.frames.push(frame); // cannot fail: see the loop's condition
        }
    }

    /// Calls `act` with the clock at `now_us` and with the node's log.
    fn during<R>(&mut self, now_us: u64, act: impl FnOnce(&mut Self) -> R) -> R {
        self.clock.now_us = now_us;
        let around = clock::exchange(self.clock);
        log::exchange(&mut self.log);
        let result = act(self);
        log::exchange(&mut self.log);
        self.clock = clock::exchange(around);
        result
    }

    fn receive(&mut self, frame: &Frame, now_us: u64) {
        let action = match &mut self.life {
            Life::Running(device) => {
                device.receive(frame, now_us, &mut self.board.outbox);
                None
            }
            Life::Blank(slave, ..) => slave.receive(frame),
            Life::Refused => None,
        };
        match action {
            None => {}
            Some(Action::Answer(answer)) => self.board.outbox.push(answer),
            Some(Action::Store(id)) => self.save(id),
            Some(Action::Start(id)) => {
                let life = std::mem::replace(&mut self.life, Life::Refused);
                if let Life::Blank(_, flash, found) = life
                    && let Err(refusal) = self.run(&storage::with_id(id), found, *flash, now_us)
                {
                    crate::logger::error!("the node cannot start: {}", refusal);
                }
            }
        }
    }

    fn save(&mut self, id: u8) {
        if let Life::Blank(_, flash, _) = &mut self.life {
            let saved = storage::create(&mut **flash, &storage::with_id(id)).is_ok();
            if let Some(answer) = lss::stored(saved) {
                self.board.outbox.push(answer);
            }
        }
    }
}
