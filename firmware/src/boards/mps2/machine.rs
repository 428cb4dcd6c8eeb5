//! Answers the simulator's messages, one at a time.

use super::power_up::power_up;
use super::starvation::{self, Starved};
use super::{clock, step};
use crate::boards::lockstep::AttachedMotor;
use crate::bus::RECEIVED;
use crate::refusal::{Refusal, refuse};
use crate::roles::Role;
use embassy_executor::raw::Executor;
use heapless::String;
use serde::Deserialize;
use tautrack::link::parts::{Answer, Head, Kind};
use tautrack::link::{Ready, Start, Stepped, VERSION};

/// Reason why a node ends.
pub enum End {
    /// The simulator has closed the link, or sent a message that cannot be decoded or is not
    /// expected.
    Finished,
    /// The watchdog was not fed in time; a real board would reset here.
    Starved(Starved),
}

/// The emulated board with its node.
pub struct Machine {
    board: &'static str,
    role: &'static Role,
    /// Roles that the simulator may ask for instead.
    others: &'static [&'static Role],
    executor: &'static Executor,
    power: Power,
    motor: Option<AttachedMotor>,
}

#[derive(PartialEq)]
enum Power {
    Off,
    On,
    /// The node refused its role or its settings.
    Refused,
}

impl Machine {
    /// Creates the board before its power-up, with the role `role` unless the simulator asks for
    /// one of the `others`. Must be called only once, because the executor and the tasks are
    /// statics.
    pub fn new(board: &'static str, role: &'static Role, others: &'static [&'static Role]) -> Self {
        Self {
            board,
            role,
            others,
            executor: clock::executor(),
            power: Power::Off,
            motor: None,
        }
    }

    /// Answers the message in the first `length` bytes of `buffer`: powers the node up, or advances
    /// it by one step. Writes the answer to `buffer` and returns its length. `stepped` has room for
    /// the results of a step; what it holds before does not matter.
    ///
    /// # Errors
    /// [`End`], after which the node must not be used.
    pub fn answer(
        &mut self,
        buffer: &mut [u8],
        length: usize,
        stepped: &mut Stepped,
    ) -> Result<usize, End> {
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
                stepped.shaft = step::begin(&head, motor);
                for _ in 0..message.next::<usize>()? {
                    RECEIVED.push(message.next()?);
                }
                step::end(executor, stepped);
                Answer::Stepped(stepped)
            }
            _ => return Err(End::Finished),
        };
        postcard::to_slice(&answer, buffer)
            .map(|used| used.len())
            .map_err(|_| End::Finished)
    }

    fn start(&mut self, start: &Start) -> Ready {
        let powered = self.power_up(start);
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

    fn power_up(&mut self, start: &Start) -> Result<(), Refusal> {
        if start.version != VERSION {
            return Err(refuse(
                "the simulator speaks another version of the link",
                start.version,
            ));
        }
        self.take_on(&start.role)?;
        power_up(self.role, self.executor, start, &mut self.motor)
    }

    /// Takes on the role with this name; keeps its own if the name is empty.
    fn take_on(&mut self, name: &str) -> Result<(), Refusal> {
        if name.is_empty() || name == self.role.name {
            return Ok(());
        }
        let other = self.others.iter().find(|role| role.name == name);
        self.role = other.ok_or_else(|| refuse("the program has no role", name))?;
        Ok(())
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
