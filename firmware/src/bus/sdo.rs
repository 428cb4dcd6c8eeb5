//! SDO server of the dictionary's objects (CiA 301): expedited and segmented transfers.
//!
//! A segment is read from the object when the client requests it. So an object of more than seven
//! bytes can change during a transfer; the only one that does, the window of the recording, begins
//! with its number.

use super::filter::{is_mapping, moves_an_axle};
use zencan_node::common::sdo::AbortCode;
use zencan_node::object_dict::{ODEntry, find_object_entry};

/// Longest time between two requests of one transfer, us. A client on a PC may pause for some 100
/// ms.
const TIMEOUT_US: u64 = 500_000;
/// Bits of the data of a frame.
const MAX_DATA_BITS: u32 = 64;
/// Bytes of a segment.
const SEGMENT: usize = 7;
/// Bit of a request or an answer that alternates between segments.
const TOGGLE: u8 = 0x10;

type Table = &'static [ODEntry<'static>];
type Bytes = [u8; 8];

/// The server.
#[derive(Default)]
pub struct Server {
    transfer: Option<Transfer>,
}

/// Transfer in segments that is under way.
#[derive(Clone, Copy)]
struct Transfer {
    object: &'static ODEntry<'static>,
    sub: u8,
    /// The client writes the object.
    writes: bool,
    /// Toggle bit of the next segment.
    toggle: u8,
    /// Bytes transferred up to now.
    done: usize,
    /// What the client has written. A number, the only value that can be written, has four bytes.
    written: [u8; SEGMENT],
    /// Time of the last request, us since power-up.
    requested_us: u64,
}

/// Index and sub-index of an object.
pub type Address = (u16, u8);

/// Answer of the server, and the object whose writing the request completed.
pub type Answer = (Option<Bytes>, Option<Address>);

impl Server {
    /// Answers a request. A request for a new transfer ends the one that is under way. While the
    /// guard is alive, no transfer writes an object that moves an axle, even if it began before.
    pub fn answer(
        &mut self,
        request: &Bytes,
        table: Table,
        guard_alive: bool,
        now_us: u64,
    ) -> Answer {
        let specifier = request[0] >> 5;
        let transfer = self.transfer.take();
        let address = match (specifier, transfer) {
            (0 | 3, Some(it)) => (it.object.index, it.sub),
            _ => address(request),
        };
        let result = match (specifier, transfer) {
            (4, _) => return (None, None), // the client aborts
            (0, Some(it)) if it.writes && guard_alive && moves_an_axle(it.object.index) => {
                Err(AbortCode::CantStoreDeviceState)
            }
            (0, Some(transfer)) if transfer.writes => self.write_segment(request, transfer, now_us),
            (3, Some(transfer)) if !transfer.writes => self.read_segment(request, transfer, now_us),
            (1, _) => self.write(request, table, now_us),
            (2, _) => self.read(request, table, now_us),
            _ => Err(AbortCode::InvalidCommandSpecifier),
        };
        match result {
            Ok((answer, wrote)) => (Some(answer), wrote),
            Err(code) => (
                Some(message(0x80, address, (code as u32).to_le_bytes())),
                None,
            ),
        }
    }

    /// Ends a transfer whose client sends nothing more. Returns the message that says so.
    pub fn time_out(&mut self, now_us: u64) -> Option<Bytes> {
        let late = |it: &mut Transfer| now_us.saturating_sub(it.requested_us) > TIMEOUT_US;
        let transfer = self.transfer.take_if(late)?;
        let code = (AbortCode::SdoTimeout as u32).to_le_bytes();
        Some(message(0x80, (transfer.object.index, transfer.sub), code))
    }

    fn start(&mut self, object: &'static ODEntry<'static>, sub: u8, writes: bool, now_us: u64) {
        self.transfer = Some(Transfer {
            object,
            sub,
            writes,
            toggle: 0,
            done: 0,
            written: [0; SEGMENT],
            requested_us: now_us,
        });
    }

    /// Keeps a transfer for its next segment.
    fn proceed(&mut self, transfer: Transfer, now_us: u64) {
        self.transfer = Some(Transfer {
            toggle: transfer.toggle ^ TOGGLE,
            requested_us: now_us,
            ..transfer
        });
    }

    fn write(
        &mut self,
        request: &Bytes,
        table: Table,
        now_us: u64,
    ) -> Result<(Bytes, Option<Address>), AbortCode> {
        let (object, sub) = find(request, table)?;
        let &[command, _, _, _, ref data @ ..] = request;
        let expedited = command & 0b10 != 0;
        if expedited {
            let length = if command & 0b01 != 0 {
                4 - usize::from(command >> 2 & 0b11)
            } else {
                object.data.sub_info(sub)?.size
            };
            write(object, sub, data.get(..length).unwrap_or_default())?;
        } else {
            let size_given = command & 0b01 != 0;
            let length = size_given.then_some(u32::from_le_bytes(*data) as usize);
            check(object, sub, length)?;
            self.start(object, sub, true, now_us);
        }
        let address = (object.index, sub);
        Ok((message(0x60, address, [0; 4]), expedited.then_some(address)))
    }

