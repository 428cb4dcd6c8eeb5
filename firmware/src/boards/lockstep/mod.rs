//! Lockstep boards, which have no hardware: a message from the simulator starts one step of virtual
//! time, and the answer carries the results.
//!
//! The two lockstep boards (`mps2`, `native`) differ only in their [`Pipe`]. `link` carries the
//! messages over it, `power_up` handles the start message and `step` the step messages. `inputs`
//! holds the sensor readings, `clock` provides timer and executor, `log_buffer` replaces the debug probe and `starvation` the watchdog.

pub mod clock;
mod inputs;
mod link;
pub mod log_buffer;
mod power_up;
mod starvation;
mod step;

pub use inputs::{encoder, sensors};
pub use link::Pipe;
pub use starvation::{Starved, feed_watchdog};

use crate::roles::Role;
use heapless::String;
use link::Link;
use power_up::power_up;
use step::advance;
use tautrack::link::{FromNode, MAX_MESSAGE, Ready, ToNode, VERSION};
use tautrack::motor::bridge::{PowerStage, Ratings};

/// The simulated power stage: 20 kHz, compare values as on a timer with 170 MHz that counts up and
/// down, and a current range that suits every motor of the simulated robots.
pub const POWER_STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    full_scale: 160.0,
};

/// Reason why a node ends.
pub enum End {
    /// The simulator has closed the pipe, or sent a message that cannot be decoded.
    Finished,
    /// The watchdog was not fed in time; a real board would reset here.
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
    let mut stage = PowerStage::Off;
    while let Some(ToNode::Step(step)) = link.receive() {
        if let Some(starved) = starvation::check(step.time_us) {
            return End::Starved(starved);
        }
        if !link.send(&FromNode::Stepped(advance(
            &step,
            executor,
            motor.as_mut(),
            &mut stage,
        ))) {
            break;
        }
    }
    End::Finished
}
