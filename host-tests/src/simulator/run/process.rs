//! Runs a node program in an emulator: starts it, exchanges messages over its standard streams, and
//! ends it.

use super::link::{Link, TIMEOUT, late};
use crate::programs::setup::QEMU;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io::{self, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::{self, JoinHandle, sleep};
use std::time::{Duration, Instant};
use tautrack::link::{FromNode, MAX_MESSAGE, PREFIX, ToNode};

/// Time within which a process ends after it closed its pipes and its last output is read.
const ENDING: Duration = Duration::from_secs(1);

/// Running node program; the process ends when this is dropped.
pub(super) struct Process {
    child: Child,
    input: ChildStdin,
    output: ChildStdout,
    /// Thread that copies the standard error of the process to that of this program. It returns
    /// whether there was any output.
    words: Option<JoinHandle<bool>>,
    /// Message with its length in front.
    message: Vec<u8>,
    /// Bytes of answers that nobody has asked for yet.
    received: Vec<u8>,
    timeout: Duration,
}

impl Process {
    /// Starts the program at `path`.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be started.
    pub fn start(path: &Path) -> Result<Self, String> {
        let mut process = emulator(path)
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
            message: Vec::with_capacity(PREFIX + MAX_MESSAGE),
            received: Vec::with_capacity(PREFIX + MAX_MESSAGE),
            timeout: TIMEOUT,
        })
    }

    /// Reads until a whole answer is here, with as few system calls as its pieces allow. Returns
    /// its length.
    fn fill(&mut self, timeout: Duration) -> io::Result<usize> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some((length, body)) = self.received.split_first_chunk() {
                let length = usize::from(u16::from_le_bytes(*length));
                if length > MAX_MESSAGE {
                    return Err(io::Error::other("its message is longer than any can be"));
                }
                if body.len() >= length {
                    return Ok(length);
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

impl Link for Process {
    fn send(&mut self, message: ToNode) -> Result<(), String> {
        self.message.clear();
        self.message.extend([0; PREFIX]);
        let bytes = std::mem::take(&mut self.message);
        self.message = postcard::to_extend(&message, bytes).map_err(|error| error.to_string())?;
        let length = self.message.len() - PREFIX;
        let length = u16::try_from(length).map_err(|error| error.to_string())?;
        self.message[..PREFIX].copy_from_slice(&length.to_le_bytes());
        // A process that has ended is reported when its answer is missing.
        let _ = self.input.write_all(&self.message);
        Ok(())
    }

    fn receive(&mut self) -> Result<FromNode, String> {
        let filled = self.fill(self.timeout);
        let length = filled.map_err(|error| self.gone(&error))?;
        let whole = PREFIX + length;
        let answer = postcard::from_bytes(&self.received[PREFIX..whole])
            .map_err(|error| format!("answers nonsense: {error}"));
        self.received.drain(..whole);
        answer
    }

    fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended already; errors are ignored in both cases.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn emulator(path: &Path) -> Command {
    let mut command = Command::new(QEMU);
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
