//! Runs one flash image of a board on the model of its chip, in a thread of its own: the images of
//! a run use all cores.

use super::link::{Link, TIMEOUT, late};
use crate::simulator::chip::board::{FlashImage, FlashedBoard};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;
use tautrack::link::{FromNode, Ready, Start, ToNode, VERSION};

type Answer = Result<FromNode, String>;

/// Running board; its thread ends after this is dropped.
pub(super) struct Image {
    messages: Sender<ToNode>,
    answers: Receiver<Answer>,
    timeout: Duration,
}

impl Image {
    /// Creates a board for the application at `path`.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be read or is none of a board.
    pub fn start(path: &Path) -> Result<Self, String> {
        let mut node = Node {
            role: role(path)?,
            image: FlashImage::load(path)?,
            board: None,
        };
        let (messages, received) = channel::<ToNode>();
        let (to_runner, answers) = channel();
        thread::spawn(move || {
            for message in received {
                if to_runner.send(node.answer(&message)).is_err() {
                    break;
                }
            }
        });
        Ok(Self {
            messages,
            answers,
            timeout: TIMEOUT,
        })
    }
}

impl Link for Image {
    fn send(&mut self, message: ToNode) -> Result<(), String> {
        let sent = self.messages.send(message);
        sent.map_err(|_| ended())
    }

    fn receive(&mut self) -> Answer {
        match self.answers.recv_timeout(self.timeout) {
            Ok(answer) => answer,
            Err(RecvTimeoutError::Timeout) => Err(late(self.timeout)),
            Err(RecvTimeoutError::Disconnected) => Err(ended()),
        }
    }

    fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }
}

fn ended() -> String {
    "the model of its chip has panicked; the reason is above".to_owned()
}

fn role(path: &Path) -> Result<heapless::String<16>, String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    heapless::String::try_from(&*name).map_err(|_| format!("{} is no role", path.display()))
}

/// A board before and after it was switched on.
struct Node {
    role: heapless::String<16>,
    image: FlashImage,
    board: Option<FlashedBoard>,
}

impl Node {
    fn answer(&mut self, message: &ToNode) -> Answer {
        match (message, &mut self.board) {
            (ToNode::Start(start), None) => Ok(FromNode::Ready(self.switch_on(start))),
            (ToNode::Step(step), Some(board)) => Ok(FromNode::Stepped(board.step(step))),
            _ => Err("a message out of order".to_owned()),
        }
    }

    fn switch_on(&mut self, start: &Start) -> Ready {
        let refusal = match FlashedBoard::new(&self.image, start) {
            Ok(board) => {
                self.board = Some(board);
                heapless::String::new()
            }
            Err(error) => heapless::String::try_from(&*error).unwrap_or_default(),
        };
        Ready {
            version: VERSION,
            role: self.role.clone(),
            board: heapless::String::try_from(self.image.board()).unwrap_or_default(),
            refusal,
        }
    }
}
