//! One node program as a process: its start, its messages, its end.

use super::node_log::LogReader;
use crate::nodes::Board;
use crate::scenario::NodeName;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serde::Serialize;
use std::fmt::{self, Display};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use tautrack::link::{FromNode, MAX_MESSAGE, Ready, Start, Step, Stepped, ToNode, VERSION};

/// Longest time of the wall clock that a node may take for an answer, s: a heavily loaded machine, not a slow node.
const PATIENCE_S: i64 = 60;

/// What went wrong with a node.
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

/// A running node program; dropping it ends the process.
pub struct Node {
    name: NodeName,
    process: Child,
    input: ChildStdin,
    output: ChildStdout,
    log: LogReader,
    buffer: Vec<u8>,
}

impl Node {
    /// Starts the program at `path` and hands it `start`.
    ///
    /// # Errors
    /// When the program cannot be started, speaks another version, or refuses its settings; the text is the node's own.
    pub fn start(
        name: NodeName,
        board: Board,
        path: &Path,
        start: Start,
    ) -> Result<(Self, Ready), NodeError> {
        let fail = |what: String| NodeError { name, what };
        let log = LogReader::new(board, path)
            .map_err(|error| fail(format!("the log of {} is lost: {error}", path.display())))?;
        let mut process = command(board, path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| fail(format!("{} does not start: {error}", path.display())))?;
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (input, output) = pipes.ok_or_else(|| fail("has no pipes".into()))?;
        let mut node = Self {
            name,
            process,
            input,
            output,
            log,
            buffer: Vec::with_capacity(MAX_MESSAGE + 2),
        };
        node.write(&ToNode::Start(start))?;
        match node.read()? {
            FromNode::Ready(ready) if ready.version != VERSION => Err(node.error(format!(
                "{} speaks version {} of the link, this runner version {VERSION}; build both from the same sources",
                path.display(),
                ready.version
            ))),
            FromNode::Ready(ready) if !ready.refusal.is_empty() => {
                Err(node.error(format!("refuses its settings: {}", ready.refusal)))
            }
            FromNode::Ready(ready) => Ok((node, ready)),
            FromNode::Stepped(_) => Err(node.error("answers a step before its first")),
        }
    }

    /// Name in the robot.
    pub fn name(&self) -> NodeName {
        self.name
    }

    /// What the node logged, from the log bytes of its answers; each line is a whole record.
    pub fn log_lines(&mut self, stepped: &Stepped) -> Vec<String> {
        self.log.lines(&stepped.log)
    }

    /// Hands over one step; [`Node::receive`] must follow.
    ///
    /// # Errors
    /// When the node is gone.
    pub fn send(&mut self, step: Step) -> Result<(), NodeError> {
        self.write(&ToNode::Step(step))
    }

    /// Waits for the answer to a step.
    ///
    /// # Errors
    /// When the node is gone, stays silent for a minute of the wall clock, or answers something else.
    pub fn receive(&mut self) -> Result<Stepped, NodeError> {
        match self.read()? {
            FromNode::Stepped(stepped) => Ok(stepped),
            FromNode::Ready(_) => Err(self.error("started anew in the middle of a run")),
        }
    }

    fn write(&mut self, message: &impl Serialize) -> Result<(), NodeError> {
        self.buffer.clear();
        self.buffer.extend([0, 0]);
        let buffer = std::mem::take(&mut self.buffer);
        let mut bytes = postcard::to_extend(message, buffer).map_err(|error| self.error(error))?;
        let length = (bytes.len() - 2) as u16;
        bytes[..2].copy_from_slice(&length.to_le_bytes());
        let written = self.input.write_all(&bytes);
        self.buffer = bytes;
        written.map_err(|error| self.gone(&error))
    }

    /// Takes the one answer that is due, with as few calls to the system as it comes in pieces.
    fn read(&mut self) -> Result<FromNode, NodeError> {
        let mut bytes = std::mem::take(&mut self.buffer);
        bytes.resize(MAX_MESSAGE + 2, 0);
        let filled = self.fill(&mut bytes).map_err(|error| self.gone(&error));
        let message = filled.and_then(|length| {
            postcard::from_bytes(&bytes[2..2 + length])
                .map_err(|error| self.error(format!("answers nonsense: {error}")))
        });
        self.buffer = bytes;
        message
    }

    /// Reads until a whole message stands in `bytes`, waiting for as long as [`PATIENCE_S`] for each piece; its length
    /// behind the prefix.
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let mut have = 0;
        loop {
            let length = usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
            if have >= 2 && have >= 2 + length {
                return Ok(length);
            }
            let mut ready = [PollFd::new(&self.output, PollFlags::IN)];
            let patience = Timespec {
                tv_sec: PATIENCE_S,
                tv_nsec: 0,
            };
            if poll(&mut ready, Some(&patience))? == 0 {
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    format!("no answer for {PATIENCE_S} s"),
                ));
            }
            let room = bytes.get_mut(have..).filter(|room| !room.is_empty());
            let room =
                room.ok_or_else(|| io::Error::other("its message is longer than any can be"))?;
            match self.output.read(room)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                count => have += count,
            }
        }
    }

    fn error(&self, what: impl Display) -> NodeError {
        NodeError {
            name: self.name,
            what: what.to_string(),
        }
    }

    fn gone(&mut self, error: &io::Error) -> NodeError {
        // A process that has just closed its pipes needs a moment until its exit status is known.
        std::thread::sleep(std::time::Duration::from_millis(50));
        match self.process.try_wait() {
            Ok(Some(status)) => self.error(format!(
                "its program ended ({status}); its last words are above"
            )),
            _ => self.error(error),
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        // It may be gone already; either way nothing is left to do about it.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn command(board: Board, path: &Path) -> Command {
    match board {
        Board::Native => Command::new(path),
        Board::Qemu => {
            let mut command = Command::new(crate::setup::QEMU);
            command
                .args([
                    "-M",
                    "mps2-an386",
                    "-nographic",
                    "-monitor",
                    "none",
                    "-serial",
                    "none",
                ])
                .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
                .arg(path);
            command
        }
    }
}
