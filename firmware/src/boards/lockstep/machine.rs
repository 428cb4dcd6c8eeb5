//! Answers the simulator's messages, one at a time.

use super::attached::AttachedMotor;
use super::flash::Files;
use super::power_up::power_up;
use super::starvation::{self, Starved};
use super::{clock, step};
use crate::bus::RECEIVED;
use crate::roles::Role;
use embassy_executor::raw::Executor;
use heapless::String;
use serde::Deserialize;
use tautrack::link::parts::{Answer, Head, Kind};
use tautrack::link::{Ready, Start, Stepped, VERSION};
use tautrack::motor::bridge::PowerStage;

/// Reason why a node ends.
pub enum End {
    /// The simulator has closed the link, or sent a message that cannot be decoded or is not
    /// expected.
    Finished,
    /// The watchdog was not fed in time; a real board would reset here.
    Starved(Starved),
}

/// A lockstep board with its node.
pub struct Machine {
    board: &'static str,
    role: &'static Role,
    files: Option<Files>,
    executor: &'static Executor,
    power: Power,
    motor: Option<AttachedMotor>,
    stage: PowerStage,
    /// Results of the newest step.
    stepped: Stepped,
}

#[derive(PartialEq)]
enum Power {
    Off,
    On,
    /// The node refused its settings.
    Refused,
}

impl Machine {
    /// Creates the board before its power-up. Must be called only once, because the executor, the
    /// tasks and the object dictionary are statics.
    pub fn new(board: &'static str, role: &'static Role, files: Option<Files>) -> Self {
        Self {
            board,
            role,
            files,
            executor: clock::executor(),
            power: Power::Off,
            motor: None,
            stage: PowerStage::Off,
            stepped: Stepped::default(),
        }
    }

    /// Answers the message in the first `length` bytes of `buffer`: powers the node up, or advances
    /// it by one step. Writes the answer to `buffer` and returns its length.
    ///
    /// # Errors
    /// [`End`], after which the node must not be used.
    pub fn answer(&mut self, buffer: &mut [u8], length: usize) -> Result<usize, End> {
        let mut message = Message(buffer.get(..length).ok_or(End::Finished)?);
        let ready;
        let answer = match (message.next()?, &self.power) {
            (Kind::Start, Power::Off) => {
                ready = self.start(&message.next()?);
                Answer::Ready(&ready)
            }
            (Kind::Step, Power::On) => {
                let head: Head = message.next()?;
                if let Some(starved) = starvation::check(head.time_us) {
                    return Err(End::Starved(starved));
                }
                let (motor, executor) = (self.motor.as_mut(), self.executor);
                self.stepped.shaft = step::begin(&head, motor, &mut self.stage);
                for _ in 0..message.next::<usize>()? {
                    RECEIVED.push(message.next()?);
                }
                step::end(executor, &mut self.stepped);
                Answer::Stepped(&self.stepped)
            }
            _ => return Err(End::Finished),
        };
        postcard::to_slice(&answer, buffer)
            .map(|used| used.len())
            .map_err(|_| End::Finished)
    }

    fn start(&mut self, start: &Start) -> Ready {
        let powered = power_up(self.role, self.executor, self.files, start, &mut self.motor);
        self.power = if powered.is_ok() {
            Power::On
        } else {
            Power::Refused
        };
        Ready {
            version: VERSION,
            role: String::try_from(self.role.name).unwrap_or_default(),
            board: String::try_from(self.board).unwrap_or_default(),
            refusal: powered.err().unwrap_or_default(),
        }
    }
}

/// Bytes of a message that are not decoded yet.
struct Message<'a>(&'a [u8]);

impl<'a> Message<'a> {
    fn next<T: Deserialize<'a>>(&mut self) -> Result<T, End> {
        let (value, rest) = postcard::take_from_bytes(self.0).map_err(|_| End::Finished)?;
        self.0 = rest;
        Ok(value)
    }
}
