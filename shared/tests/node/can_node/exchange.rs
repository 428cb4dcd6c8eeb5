//! A notation for exchanges with a node, and what runs them.
//!
//! An exchange is a list of steps, `request > answer, answer; request > ...`. A word in a request
//! or an answer is
//! * `605:` an identifier. Without one, a frame is an SDO of eight bytes, filled with zeros;
//! * `1017:00` an index and a sub-index, `2b` a byte, and `0064` and `06020000` numbers of two and
//!   four bytes, the lowest byte first on the bus; `..` is any byte;
//! * `*3` so many frames of this kind;
//! * `20ms` a time in which the node's ticks run, and `turn` a movement of its rotor.

use super::{NODE, Subject};
use std::fmt;
use tautrack::can::Frame;

/// A frame of which some bytes may have any value.
#[derive(Clone)]
pub struct Pattern {
    id: u16,
    bytes: Vec<Option<u8>>,
}

impl Pattern {
    fn matches(&self, frame: &Frame) -> bool {
        let data = frame.data();
        let mut pairs = self.bytes.iter().zip(data);
        self.id == frame.id()
            && self.bytes.len() == data.len()
            && pairs.all(|(byte, got)| byte.is_none_or(|byte| byte == *got))
    }
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

/// Runs a request. Returns what the node sends.
fn request(node: &mut impl Subject, words: &str) -> Vec<Frame> {
    if let Some(time) = words.strip_suffix("ms") {
        let time: u32 = time.parse().expect("a time");
        return (0..time).flat_map(|_| node.run(true)).collect();
    }
    if words == "turn" {
        node.turn();
        return Vec::new();
    }
    let send = |pattern: Pattern| {
        let bytes: Option<Vec<u8>> = pattern.bytes.into_iter().collect();
        node.receive(pattern.id, &bytes.expect("a request has no free bytes"))
    };
    frames(words, 0x600).into_iter().flat_map(send).collect()
}

/// Runs an exchange.
///
/// # Errors
/// The node sends something else. The text says what.
pub fn run(node: &mut impl Subject, exchange: &str) -> Result<(), String> {
    for step in exchange.split(';').map(str::trim) {
        if step.is_empty() {
            continue;
        }
        let (asked, answers) = step.split_once('>').expect("a step has a `>`");
        let answers = answers.split(',').filter(|words| !words.trim().is_empty());
        let expected: Vec<_> = answers.flat_map(|words| frames(words, 0x580)).collect();
        let sent = request(node, asked.trim());
        let matches = expected.len() == sent.len()
            && expected.iter().zip(&sent).all(|(it, got)| it.matches(got));
        if !matches {
            let expected: Vec<_> = expected.iter().map(Pattern::to_string).collect();
            let exactly = |frame: &Frame| Pattern {
                id: frame.id(),
                bytes: frame.data().iter().copied().map(Some).collect(),
            };
            let sent: Vec<_> = sent.iter().map(|it| exactly(it).to_string()).collect();
            return Err(format!("{step}\nexpected {expected:#?}\nsent {sent:#?}"));
        }
    }
    Ok(())
}
