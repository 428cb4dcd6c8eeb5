//! Answers the simulator's messages, one at a time.

use super::clock;
use super::flash::Files;
use super::power_up::power_up;
use super::starvation::{self, Starved};
use super::step::advance;
use crate::roles::Role;
use embassy_executor::raw::Executor;
use heapless::String;
use tautrack::link::{FromNode, Ready, Start, ToNode, VERSION};
use tautrack::motor::bridge::PowerStage;
use tautrack::motor::model::Motor;

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
    motor: Option<Motor>,
    stage: PowerStage,
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
        }
    }

    /// Answers the message in the first `length` bytes of `buffer`: powers the node up, or advances
    /// it by one step. Writes the answer to `buffer` and returns its length.
    ///
    /// # Errors
    /// [`End`], after which the node must not be used.
    pub fn answer(&mut self, buffer: &mut [u8], length: usize) -> Result<usize, End> {
        let message = buffer.get(..length).ok_or(End::Finished)?;
        let message = postcard::from_bytes(message).map_err(|_| End::Finished)?;
        // Messages are large: they are borrowed, not moved.
        let answer = match (&message, &self.power) {
            (ToNode::Start(start), Power::Off) => FromNode::Ready(self.start(start)),
            (ToNode::Step(step), Power::On) => {
                if let Some(starved) = starvation::check(step.time_us) {
                    return Err(End::Starved(starved));
                }
                let motor = self.motor.as_mut();
                FromNode::Stepped(advance(step, self.executor, motor, &mut self.stage))
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
