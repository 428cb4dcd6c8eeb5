//! A notation for exchanges with a node.
//!
//! An exchange is a list of steps, `request > answer, answer; request > ...`. A word in a request
//! or an answer is
//! * `605:` an identifier. Without one, a frame is an SDO of eight bytes, filled with zeros;
//! * `1017:00` an index and a sub-index, `2b` a byte, and `0064` and `06020000` numbers of two and
//!   four bytes, the lowest byte first on the bus; `..` is any byte;
//! * `*3` so many frames of this kind;
//! * `20ms` a time in which the node's ticks run, `=1ms` one of which every millisecond counts, and
//!   `turn` a movement of its rotor.

use super::NODE;
use std::fmt;
use tautrack::can::Frame;

/// What a client does, and all that the node sends then, in this order.
pub struct Step {
    /// The step as it is written.
    pub text: String,
    pub request: Request,
    pub answers: Vec<Pattern>,
}

pub enum Request {
    Send(Vec<Frame>),
    /// Waits for so many milliseconds. If they are exact, the answers depend on each of them.
    Wait {
        time: u32,
        exact: bool,
    },
    /// Turns the rotor of a drive.
    Turn,
}

/// A frame of which some bytes may have any value.
#[derive(Clone)]
pub struct Pattern {
    pub id: u16,
    pub bytes: Vec<Option<u8>>,
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:03x}:", self.id)?;
        for byte in &self.bytes {
            match byte {
                Some(byte) => write!(f, " {byte:02x}")?,
                None => write!(f, " ..")?,
            }
        }
        Ok(())
    }
}

/// Reads one frame. Returns it as often as it says.
fn frames(words: &str, sdo: u16) -> Vec<Pattern> {
    let (mut id, mut bytes, mut times) = (None, Vec::new(), 1);
    let hex = |digits: &str| {
        u32::from_str_radix(digits, 16).unwrap_or_else(|_| panic!("not hexadecimal: {digits}"))
    };
    for word in words.split_whitespace() {
        if word == ".." {
            bytes.push(None);
        } else if let Some(count) = word.strip_prefix('*') {
            times = count.parse().expect("a count");
        } else if let Some(identifier) = word.strip_suffix(':') {
            id = Some(hex(identifier) as u16);
        } else {
            for part in word.split(':') {
                let number = hex(part).to_le_bytes();
                bytes.extend(number.iter().take(part.len() / 2).copied().map(Some));
            }
        }
    }
    if id.is_none() {
        bytes.resize(8, Some(0));
    }
    let id = id.unwrap_or(sdo + NODE);
    vec![Pattern { id, bytes }; times]
}

fn request(words: &str) -> Request {
    if let Some(time) = words.strip_suffix("ms") {
        let digits = time.trim_start_matches('=');
        return Request::Wait {
            time: digits.parse().expect("a time"),
            exact: digits != time,
        };
    }
    if words == "turn" {
        return Request::Turn;
    }
    let frame = |pattern: Pattern| {
        let bytes: Option<Vec<u8>> = pattern.bytes.into_iter().collect();
        let bytes = bytes.expect("a request has no free bytes");
        Frame::new(pattern.id, &bytes).expect("a frame")
    };
    Request::Send(frames(words, 0x600).into_iter().map(frame).collect())
}

/// Reads an exchange.
pub fn steps(exchange: &str) -> Vec<Step> {
    let step = |text: &str| {
        let (asked, answers) = text.split_once('>').expect("a step has a `>`");
        let answers = answers.split(',').filter(|words| !words.trim().is_empty());
        Step {
            text: text.to_owned(),
            request: request(asked.trim()),
            answers: answers.flat_map(|words| frames(words, 0x580)).collect(),
        }
    };
    let steps = exchange.split(';').map(str::trim);
    steps.filter(|step| !step.is_empty()).map(step).collect()
}
