//! Starts a node program, natively or in QEMU, and talks to it over the lockstep link.

#![allow(dead_code)] // each test program uses a part of it

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::OnceLock;
use tautrack::can::Frame;
use tautrack::link::{
    FromNode, MAX_SERIAL, MotorModel, Ready, STEP_US, Sensors, Start, Step, Stepped, ToNode,
    VERSION,
};
use tautrack::settings::Setting;

/// The roles there are, with the native program of each.
pub const ROLES: [(&str, &str); 3] = [
    ("axle", env!("CARGO_BIN_EXE_axle")),
    ("screw", env!("CARGO_BIN_EXE_screw")),
    ("guard", env!("CARGO_BIN_EXE_guard")),
];

/// A motor that is good for any test.
pub const MOTOR: MotorModel = MotorModel {
    resistance: 0.3,
    inductance: 2e-4,
    torque_constant: 0.05,
    rotor_inertia: 1e-4,
    gear_ratio: 50.0,
    friction_torque: 1.0,
    brake_torque: 0.0,
    encoder_counts: 4096,
    current_noise: 0.02,
    current_quantum: 0.01,
};

/// Settings of node `node_id` that tell it the truth about [`MOTOR`].
pub fn settings(node_id: i32) -> Vec<(u16, i32)> {
    [
        (Setting::NodeId, node_id),
        (Setting::HeartbeatPeriod, 100),
        (Setting::GearRatio, 50_000),
        (Setting::EncoderCounts, 4_096),
        (Setting::TorqueConstant, 50_000),
        (Setting::Resistance, 300),
        (Setting::Inductance, 200),
        (Setting::CurrentLimit, 20_000),
        // 10 A s/rad times 2.5 N m/A over 0.25 kg m^2: a velocity loop of 100 rad/s, five times the position loop's.
        (Setting::VelocityGain, 10_000),
    ]
    .map(|(setting, value)| (setting.description().key, value))
    .to_vec()
}

/// The program of `role` for the emulated board; all are built once per run of a test program.
pub fn elf(role: &str) -> PathBuf {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY
        .get_or_init(|| {
            let root = Path::new(env!("CARGO_MANIFEST_DIR"))
                .parent()
                .expect("the crate is in the workspace");
            let target = Path::new(env!("CARGO_TARGET_TMPDIR"))
                .parent()
                .expect("it is below target")
                .join("nodes");
            let status = Command::new(env!("CARGO"))
                .current_dir(root)
                .args([
                    "build",
                    "--package",
                    "tautrack-firmware",
                    "--target",
                    "thumbv7em-none-eabihf",
                ])
                .args([
                    "--features",
                    "mps2",
                    "--profile",
                    "firmware",
                    "--target-dir",
                ])
                .arg(&target)
                .status()
                .expect("cargo starts");
            assert!(
                status.success(),
                "the nodes do not build for the board: rustup target add thumbv7em-none-eabihf?"
            );
            target.join("thumbv7em-none-eabihf/firmware")
        })
        .join(role)
}

/// A running node.
pub struct Node {
    process: Child,
    input: ChildStdin,
    output: ChildStdout,
    time_us: u64,
    serial: Vec<u8>,
}

impl Node {
    /// The program `path` as a process of the host.
    pub fn native(path: &str) -> Self {
        Self::spawn(&mut Command::new(path))
    }

    /// As [`Node::native`]; what it writes as errors is for [`Node::starve`].
    pub fn native_with_errors(path: &str) -> Self {
        Self::spawn(Command::new(path).stderr(Stdio::piped()))
    }

    /// Lets `us` pass without anything running, and waits for the node to end: whether it ended
    /// well, and its errors.
    pub fn starve(mut self, us: u64) -> (bool, String) {
        let step = Step {
            time_us: self.time_us + us,
            sensors: Sensors::default(),
            frames: heapless::Vec::new(),
            serial: heapless::Vec::new(),
        };
        let body =
            postcard::to_allocvec(&ToNode::Step(step)).expect("every message can be encoded");
        let mut bytes = (body.len() as u16).to_le_bytes().to_vec();
        bytes.extend(body);
        self.input.write_all(&bytes).expect("the node reads");
        drop(self.input);
        let mut said = String::new();
        if let Some(mut errors) = self.process.stderr.take() {
            errors.read_to_string(&mut said).expect("text");
        }
        let status = self.process.wait().expect("the node ends");
        (status.success(), said)
    }

    /// The program of `role` in QEMU.
    pub fn emulated(role: &str) -> Self {
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
            .arg(elf(role));
        Self::spawn(&mut command)
    }

    fn spawn(command: &mut Command) -> Self {
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
            time_us: 0,
            serial: Vec::new(),
        }
    }

    fn exchange(&mut self, message: &ToNode) -> FromNode {
        let body = postcard::to_allocvec(message).expect("every message can be encoded");
        let mut bytes = (body.len() as u16).to_le_bytes().to_vec();
        bytes.extend(body);
        self.input.write_all(&bytes).expect("the node reads");
        self.input.flush().expect("the node reads");
        let mut length = [0; 2];
        self.output
            .read_exact(&mut length)
            .expect("the node answers");
        let mut body = vec![0; usize::from(u16::from_le_bytes(length))];
        self.output.read_exact(&mut body).expect("the node answers");
        postcard::from_bytes(&body).expect("the answer is a message")
    }

    /// Powers the node up.
    pub fn start(&mut self, settings: &[(u16, i32)], motor: Option<MotorModel>) -> Ready {
        let start = Start {
            version: VERSION,
            seed: 11,
            settings: settings.iter().copied().collect(),
            motor,
        };
        match self.exchange(&ToNode::Start(start)) {
            FromNode::Ready(ready) => ready,
            FromNode::Stepped(_) => panic!("a step was answered before there was one"),
        }
    }

    /// Puts bytes on the node's serial line; each step takes as many as it can.
    pub fn say(&mut self, bytes: &[u8]) {
        self.serial.extend(bytes);
    }

    /// One step with these frames and sensor values.
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

    /// Closes the link and waits; whether the program ended well.
    pub fn finish(self) -> bool {
        let Self {
            mut process,
            input,
            mut output,
            ..
        } = self;
        drop(input);
        // Its last words need somebody to hear them.
        let _ = std::io::copy(&mut output, &mut std::io::sink());
        process.wait().expect("the node ends").success()
    }
}
