//! Lines of the SLCAN protocol: parses a client's requests and formats frames for it.

use tautrack::can::Frame;

/// Request in one line of a client.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// `t`: send a frame.
    Transmit(Frame),
    /// `O`: take part in the bus.
    Open,
    /// `C`: leave the bus.
    Close,
    /// `S0` to `S8`: set the bit rate.
    BitRate,
    /// `V`: hardware and software version.
    Version,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags.
    Status,
    /// Any other request, including extended and remote frames.
    Unsupported,
}

impl Request {
    /// Parses one line without its carriage return. Returns `None` for an empty line, which clients
    /// send to synchronise.
    pub fn parse(line: &[u8]) -> Option<Self> {
        let (command, argument) = line.split_first()?;
        Some(match (command, argument) {
            (b't', frame) => parse_frame(frame).map_or(Self::Unsupported, Self::Transmit),
            (b'O', []) => Self::Open,
            (b'C', []) => Self::Close,
            (b'S', [b'0'..=b'8']) => Self::BitRate,
            (b'V', []) => Self::Version,
            (b'N', []) => Self::SerialNumber,
            (b'F', []) => Self::Status,
            _ => Self::Unsupported,
        })
    }
}

fn parse_frame(text: &[u8]) -> Option<Frame> {
    let (head, data) = text.split_at_checked(4)?;
    let id = number(&head[..3])?;
    let length = number(&head[3..])?;
    if data.len() != 2 * usize::from(length) {
        return None;
    }
    let bytes: Option<Vec<u8>> = data
        .chunks(2)
        .map(|byte| number(byte).map(|byte| byte as u8))
        .collect();
    Frame::new(id, &bytes?)
}

/// Parses a number of at most four hexadecimal digits.
fn number(digits: &[u8]) -> Option<u16> {
    digits.iter().try_fold(0, |value, digit| {
        Some(value << 4 | char::from(*digit).to_digit(16)? as u16)
    })
}

/// Formats the line that carries `frame` to a client, including its carriage return.
pub fn line_of(frame: &Frame) -> String {
    use std::fmt::Write;
    let mut line = format!("t{:03X}{}", frame.id(), frame.data().len());
    for byte in frame.data() {
        // Writing to a string cannot fail.
        let _ = write!(line, "{byte:02X}");
    }
    line.push('\r');
    line
}