    fn read(
        &mut self,
        request: &Bytes,
        table: Table,
        now_us: u64,
    ) -> Result<(Bytes, Option<Address>), AbortCode> {
        let (object, sub) = find(request, table)?;
        let mut data = [0; 4];
        let size = object.data.read_size(sub)?;
        object.data.read(sub, 0, &mut data)?;
        let command = if size <= data.len() {
            0x43 | ((data.len() - size) as u8 * 4)
        } else {
            self.start(object, sub, false, now_us);
            data = (size as u32).to_le_bytes();
            0x41
        };
        Ok((message(command, (object.index, sub), data), None))
    }

    fn write_segment(
        &mut self,
        request: &Bytes,
        mut transfer: Transfer,
        now_us: u64,
    ) -> Result<(Bytes, Option<Address>), AbortCode> {
        let &[command, ref data @ ..] = request;
        alternates(command, &transfer)?;
        let length = SEGMENT - usize::from(command >> 1 & 0b111);
        let places = transfer.written.iter_mut().skip(transfer.done);
        for (place, byte) in places.zip(data.iter().take(length)) {
            *place = *byte;
        }
        transfer.done += length;
        let last = command & 1 != 0;
        if last {
            let written = transfer.written.get(..transfer.done);
            let written = written.ok_or(AbortCode::DataTypeMismatchLengthHigh)?;
            write(transfer.object, transfer.sub, written)?;
        } else {
            self.proceed(transfer, now_us);
        }
        let address = (transfer.object.index, transfer.sub);
        let answer = [0x20 | transfer.toggle, 0, 0, 0, 0, 0, 0, 0];
        Ok((answer, last.then_some(address)))
    }

    fn read_segment(
        &mut self,
        request: &Bytes,
        mut transfer: Transfer,
        now_us: u64,
    ) -> Result<(Bytes, Option<Address>), AbortCode> {
        alternates(request[0], &transfer)?;
        let Transfer { object, sub, .. } = transfer;
        let mut answer = [transfer.toggle, 0, 0, 0, 0, 0, 0, 0];
        let [command, data @ ..] = &mut answer;
        let length = object.data.read(sub, transfer.done, data)?;
        *command |= (SEGMENT - length) as u8 * 2;
        transfer.done += length;
        if transfer.done < object.data.read_size(sub)? {
            self.proceed(transfer, now_us);
        } else {
            *command |= 1;
        }
        Ok((answer, None))
    }
}

/// Index and sub-index of the object that a request for a new transfer names. A segment names none.
fn address(request: &Bytes) -> Address {
    match request {
        [0x20..0x60 | 0xa0.., low, high, sub, ..] => (u16::from_le_bytes([*low, *high]), *sub),
        _ => (0, 0),
    }
}

fn message(command: u8, (index, sub): Address, data: [u8; 4]) -> Bytes {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), data);
    [command, low, high, sub, a, b, c, d]
}

fn find(request: &Bytes, table: Table) -> Result<(&'static ODEntry<'static>, u8), AbortCode> {
    let (index, sub) = address(request);
    let object = find_object_entry(table, index).ok_or(AbortCode::NoSuchObject)?;
    Ok((object, sub))
}

/// Checks that the object can be written, with this number of bytes if it is known.
fn check(object: &ODEntry, sub: u8, length: Option<usize>) -> Result<(), AbortCode> {
    let info = object.data.sub_info(sub)?;
    if !info.access_type.is_writable() {
        return Err(AbortCode::ReadOnly);
    }
    match length {
        Some(length) if length < info.size => Err(AbortCode::DataTypeMismatchLengthLow),
        Some(length) if length > info.size => Err(AbortCode::DataTypeMismatchLengthHigh),
        _ => Ok(()),
    }
}

fn write(object: &ODEntry, sub: u8, data: &[u8]) -> Result<(), AbortCode> {
    check(object, sub, Some(data.len()))?;
    if is_mapping(object.index) && !fits_a_frame(object, sub, data)? {
        return Err(AbortCode::PdoTooLong);
    }
    object.data.write(sub, data)
}

/// Returns whether the objects of a PDO fit into a frame if `data` is written to `sub` of its
/// mapping. The low byte of an entry is the length of its object, bits.
fn fits_a_frame(mapping: &ODEntry, sub: u8, data: &[u8]) -> Result<bool, AbortCode> {
    let written = data.first().copied().unwrap_or_default();
    let low_byte = |of: u8| {
        if of == sub {
            return Ok(written);
        }
        let mut value = [0; 4];
        mapping.data.read(of, 0, &mut value)?;
        Ok(value[0])
    };
    let mut bits = 0;
    for entry in 1..=low_byte(0)? {
        bits += u32::from(low_byte(entry)?);
    }
    Ok(bits <= MAX_DATA_BITS)
}

fn alternates(command: u8, transfer: &Transfer) -> Result<(), AbortCode> {
    if command & TOGGLE == transfer.toggle {
        Ok(())
    } else {
        Err(AbortCode::ToggleNotAlternated)
    }
}
