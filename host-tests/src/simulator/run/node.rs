//! Communicates with one node, and decodes its log.

use super::link::{self, Link};
use super::node_log::LogReader;
use crate::programs::Board;
use crate::robots::NodeName;
use std::fmt;
use std::path::Path;
use std::time::Duration;
use tautrack::link::{FromNode, Ready, Start, Step, Stepped, ToNode, VERSION};

/// Error of a node.
#[derive(Debug)]
pub struct NodeError {
    name: NodeName,
    what: String,
}

impl fmt::Display for NodeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "node {}: {}", self.name, self.what)
    }
}

impl std::error::Error for NodeError {}

/// Running node; it ends when this is dropped.
pub struct Node {
    name: NodeName,
    link: Box<dyn Link>,
    log: LogReader,
}

impl Node {
    /// Starts the program at `path` and sends it `start`.
    ///
    /// # Errors
    /// If the program cannot be started, has another version of the link, or refuses its role or
    /// settings; the error then contains the node's own text.
    pub fn start(
        name: NodeName,
        board: Board,
        path: &Path,
        start: Start,
    ) -> Result<(Self, Ready), NodeError> {
        let fail = |what: String| NodeError { name, what };
        let log = LogReader::new(board, path)
            .map_err(|error| fail(format!("the log of {} is lost: {error}", path.display())))?;
        let mut node = Self {
            name,
            link: link::open(board, path).map_err(fail)?,
            log,
        };
        node.write(ToNode::Start(start))?;
        match node.read()? {
            FromNode::Ready(ready) if ready.version != VERSION => Err(node.error(format!(
                "{} speaks version {} of the link, this runner version {VERSION}; build both from the same sources",
                path.display(),
                ready.version
            ))),
            FromNode::Ready(ready) if !ready.refusal.is_empty() => {
                Err(node.error(format!("does not start: {}", ready.refusal)))
            }
            FromNode::Ready(ready) => Ok((node, ready)),
            FromNode::Stepped(_) => Err(node.error("answers a step before its first")),
        }
    }

    /// Name of the node in the robot.
    pub fn name(&self) -> NodeName {
        self.name
    }

    /// Sets the maximum wall-clock time for an answer from now on.
    pub fn set_timeout(&mut self, timeout: Duration) {
        self.link.set_timeout(timeout);
    }

    /// Returns the log lines in the node's answer; each line is a whole record.
    pub fn log_lines(&mut self, stepped: &Stepped) -> Vec<String> {
        self.log.lines(&stepped.log)
    }

    /// Sends one step; [`Node::receive`] must follow.
    ///
    /// # Errors
    /// If the message cannot be sent. A process that has ended is an error of [`Node::receive`].
    pub fn send(&mut self, step: Step) -> Result<(), NodeError> {
        self.write(ToNode::Step(step))
    }

    /// Waits for the answer to a step.
    ///
    /// # Errors
    /// If the node has ended, does not answer within the timeout, or sends another message.
    pub fn receive(&mut self) -> Result<Stepped, NodeError> {
        match self.read()? {
            FromNode::Stepped(stepped) => Ok(stepped),
            FromNode::Ready(_) => Err(self.error("started anew in the middle of a run")),
        }
    }

    fn write(&mut self, message: ToNode) -> Result<(), NodeError> {
        let sent = self.link.send(message);
        sent.map_err(|what| self.error(what))
    }

    fn read(&mut self) -> Result<FromNode, NodeError> {
        let received = self.link.receive();
        received.map_err(|what| self.error(what))
    }

    fn error(&self, what: impl Into<String>) -> NodeError {
        NodeError {
            name: self.name,
            what: what.into(),
        }
    }
}
