//! Runs a node program as a process: starts it, exchanges messages over its standard streams, and
//! ends it. Nodes with the same program can share an emulated machine, see [`Machines`].

use super::link::{Link, TIMEOUT, late};
use crate::programs::Board;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::cell::RefCell;
use std::io::{self, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::rc::Rc;
use std::thread::{self, JoinHandle, available_parallelism, sleep};
use std::time::{Duration, Instant};
use tautrack::link::{MAX_MESSAGE, Prefix};

/// Time within which a process ends after it closed its pipes and its last output is read.
const ENDING: Duration = Duration::from_secs(1);

/// Emulated machines of a run.
///
/// There are as many for a program as this computer has processors, if there are enough nodes. More
/// would displace each other's code from the caches.
#[derive(Default)]
pub struct Machines(Vec<(PathBuf, Rc<RefCell<Process>>)>);

impl Machines {
    /// Starts a node with the program at `path` on the machine that has had the fewest.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be started.
    pub(super) fn start(&mut self, path: &Path) -> Result<Seat, String> {
        let shared = self.0.iter().filter(|(program, _)| program == path);
        let processors = available_parallelism().map_or(1, usize::from);
        let machine = if shared.clone().count() < processors {
            None
        } else {
            shared.min_by_key(|(_, machine)| machine.borrow().nodes)
        };
        if let Some(seat) = machine.and_then(|(_, machine)| Seat::on(machine)) {
            return Ok(seat);
        }
        let seat = Seat::alone(Board::Qemu, path)?;
        self.0.push((path.to_owned(), Rc::clone(&seat.process)));
        Ok(seat)
    }
}

/// A node of a process. The process ends with its last seat, one of [`Machines`] with these.
pub(super) struct Seat {
    process: Rc<RefCell<Process>>,
    number: u8,
    timeout: Duration,
}

impl Seat {
    /// Starts the program at `path` with one node.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be started.
    pub fn alone(board: Board, path: &Path) -> Result<Self, String> {
        let process = Rc::new(RefCell::new(Process::start(board, path)?));
        Self::on(&process).ok_or_else(|| "has no node".to_owned())
    }

    /// Adds a node to the process; `None` if it has had as many as it can.
    fn on(process: &Rc<RefCell<Process>>) -> Option<Self> {
        let nodes = &mut process.borrow_mut().nodes;
        let number = u8::try_from(*nodes).ok()?;
        *nodes += 1;
        Some(Self {
            process: Rc::clone(process),
            number,
            timeout: TIMEOUT,
        })
    }
}

impl Link for Seat {
    fn send(&mut self, message: &[u8]) -> Result<(), String> {
        self.process.borrow_mut().send(self.number, message)
    }

    fn receive(&mut self, answer: &mut Vec<u8>) -> Result<(), String> {
        let mut process = self.process.borrow_mut();
        process.receive(self.number, self.timeout, answer)
    }

    fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }
}

/// Running node program; the process ends when this is dropped.
struct Process {
    child: Child,
    input: ChildStdin,
    output: ChildStdout,
    /// Thread that copies the standard error of the process to that of this program. It returns
    /// whether there was any output.
    words: Option<JoinHandle<bool>>,
    /// Message with its prefix.
    message: Vec<u8>,
    /// Bytes of answers that nobody has asked for yet.
    received: Vec<u8>,
    /// Number of nodes in the life of the process.
    nodes: usize,
}

impl Process {
    /// Starts the program at `path`.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be started.
    fn start(board: Board, path: &Path) -> Result<Self, String> {
        let mut process = command(board, path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C in a terminal ends only this program, which then ends its nodes.
            .process_group(0)
            .spawn()
            .map_err(|error| format!("{} does not start: {error}", path.display()))?;
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (input, output) = pipes.ok_or("has no pipes")?;
        let words = process
            .stderr
            .take()
            .map(|from| thread::spawn(|| copy(from)));
        Ok(Self {
            child: process,
            input,
            output,
            words,
            message: Vec::with_capacity(Prefix::BYTES + MAX_MESSAGE),
            received: Vec::with_capacity(Prefix::BYTES + MAX_MESSAGE),
            nodes: 0,
        })
    }

    fn send(&mut self, node: u8, message: &[u8]) -> Result<(), String> {
        let length = u16::try_from(message.len()).map_err(|error| error.to_string())?;
        self.message.clear();
        self.message.extend(Prefix { length, node }.to_bytes());
        self.message.extend(message);
        // A process that has ended is reported for the first node whose answer is missing.
        let _ = self.input.write_all(&self.message);
        Ok(())
    }

    /// Waits for the answer of this node. Answers come in the order of their questions.
    fn receive(&mut self, node: u8, timeout: Duration, answer: &mut Vec<u8>) -> Result<(), String> {
        let prefix = self.fill(timeout).map_err(|error| self.gone(&error))?;
        if prefix.node != node {
            return Err(format!(
                "node {} of its process answers instead",
                prefix.node
            ));
        }
        let whole = Prefix::BYTES + usize::from(prefix.length);
        answer.clear();
        answer.extend(self.received.drain(..whole).skip(Prefix::BYTES));
        Ok(())
    }

    /// Reads until a whole answer is here, with as few system calls as its pieces allow. Returns
    /// its prefix.
    fn fill(&mut self, timeout: Duration) -> io::Result<Prefix> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some((prefix, body)) = self.received.split_first_chunk() {
                let prefix = Prefix::from_bytes(*prefix);
                let length = usize::from(prefix.length);
                if length > MAX_MESSAGE {
                    return Err(io::Error::other("its message is longer than any can be"));
                }
                if body.len() >= length {
                    return Ok(prefix);
                }
            }
            self.wait_for_bytes(deadline, timeout)?;
            let mut bytes = [0; 4096];
            match self.output.read(&mut bytes)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                count => self.received.extend(&bytes[..count]),
            }
        }
    }

    fn wait_for_bytes(&self, deadline: Instant, timeout: Duration) -> io::Result<()> {
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let left = Timespec::try_from(left).map_err(io::Error::other)?;
            let mut ready = [PollFd::new(&self.output, PollFlags::IN)];
            match poll(&mut ready, Some(&left)) {
                Ok(0) => {
                    return Err(io::Error::new(io::ErrorKind::TimedOut, late(timeout)));
                }
                Ok(_) => return Ok(()),
                // A signal interrupted the call.
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Returns the error of a node whose pipes fail. If its program has ended, the error says how.
    fn gone(&mut self, error: &io::Error) -> String {
        if error.kind() == io::ErrorKind::TimedOut {
            return error.to_string();
        }
        let deadline = Instant::now() + ENDING;
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if Instant::now() < deadline => sleep(Duration::from_millis(5)),
                _ => return error.to_string(),
            }
        };
        let words = if self.spoke(deadline) {
            "its last words are above"
        } else {
            "it wrote nothing about it"
        };
        format!("its program ended ({status}); {words}")
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

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended already; errors are ignored in both cases.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn command(board: Board, path: &Path) -> Command {
    match board {
        Board::Native | Board::Wasm | Board::Image => Command::new(path),
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
