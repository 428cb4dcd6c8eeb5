//! Runs a node program as a process.

use super::elf;
use super::processor::OneProcessor;
use std::io::{Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use tautrack::can::Frame;
use tautrack::link::{
    FromNode, MAX_SERIAL, MotorModel, Prefix, Ready, STEP_US, Sensors, Start, Step, Stepped,
    ToNode, VERSION,
};

/// A running node.
pub struct Node {
    process: Child,
    input: ChildStdin,
    output: ChildStdout,
    _processor: Option<OneProcessor>,
    /// Role that the program takes on; empty for its own.
    role: &'static str,
    time_us: u64,
    serial: Vec<u8>,
}

impl Node {
    /// Starts the program `path` as a process of the host.
    pub fn native(path: &str) -> Self {
        Self::spawn(&mut Command::new(path), "")
    }

    /// Starts the program like [`Node::native`], and keeps its standard error for [`Node::starve`].
    pub fn native_with_errors(path: &str) -> Self {
        Self::spawn(Command::new(path).stderr(Stdio::piped()), "")
    }

    /// Advances the time by `us` without running the node, and waits for it to end. Returns whether
    /// it ended with success, and its standard error.
    pub fn starve(mut self, us: u64) -> (bool, String) {
        let step = Step {
            time_us: self.time_us + us,
            sensors: Sensors::default(),
            frames: heapless::Vec::new(),
            serial: heapless::Vec::new(),
        };
        let body =
            postcard::to_allocvec(&ToNode::Step(step)).expect("every message can be encoded");
        let bytes = with_prefix(&body);
        self.input.write_all(&bytes).expect("the node reads");
        drop(self.input);
        let mut said = String::new();
        if let Some(mut errors) = self.process.stderr.take() {
            errors.read_to_string(&mut said).expect("text");
        }
        let status = self.process.wait().expect("the node ends");
        (status.success(), said)
    }

    /// Starts a node with this role in QEMU.
    pub fn emulated(role: &'static str) -> Self {
        let mut command = Command::new("qemu-system-arm");
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
            .arg(elf());
        Self::spawn(&mut command, role)
    }

    fn spawn(command: &mut Command, role: &'static str) -> Self {
        let processor = OneProcessor::present();
        let mut process = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the node starts; for QEMU: apt-get install qemu-system-arm");
        let input = process.stdin.take().expect("piped");
        let output = process.stdout.take().expect("piped");
        Self {
            process,
            input,
            output,
            _processor: processor,
            role,
            time_us: 0,
            serial: Vec::new(),
        }
    }

    fn exchange(&mut self, message: &ToNode) -> FromNode {
        let body = postcard::to_allocvec(message).expect("every message can be encoded");
        self.input
            .write_all(&with_prefix(&body))
            .expect("the node reads");
        self.input.flush().expect("the node reads");
        let mut prefix = [0; Prefix::BYTES];
        self.output
            .read_exact(&mut prefix)
            .expect("the node answers");
        let mut body = vec![0; usize::from(Prefix::from_bytes(prefix).length)];
        self.output.read_exact(&mut body).expect("the node answers");
        postcard::from_bytes(&body).expect("the answer is a message")
    }

    /// Powers the node up with these settings.
    pub fn start(&mut self, settings: &[(u16, i32)], motor: Option<MotorModel>) -> Ready {
        self.start_with_flash("", settings, motor)
    }

    /// Powers the node up with the flash in the file `flash`, which these settings fill if it is
    /// blank.
    pub fn start_with_flash(
        &mut self,
        flash: &str,
        settings: &[(u16, i32)],
        motor: Option<MotorModel>,
    ) -> Ready {
        let start = Start {
            version: VERSION,
            seed: 11,
            flash: flash.try_into().expect("a short path"),
            settings: settings.iter().copied().collect(),
            motor,
            role: self.role.try_into().expect("a short name"),
        };
        match self.exchange(&ToNode::Start(start)) {
            FromNode::Ready(ready) => ready,
            FromNode::Stepped(_) => panic!("a step was answered before there was one"),
        }
    }

    /// Queues bytes for the node's serial line; each step sends as many as one message can carry.
    pub fn say(&mut self, bytes: &[u8]) {
        self.serial.extend(bytes);
    }

    /// Runs one step with these frames and sensor values.
    pub fn step(&mut self, sensors: Sensors, frames: &[Frame]) -> Stepped {
        self.time_us += STEP_US;
        let step = Step {
            time_us: self.time_us,
            sensors,
            frames: frames.iter().copied().collect(),
            serial: {
                let count = self.serial.len().min(MAX_SERIAL);
                self.serial.drain(..count).collect()
            },
        };
        match self.exchange(&ToNode::Step(step)) {
            FromNode::Stepped(stepped) => stepped,
            FromNode::Ready(_) => panic!("a step was answered by a start"),
        }
    }

    /// Closes the link and waits for the program to end. Returns whether it ended with success.
    pub fn finish(self) -> bool {
        let Self {
            mut process, input, ..
        } = self;
        drop(input);
        process.wait().expect("the node ends").success()
    }
}

/// The message with the prefix for the first node of a process.
fn with_prefix(body: &[u8]) -> Vec<u8> {
    let length = body.len() as u16;
    [&Prefix { length, node: 0 }.to_bytes(), body].concat()
}
