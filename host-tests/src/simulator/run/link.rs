//! Carries encoded messages between the runner and one node.

#[cfg(feature = "image")]
use super::image::Image;
use super::process::{Machines, Seat};
#[cfg(feature = "wasm")]
use super::wasm::Instance;
use crate::programs::Board;
use std::path::Path;
use std::time::Duration;

/// Connection to one running node, which ends when this is dropped.
///
/// Every error is the reason in words, without the node's name. After an error the link must not be
/// used.
pub trait Link {
    /// Sends one message; [`Link::receive`] must follow.
    ///
    /// # Errors
    /// The node has ended, or the message is too long.
    fn send(&mut self, message: &[u8]) -> Result<(), String>;

    /// Waits for the answer and writes it to `answer`, whose contents it replaces.
    ///
    /// # Errors
    /// The node has ended, does not answer within the timeout, or its answer is too long.
    fn receive(&mut self, answer: &mut Vec<u8>) -> Result<(), String>;

    /// Sets the maximum wall-clock time for an answer from now on.
    fn set_timeout(&mut self, timeout: Duration);
}

/// Default maximum wall-clock time for an answer of a node. It is long enough for a heavily loaded
/// computer.
pub(super) const TIMEOUT: Duration = Duration::from_mins(1);

/// Error text of a program that cannot execute flash images.
pub const WITHOUT_IMAGES: &str =
    "this program was built without the feature `image`; type: cargo demo-image --image NODES";

/// Starts a node with the program at `path`, which is built for `board`. It may share one of the
/// `machines`.
///
/// # Errors
/// The reason in words: the program cannot be read or started, or this program was built without
/// the board.
pub(super) fn open(
    board: Board,
    path: &Path,
    machines: &mut Machines,
) -> Result<Box<dyn Link>, String> {
    match board {
        Board::Qemu => Ok(Box::new(machines.start(path)?)),
        Board::Native => Ok(Box::new(Seat::alone(board, path)?)),
        #[cfg(feature = "wasm")]
        Board::Wasm => Ok(Box::new(Instance::start(path)?)),
        #[cfg(not(feature = "wasm"))]
        Board::Wasm => Err(
            "this program was built without the feature `wasm`; type: cargo demo-wasm".to_owned(),
        ),
        #[cfg(feature = "image")]
        Board::Image => Ok(Box::new(Image::start(path)?)),
        #[cfg(not(feature = "image"))]
        Board::Image => Err(WITHOUT_IMAGES.to_owned()),
    }
}

/// Error text of a node that did not answer in time.
pub(super) fn late(timeout: Duration) -> String {
    let timeout = timeout.as_secs_f64();
    format!("no answer for {timeout} s; its program runs, but hangs or is stopped")
}
