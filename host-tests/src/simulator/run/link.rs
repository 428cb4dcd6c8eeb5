//! Carries messages between the runner and one node.

use super::host::Host;
#[cfg(feature = "image")]
use super::image::Image;
#[cfg(unix)]
use super::process::Process;
use crate::programs::Board;
use std::path::Path;
use std::time::Duration;
use tautrack::link::{FromNode, ToNode};

/// Connection to one running node, which ends when this is dropped.
///
/// Every error is the reason in words, without the node's name. After an error the link must not be
/// used.
pub trait Link {
    /// Sends one message; [`Link::receive`] must follow.
    ///
    /// # Errors
    /// The node has ended, or the message is too long.
    fn send(&mut self, message: ToNode) -> Result<(), String>;

    /// Waits for the answer.
    ///
    /// # Errors
    /// The node has ended, does not answer within the timeout, or its answer is no message.
    fn receive(&mut self) -> Result<FromNode, String>;

    /// Sets the maximum wall-clock time for an answer from now on.
    fn set_timeout(&mut self, timeout: Duration);
}

/// Default maximum wall-clock time for an answer of a node. It is long enough for a heavily loaded
/// computer.
#[cfg(unix)]
pub(super) const TIMEOUT: Duration = Duration::from_mins(1);

/// Error text of a program that cannot execute flash images.
pub const WITHOUT_IMAGES: &str =
    "this program was built without the feature `image`; type: cargo demo-image --image NODES";

/// Starts a node with the program at `path`, which is built for `board`.
///
/// # Errors
/// The reason in words: the program cannot be read or started, or this program was built without
/// the board.
pub(super) fn open(board: Board, path: &Path) -> Result<Box<dyn Link>, String> {
    match board {
        Board::Host => Ok(Box::new(Host::new(path))),
        #[cfg(not(unix))]
        Board::Qemu => Err("a page has no processes".to_owned()),
        #[cfg(unix)]
        Board::Qemu => Ok(Box::new(Process::start(path)?)),
        #[cfg(feature = "image")]
        Board::Image => Ok(Box::new(Image::start(path)?)),
        #[cfg(not(feature = "image"))]
        Board::Image => Err(WITHOUT_IMAGES.to_owned()),
    }
}

/// Error text of a node that did not answer in time.
#[cfg(unix)]
pub(super) fn late(timeout: Duration) -> String {
    let timeout = timeout.as_secs_f64();
    format!("no answer for {timeout} s; its program runs, but hangs or is stopped")
}
