//! Lines of the SLCAN protocol: parses a client's requests and formats frames for it.

use tautrack::can::Frame;

/// Maximum length of a line without its carriage return: `T`, eight digits of identifier, one of
/// length, 16 of data.
pub const MAX_LINE: usize = 26;

/// Request in one line of a client.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// `t`: send a data frame with an 11-bit identifier.
    Transmit(Frame),
    /// `r`: send a remote frame; `T` and `R`: send a frame with a 29-bit identifier.
    TransmitUnheard {
        /// Whether the identifier has 29 bits.
        extended: bool,
    },
    /// `O`: take part in the bus.
    Open,
    /// `L`: receive the frames of the bus, and send none.
    Listen,
    /// `C`: leave the bus.
    Close,
    /// `S`, `s`, `M` or `m` with the value that the port has: 1 Mbit/s, and a filter that passes
    /// every frame.
    Confirm,
    /// `Z0`, `Z1`: whether received frames carry a time stamp.
    TimeStamps(bool),
    /// `V`: hardware and software version.
    Version,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags.
    Status,
    /// Any other line, an empty one too.
    Unknown,
}

impl Request {
    /// Parses one line without its carriage return.
    pub fn parse(line: &[u8]) -> Self {
        let Some((command, argument)) = line.split_first() else {
            return Self::Unknown;
        };
        let parsed = match (command, argument) {
            (b't', text) => parse_frame::<3>(text, false)
                .and_then(|(id, data)| Frame::new(id as u16, &data))
                .map(Self::Transmit),
            (b'r', text) => parse_frame::<3>(text, true).map(|_| unheard(false)),
            (b'T', text) => parse_frame::<8>(text, false).map(|_| unheard(true)),
            (b'R', text) => parse_frame::<8>(text, true).map(|_| unheard(true)),
            (b'O', []) => Some(Self::Open),
            (b'L', []) => Some(Self::Listen),
            (b'C', []) => Some(Self::Close),
            (b'S', b"8") => Some(Self::Confirm),
            (b's', &[a, b, c, d]) => number(&[a, b, c, d])
                .filter(|registers| bit_rate(*registers) == 1_000_000)
                .map(|_| Self::Confirm),
            (b'M', b"00000000") => Some(Self::Confirm),
            (b'm', mask) if mask.eq_ignore_ascii_case(b"ffffffff") => Some(Self::Confirm),
            (b'Z', b"0") => Some(Self::TimeStamps(false)),
            (b'Z', b"1") => Some(Self::TimeStamps(true)),
            (b'V', []) => Some(Self::Version),
            (b'N', []) => Some(Self::SerialNumber),
            (b'F', []) => Some(Self::Status),
            _ => None,
        };
        parsed.unwrap_or(Self::Unknown)
    }
}

fn unheard(extended: bool) -> Request {
    Request::TransmitUnheard { extended }
}

/// Parses an identifier of three or eight digits, a length, and the data of a frame that is not
/// remote.
fn parse_frame<const DIGITS: usize>(text: &[u8], remote: bool) -> Option<(u32, Vec<u8>)> {
    let (id, rest) = text.split_first_chunk::<DIGITS>()?;
    let (length, data) = rest.split_first()?;
    let largest = if DIGITS == 3 { 0x7ff } else { 0x1fff_ffff };
    let id = number(id).filter(|id| *id <= largest)?;
    let length = number(&[*length]).filter(|length| *length <= 8)? as usize;
    if data.len() != if remote { 0 } else { 2 * length } {
        return None;
    }
    let bytes = data
        .chunks(2)
        .map(|byte| number(byte).map(|byte| byte as u8));
    Some((id, bytes.collect::<Option<_>>()?))
}

/// Parses a number of at most eight hexadecimal digits.
fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |value, digit| {
        Some(value << 4 | char::from(*digit).to_digit(16)?)
    })
}

/// Bit rate, bit/s, of the bit timing registers BTR0 (high byte) and BTR1 of an SJA1000 that counts
/// 8 MHz, as in the adapters of Lawicel: a bit has 1 + (`TSEG1` + 1) + (`TSEG2` + 1) quanta of
/// `BRP` + 1 periods.
fn bit_rate(registers: u32) -> u32 {
    let prescaler = (registers >> 8 & 0x3f) + 1;
    let quanta = 3 + (registers & 0xf) + (registers >> 4 & 7);
    8_000_000 / (prescaler * quanta)
}

/// Formats the line that carries `frame` to a client, including its carriage return. `stamp` is the
/// time of its reception, ms.
pub fn line_of(frame: &Frame, stamp: Option<u16>) -> String {
    use std::fmt::Write;
    let mut line = format!("t{:03X}{}", frame.id(), frame.data().len());
    for byte in frame.data() {
        // Writing to a string cannot fail.
        let _ = write!(line, "{byte:02X}");
    }
    if let Some(stamp) = stamp {
        let _ = write!(line, "{stamp:04X}");
    }
    line.push('\r');
    line
}
