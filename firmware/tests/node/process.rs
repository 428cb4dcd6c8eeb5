//! Runs the node program in QEMU.

use super::elf;
use std::io::{Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use tautrack::link::{FromNode, PREFIX, ToNode};

/// The emulator with a node.
pub struct Process {
    emulator: Child,
    input: ChildStdin,
    output: ChildStdout,
}

impl Process {
    pub fn start() -> Self {
        let mut emulator = Command::new("qemu-system-arm")
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
            .arg(elf())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the node starts; for QEMU: apt-get install qemu-system-arm");
        let input = emulator.stdin.take().expect("piped");
        let output = emulator.stdout.take().expect("piped");
        Self {
            emulator,
            input,
            output,
        }
    }

    fn send(&mut self, message: &ToNode) {
        let body = postcard::to_allocvec(message).expect("every message can be encoded");
        let length = (body.len() as u16).to_le_bytes();
        let bytes = [&length, body.as_slice()].concat();
        self.input.write_all(&bytes).expect("the node reads");
        self.input.flush().expect("the node reads");
    }

    pub fn exchange(&mut self, message: &ToNode) -> FromNode {
        self.send(message);
        let mut prefix = [0; PREFIX];
        self.output
            .read_exact(&mut prefix)
            .expect("the node answers");
        let mut body = vec![0; usize::from(u16::from_le_bytes(prefix))];
        self.output.read_exact(&mut body).expect("the node answers");
        postcard::from_bytes(&body).expect("the answer is a message")
    }

    /// Sends a message, or closes the link, and waits for the program to end. Returns whether it
    /// ended with success, and its standard error.
    pub fn end(mut self, message: Option<&ToNode>) -> (bool, String) {
        if let Some(message) = message {
            self.send(message);
        }
        drop(self.input);
        let mut said = String::new();
        if let Some(mut errors) = self.emulator.stderr.take() {
            errors.read_to_string(&mut said).expect("text");
        }
        let status = self.emulator.wait().expect("the node ends");
        (status.success(), said)
    }
}
