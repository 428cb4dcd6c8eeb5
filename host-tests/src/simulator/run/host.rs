//! Runs one node as a value in this process. A node that panics ends; this program does not.

use super::link::Link;
use crate::robots::Kind;
use clap::ValueEnum;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tautrack::link::{FromNode, Ready, Start, Stepped, ToNode, VERSION};
use tautrack_firmware::boards::host::{AXLE, NAME, Node, Role, SCREW};

/// A node and the message that it has not answered yet.
pub(super) struct Host {
    /// Name of the guard's program of the robot.
    program: PathBuf,
    node: Option<Node>,
    message: Option<ToNode>,
}

impl Host {
    /// A node of the robot whose guard has the program `program`.
    pub fn new(program: &Path) -> Self {
        Self {
            program: program.to_owned(),
            node: None,
            message: None,
        }
    }

    fn answer(&mut self, message: &ToNode) -> Result<FromNode, String> {
        match (message, &mut self.node) {
            (ToNode::Start(start), None) => Ok(FromNode::Ready(self.start(start))),
            (ToNode::Step(step), Some(node)) => {
                let mut stepped = Stepped::default();
                node.step(step, &mut stepped);
                Ok(FromNode::Stepped(stepped))
            }
            _ => Err("a message out of order".to_owned()),
        }
    }

    fn start(&mut self, start: &Start) -> Ready {
        let mut refusal = heapless::String::new();
        match self.role(&start.role) {
            None => {
                // Cannot fail: names of roles are short.
                let _ = refusal.push_str("the program has no role: ");
                let _ = refusal.push_str(&start.role);
            }
            Some(role) => match Node::start(role, start) {
                Ok(node) => self.node = Some(node),
                Err(why) => refusal = why,
            },
        }
        Ready {
            version: VERSION,
            role: start.role.clone(),
            board: NAME.try_into().unwrap_or_default(),
            refusal,
        }
    }

    fn role(&self, name: &str) -> Option<&'static Role> {
        let mut robots = Kind::value_variants().iter().map(|kind| kind.facts());
        let robot = robots.find(|facts| self.program == Path::new(facts.guard_program))?;
        let roles = [&AXLE, &SCREW, robot.guard];
        roles.into_iter().find(|role| role.name == name)
    }
}

impl Link for Host {
    fn send(&mut self, message: ToNode) -> Result<(), String> {
        self.message = Some(message);
        Ok(())
    }

    fn receive(&mut self) -> Result<FromNode, String> {
        let message = self.message.take().ok_or("no message to answer")?;
        // A node that has panicked is not used again.
        catch_unwind(AssertUnwindSafe(|| self.answer(&message)))
            .unwrap_or_else(|panic| Err(format!("it panicked: {}", text(&*panic))))
    }

    /// A node that hangs takes this program with it.
    fn set_timeout(&mut self, _: Duration) {}
}

/// The text of a panic.
fn text(panic: &(dyn Any + Send)) -> &str {
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    let borrowed = || panic.downcast_ref::<&str>().copied();
    owned.or_else(borrowed).unwrap_or("without a text")
}
