//! A node of either kind.

use super::process::Process;
use tautrack::can::Frame;
use tautrack::link::{
    FromNode, MAX_SERIAL, MotorModel, Ready, STEP_US, Sensors, Start, Step, Stepped, ToNode,
    VERSION,
};
use tautrack_firmware::boards::host;

/// All roles.
pub const ROLES: [&str; 3] = ["axle", "screw", "guard"];

/// A running node.
pub struct Node {
    life: Life,
    /// Role that the node takes on.
    role: &'static str,
    time_us: u64,
    serial: Vec<u8>,
    /// With what the node was powered up last.
    start: Option<Start>,
}

enum Life {
    /// In this process; `None` before it is powered.
    Host(Option<Box<host::Node>>),
    Emulated(Process),
}

impl Node {
    /// A node in this process.
    pub fn host(role: &'static str) -> Self {
        Self::new(role, Life::Host(None))
    }

    /// A node in QEMU.
    pub fn emulated(role: &'static str) -> Self {
        Self::new(role, Life::Emulated(Process::start()))
    }

    fn new(role: &'static str, life: Life) -> Self {
        Self {
            life,
            role,
            time_us: 0,
            serial: Vec::new(),
            start: None,
        }
    }

    /// Name of the board.
    pub fn board(&self) -> &'static str {
        match self.life {
            Life::Host(_) => host::NAME,
            Life::Emulated(_) => "mps2",
        }
    }

    /// Powers the node up with these settings. Returns why it refuses them.
    pub fn start(&mut self, settings: &[(u16, i32)], motor: Option<MotorModel>) -> String {
        self.start_with_flash("", settings, motor)
    }

    /// Powers the node up with the flash in the file `flash`, which these settings fill if it is
    /// blank.
    pub fn start_with_flash(
        &mut self,
        flash: &str,
        settings: &[(u16, i32)],
        motor: Option<MotorModel>,
    ) -> String {
        let start = Start {
            version: VERSION,
            seed: 11,
            flash: flash.try_into().expect("a short path"),
            settings: settings.iter().copied().collect(),
            motor,
            role: self.role.try_into().expect("a short name"),
        };
        self.start = Some(start.clone());
        self.power_up(start)
    }

    fn power_up(&mut self, start: Start) -> String {
        self.time_us = 0;
        match &mut self.life {
            Life::Host(node) => {
                let role = match self.role {
                    "axle" => &host::AXLE,
                    "screw" => &host::SCREW,
                    _ => const { &host::guard::<tautrack::robots::b2p2::B2p2>() },
                };
                match host::Node::start(role, &start) {
                    Ok(powered) => {
                        *node = Some(Box::new(powered));
                        String::new()
                    }
                    Err(refusal) => refusal.to_string(),
                }
            }
            Life::Emulated(process) => match process.exchange(&ToNode::Start(start)) {
                FromNode::Ready(Ready {
                    version: VERSION,
                    role,
                    board,
                    refusal,
                }) => {
                    assert_eq!((&*role, &*board), (self.role, "mps2"));
                    refusal.to_string()
                }
                other => panic!("{other:?}"),
            },
        }
    }

    /// Queues bytes for the node's serial line; each step sends as many as one message can carry.
    pub fn say(&mut self, bytes: &[u8]) {
        self.serial.extend(bytes);
    }

    /// Runs one step with these frames and sensor values.
    pub fn step(&mut self, sensors: Sensors, frames: &[Frame]) -> Stepped {
        self.time_us += STEP_US;
        let count = self.serial.len().min(MAX_SERIAL);
        let step = Step {
            time_us: self.time_us,
            sensors,
            frames: frames.iter().copied().collect(),
            serial: self.serial.drain(..count).collect(),
        };
        let stepped = match &mut self.life {
            Life::Host(node) => {
                let mut stepped = Stepped::default();
                node.as_mut().expect("powered").step(&step, &mut stepped);
                stepped
            }
            Life::Emulated(process) => match process.exchange(&ToNode::Step(step)) {
                FromNode::Stepped(stepped) => stepped,
                FromNode::Ready(_) => panic!("a step was answered by a start"),
            },
        };
        if stepped.restart {
            self.restart();
        }
        stepped
    }

    /// Powers the node up again, with its flash if that is in a file.
    fn restart(&mut self) {
        if matches!(self.life, Life::Emulated(_)) {
            self.life = Life::Emulated(Process::start());
        }
        let start = self.start.clone().expect("a node that has run");
        assert_eq!(self.power_up(start), "");
    }

    /// Advances the time of an emulated node by `us` without running it, and waits for it to end.
    /// Returns whether it ended with success, and its standard error.
    pub fn starve(self, us: u64) -> (bool, String) {
        let step = ToNode::Step(Step {
            time_us: self.time_us + us,
            sensors: Sensors::default(),
            frames: heapless::Vec::new(),
            serial: heapless::Vec::new(),
        });
        self.end(Some(&step))
    }

    /// Closes the link of an emulated node and waits for it to end. Returns whether it ended with
    /// success.
    pub fn finish(self) -> bool {
        self.end(None).0
    }

    fn end(self, message: Option<&ToNode>) -> (bool, String) {
        match self.life {
            Life::Host(_) => (true, String::new()),
            Life::Emulated(process) => process.end(message),
        }
    }
}
