//! Runs one node program as a process: starts it, exchanges messages with it, ends it.

use super::node_log::LogReader;
use crate::programs::Board;
use crate::robots::NodeName;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use serde::Serialize;
use std::fmt::{self, Display};
use std::io::{self, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::{self, JoinHandle, sleep};
use std::time::{Duration, Instant};
use tautrack::link::{FromNode, MAX_MESSAGE, Ready, Start, Step, Stepped, ToNode, VERSION};

/// Default maximum wall-clock time for an answer of a node. It is long enough for a heavily loaded
/// computer.
const TIMEOUT: Duration = Duration::from_secs(60);
/// Time within which a process ends after it closed its pipes and its last output is read.
const ENDING: Duration = Duration::from_secs(1);

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

/// Running node program; the process ends when this is dropped.
pub struct Node {
    name: NodeName,
    process: Child,
    input: ChildStdin,
    output: ChildStdout,
    /// Thread that copies the standard error of the process to that of this program. It returns
    /// whether there was any output.
    words: Option<JoinHandle<bool>>,
    log: LogReader,
    buffer: Vec<u8>,
    timeout: Duration,
}

impl Node {
    /// Starts the program at `path` and sends it `start`.
    ///
    /// # Errors
    /// If the program cannot be started, has another version of the link, or refuses its settings;
    /// the error then contains the node's own text.
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
            .stderr(Stdio::piped())
            // Ctrl-C in a terminal ends only this program, which then ends its nodes.
            .process_group(0)
            .spawn()
            .map_err(|error| fail(format!("{} does not start: {error}", path.display())))?;
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (input, output) = pipes.ok_or_else(|| fail("has no pipes".into()))?;
        let words = process
            .stderr
            .take()
            .map(|from| thread::spawn(|| copy(from)));
        let mut node = Self {
            name,
            process,
            input,
            output,
            words,
            log,
            buffer: Vec::with_capacity(MAX_MESSAGE + 2),
            timeout: TIMEOUT,
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

    /// Name of the node in the robot.
    pub fn name(&self) -> NodeName {
        self.name
    }

    /// Sets the maximum wall-clock time for an answer from now on.
    pub fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }

    /// Returns the log lines in the node's answer; each line is a whole record.
    pub fn log_lines(&mut self, stepped: &Stepped) -> Vec<String> {
        self.log.lines(&stepped.log)
    }

    /// Sends one step; [`Node::receive`] must follow.
    ///
    /// # Errors
    /// If the process has ended.
    pub fn send(&mut self, step: Step) -> Result<(), NodeError> {
        self.write(&ToNode::Step(step))
    }

    /// Waits for the answer to a step.
    ///
    /// # Errors
    /// If the process has ended, does not answer within the timeout, or sends another message.
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

    /// Reads one answer, with as few system calls as its pieces allow.
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

    /// Reads until `bytes` holds a whole message. Returns its length without the prefix.
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let deadline = Instant::now() + self.timeout;
        let mut have = 0;
        loop {
            let length = usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
            if have >= 2 && have >= 2 + length {
                return Ok(length);
            }
            self.wait_for_bytes(deadline)?;
            let room = bytes.get_mut(have..).filter(|room| !room.is_empty());
            let room =
                room.ok_or_else(|| io::Error::other("its message is longer than any can be"))?;
            match self.output.read(room)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                count => have += count,
            }
        }
    }

    fn wait_for_bytes(&self, deadline: Instant) -> io::Result<()> {
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let left = Timespec::try_from(left).map_err(io::Error::other)?;
            let mut ready = [PollFd::new(&self.output, PollFlags::IN)];
            match poll(&mut ready, Some(&left)) {
                Ok(0) => {
                    let timeout = self.timeout.as_secs_f64();
                    return Err(io::Error::new(
                        io::ErrorKind::TimedOut,
                        format!(
                            "no answer for {timeout} s; its program runs, but hangs or is stopped"
                        ),
                    ));
                }
                Ok(_) => return Ok(()),
                // A signal interrupted the call.
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn error(&self, what: impl Display) -> NodeError {
        NodeError {
            name: self.name,
            what: what.to_string(),
        }
    }

    /// Returns the error of a node whose pipes fail. If its program has ended, the error says how.
    fn gone(&mut self, error: &io::Error) -> NodeError {
        if error.kind() == io::ErrorKind::TimedOut {
            return self.error(error);
        }
        let deadline = Instant::now() + ENDING;
        let status = loop {
            match self.process.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if Instant::now() < deadline => sleep(Duration::from_millis(5)),
                _ => return self.error(error),
            }
        };
        let words = if self.spoke(deadline) {
            "its last words are above"
        } else {
            "it wrote nothing about it"
        };
        self.error(format!("its program ended ({status}); {words}"))
    }

    /// Whether the process, which has ended, wrote anything to standard error. Waits until that is
    /// copied.
    fn spoke(&mut self, deadline: Instant) -> bool {
        let Some(words) = self.words.take() else {
            return false;
        };
        while !words.is_finished() {
            if Instant::now() >= deadline {
                return false;
            }
            sleep(Duration::from_millis(5));
        }
        words.join().unwrap_or(false)
    }
}

/// Copies a node's standard error to that of this program. Returns whether there was any output.
fn copy(mut from: ChildStderr) -> bool {
    io::copy(&mut from, &mut io::stderr()).is_ok_and(|count| count > 0)
}

impl Drop for Node {
    fn drop(&mut self) {
        // The process may have ended already; errors are ignored in both cases.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn command(board: Board, path: &Path) -> Command {
    match board {
        Board::Native => Command::new(path),
        Board::Qemu => {
            let mut command = Command::new(crate::programs::setup::QEMU);
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
