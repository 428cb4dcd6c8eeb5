//! The messages of a step in parts, with the same encoding. A node decodes and encodes them without
//! moving a whole message, because the emulator copies a kilobyte in a thousand instructions.

use super::{Ready, Sensors, Stepped};
use serde::{Deserialize, Serialize};

/// First part of a [`ToNode`](super::ToNode): what follows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum Kind {
    /// A [`Start`](super::Start) follows.
    Start,
    /// A [`Head`], the number of frames as `usize`, and the frames follow.
    Step,
}

/// A [`Step`](super::Step) without its frames.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Head<'a> {
    /// The same as [`Step::time_us`](super::Step::time_us).
    pub time_us: u64,
    /// The same as [`Step::sensors`](super::Step::sensors).
    pub sensors: Sensors,
    /// The same as [`Step::serial`](super::Step::serial).
    pub serial: &'a [u8],
}

/// A [`FromNode`](super::FromNode) that borrows its contents.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub enum Answer<'a> {
    /// The same as [`FromNode::Ready`](super::FromNode::Ready).
    Ready(&'a Ready),
    /// The same as [`FromNode::Stepped`](super::FromNode::Stepped).
    Stepped(&'a Stepped),
}
