//! SDO server (CiA 301): expedited, segmented and block transfers of all objects of a node.
//!
//! A segment is read from the object when the client requests it. So an object of more than seven
//! bytes can change during a transfer; the only one that does, the window of the recording, begins
//! with its number.

use super::communication::Communication;
use super::dictionary::{Abort, Address, Dictionary, Row, Value, bytes};
use super::process_data::{self, Pdos};

/// Longest time between two requests of one transfer, us. A client on a PC may pause for some 100
/// ms.
const TIMEOUT_US: u64 = 500_000;
/// Bytes of a segment.
const SEGMENT: usize = 7;
/// Bit of a request or an answer that alternates between segments.
const TOGGLE: u8 = 0x10;
/// Bit of a request for a block transfer: the client computes checksums.
const CHECKSUM: u8 = 4;
/// Most segments in a block.
const MAX_BLOCK: u8 = 127;
/// Segments of a block that one tick sends.
const SEGMENTS_PER_TICK: usize = 8;

type Bytes = [u8; 8];

/// The objects that the server reads and writes.
pub(super) struct Objects<'a, D> {
    pub dictionary: &'a mut D,
    pub pdos: &'a mut Pdos,
    pub communication: &'a mut Communication,
    /// The guard is alive, so no client writes what moves an axle.
    pub guarded: bool,
}

/// Where the value of an object is.
enum Source {
    Row(&'static Row),
    Value(Value),
}

impl<D: Dictionary> Objects<'_, D> {
    fn source(&self, address: Address) -> Result<Source, Abort> {
        let (index, table) = (address.index, self.dictionary.table());
        if Communication::serves(index) {
            return self.communication.read(address).map(Source::Value);
        }
        if process_data::is_parameter(index) {
            return self.pdos.read(address, table).map(Source::Value);
        }
        if self.dictionary.serves(index) {
            return self.dictionary.read(address).map(Source::Value);
        }
        table.find(address).map(Source::Row)
    }

    fn size(&self, address: Address) -> Result<usize, Abort> {
        Ok(match self.source(address)? {
            Source::Row(row) => row.size.into(),
            Source::Value(value) => value.bytes().len(),
        })
    }

    /// Copies the value from byte `offset` on to `to`. Returns the number of bytes.
    fn read(&self, address: Address, offset: usize, to: &mut [u8]) -> Result<usize, Abort> {
        let source = self.source(address)?;
        let value = match &source {
            Source::Row(row) => bytes(self.dictionary, **row),
            Source::Value(value) => value.bytes(),
        };
        let rest = value.get(offset..).unwrap_or_default();
        let places = to.iter_mut().zip(rest);
        Ok(places.map(|(place, byte)| *place = *byte).count())
    }

    /// Checks that a client may write the object, with this number of bytes if it is known.
    fn check(&self, address: Address, length: Option<usize>) -> Result<(), Abort> {
        if self.guarded && self.dictionary.moves(address.index) {
            return Err(Abort::DeviceState);
        }
        let source = match self.source(address) {
            // What the history does not have cannot be written either.
            Err(Abort::NoData) => return Err(Abort::ReadOnly),
            source => source?,
        };
        let writable = match source {
            Source::Row(row) => row.access.is_writable(),
            Source::Value(_) => {
                !Communication::serves(address.index) || Communication::is_writable(address)
            }
        };
        if !writable {
            return Err(Abort::ReadOnly);
        }
        let size = self.size(address)?;
        match length {
            Some(length) if length < size => Err(Abort::TooShort),
            Some(length) if length > size => Err(Abort::TooLong),
            _ => Ok(()),
        }
    }

    fn write(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        self.check(address, Some(value.len()))?;
        let table = self.dictionary.table();
        match self.source(address)? {
            Source::Value(_) if Communication::serves(address.index) => {
                self.communication.write(address, value)
            }
            Source::Value(_) if process_data::is_parameter(address.index) => {
                self.pdos.write(address, value, table)
            }
            Source::Value(_) => self.dictionary.write(address, value),
            Source::Row(row) => {
                self.dictionary.check(address, value)?;
                let place = usize::from(row.place);
                let places = self.dictionary.values_mut().get_mut(place..);
                for (place, byte) in places.into_iter().flatten().zip(value) {
                    *place = *byte;
                }
                self.dictionary.written(address);
                Ok(())
            }
        }
    }
}

/// Transfer that is under way.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    address: Address,
    stage: Stage,
    /// The client computes the checksum of a block transfer, too.
    checksum: bool,
    /// Bytes transferred and acknowledged up to now.
    done: usize,
    /// What the client has written. A number, the only value that can be written, has four bytes.
    written: [u8; SEGMENT],
    /// Time of the last request, us since power-up.
    requested_us: u64,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// Segments from the server, or to it, with the toggle bit of the next one.
    Read(u8),
    Write(u8),
    /// The client has not yet asked for the first block of this many segments.
    BlockOffered(u8),
    /// Segments of a block, of which `sent` are sent.
    BlockRead {
        size: u8,
        sent: u8,
    },
    /// The client confirms the end.
    BlockReadEnds,
    /// Segments of a block from the client.
    BlockWrite,
    /// The client says how many bytes count.
    BlockWriteEnds,
}

/// The server.
#[derive(Clone, Debug, Default)]
pub(super) struct Server {
    transfer: Option<Transfer>,
}

impl Server {
    /// Answers a request. A request for a new transfer ends the one that is under way.
    pub fn answer<D: Dictionary>(
        &mut self,
        request: &Bytes,
        objects: &mut Objects<'_, D>,
        now_us: u64,
    ) -> Option<Bytes> {
        let mut transfer = self.transfer.take();
        if let Some(transfer) = &mut transfer {
            transfer.requested_us = now_us;
        }
        if let Some(transfer) = transfer
            && transfer.stage == Stage::BlockWrite
            && request[0] != 0x80
        {
            return self.take_segment_of_block(request, transfer);
        }
        let (specifier, command) = (request[0] >> 5, request[0] & 0x1f);
        let block_ends = specifier == 6 && command & 1 != 0;
        let address = match transfer {
            Some(it) if matches!(specifier, 0 | 3) => it.address,
            Some(it) if block_ends && it.stage == Stage::BlockWriteEnds => it.address,
            _ => address_in(request),
        };
        let result = match (specifier, transfer.map(|it| (it, it.stage))) {
            (4, _) => return None, // the client aborts
            (0, Some((it, Stage::Write(toggle)))) => {
                self.write_segment(request, it, toggle, objects)
            }
            (3, Some((it, Stage::Read(toggle)))) => self.read_segment(request, it, toggle, objects),
            (1, _) => self.write(request, address, objects, now_us),
            (2, _) => self.read(address, objects, now_us),
            (5, _) if command & 3 == 0 => self.offer_block(request, address, objects, now_us),
            (5, Some((it, stage))) => return self.continue_block(request, it, stage, objects),
            (6, _) if !block_ends => self.begin_block(request, address, objects, now_us),
            (6, Some((it, Stage::BlockWriteEnds))) => write_block(request, &it, objects),
            _ => Err(Abort::CommandSpecifier),
        };
        Some(result.unwrap_or_else(|abort| aborted(address, abort)))
    }

    /// Ends a transfer whose client sends nothing more. Returns the message that says so.
    pub fn time_out(&mut self, now_us: u64) -> Option<Bytes> {
        let late = |it: &mut Transfer| now_us.saturating_sub(it.requested_us) > TIMEOUT_US;
        let transfer = self.transfer.take_if(late)?;
        Some(aborted(transfer.address, Abort::TimedOut))
    }

    /// Returns the next segments of a block, those of one tick.
    pub fn segments<D: Dictionary>(
        &mut self,
        objects: &Objects<'_, D>,
    ) -> heapless::Vec<Bytes, SEGMENTS_PER_TICK> {
        let mut segments = heapless::Vec::new();
        let Some(transfer) = &mut self.transfer else {
            return segments;
        };
        let Stage::BlockRead { size, sent } = &mut transfer.stage else {
            return segments;
        };
        let Ok(length) = objects.size(transfer.address) else {
            return segments;
        };
        while *sent < *size && !segments.is_full() {
            let offset = transfer.done + usize::from(*sent) * SEGMENT;
            if offset >= length {
                break;
            }
            *sent += 1;
            let mut segment = [*sent, 0, 0, 0, 0, 0, 0, 0];
            let [number, data @ ..] = &mut segment;
            // Cannot fail: its size was read.
            let _ = objects.read(transfer.address, offset, data);
            if offset + SEGMENT >= length {
                *number |= 0x80;
            }
            let _ = segments.push(segment);
        }
        segments
    }

    fn begin(&mut self, address: Address, stage: Stage, checksum: bool, now_us: u64) {
        self.transfer = Some(Transfer {
            address,
            stage,
            checksum,
            done: 0,
            written: [0; SEGMENT],
            requested_us: now_us,
        });
    }

    fn write<D: Dictionary>(
        &mut self,
        request: &Bytes,
        address: Address,
        objects: &mut Objects<'_, D>,
        now_us: u64,
    ) -> Result<Bytes, Abort> {
        let &[command, _, _, _, ref data @ ..] = request;
        let size_given = command & 0b01 != 0;
        if command & 0b10 != 0 {
            let length = if size_given {
                4 - usize::from(command >> 2 & 0b11)
            } else {
                objects.check(address, None)?;
                objects.size(address)?
            };
            objects.write(address, data.get(..length).ok_or(Abort::TooShort)?)?;
        } else {
            let length = size_given.then_some(u32::from_le_bytes(*data) as usize);
            objects.check(address, length)?;
            self.begin(address, Stage::Write(0), false, now_us);
        }
        Ok(message(0x60, address, [0; 4]))
    }

    fn read<D: Dictionary>(
        &mut self,
        address: Address,
        objects: &Objects<'_, D>,
        now_us: u64,
    ) -> Result<Bytes, Abort> {
        let mut data = [0; 4];
        let size = objects.size(address)?;
        objects.read(address, 0, &mut data)?;
        let command = if size <= data.len() {
            0x43 | ((data.len() - size) as u8 * 4)
        } else {
            self.begin(address, Stage::Read(0), false, now_us);
            data = (size as u32).to_le_bytes();
            0x41
        };
        Ok(message(command, address, data))
    }

    fn write_segment<D: Dictionary>(
        &mut self,
        request: &Bytes,
        mut transfer: Transfer,
        toggle: u8,
        objects: &mut Objects<'_, D>,
    ) -> Result<Bytes, Abort> {
        let &[command, ref data @ ..] = request;
        if command & TOGGLE != toggle {
            return Err(Abort::ToggleNotAlternated);
        }
        transfer.append(data.get(..SEGMENT - usize::from(command >> 1 & 0b111)));
        if command & 1 == 0 {
            transfer.stage = Stage::Write(toggle ^ TOGGLE);
            self.transfer = Some(transfer);
        } else {
            let written = transfer.written.get(..transfer.done);
            objects.write(transfer.address, written.ok_or(Abort::TooLong)?)?;
        }
        Ok([0x20 | toggle, 0, 0, 0, 0, 0, 0, 0])
    }

    fn read_segment<D: Dictionary>(
        &mut self,
        request: &Bytes,
        mut transfer: Transfer,
        toggle: u8,
        objects: &Objects<'_, D>,
    ) -> Result<Bytes, Abort> {
        let address = transfer.address;
        if request[0] & TOGGLE != toggle {
            return Err(Abort::ToggleNotAlternated);
        }
        let mut answer = [toggle, 0, 0, 0, 0, 0, 0, 0];
        let [command, data @ ..] = &mut answer;
        let length = objects.read(address, transfer.done, data)?;
        *command |= (SEGMENT - length) as u8 * 2;
        transfer.done += length;
        if transfer.done < objects.size(address)? {
            transfer.stage = Stage::Read(toggle ^ TOGGLE);
            self.transfer = Some(transfer);
        } else {
            *command |= 1;
        }
        Ok(answer)
    }

    /// Answers a request to read in blocks.
    fn offer_block<D: Dictionary>(
        &mut self,
        request: &Bytes,
        address: Address,
        objects: &Objects<'_, D>,
        now_us: u64,
    ) -> Result<Bytes, Abort> {
        let size = objects.size(address)?;
        let (block, threshold) = (request[4], request[5]);
        if !(1..=MAX_BLOCK).contains(&block) {
            return Err(Abort::BlockSize);
        }
        if threshold != 0 && size <= usize::from(threshold) {
            return self.read(address, objects, now_us);
        }
        let checksum = request[0] & CHECKSUM != 0;
        self.begin(address, Stage::BlockOffered(block), checksum, now_us);
        // With a checksum (bit 2) and the size (bit 1).
        Ok(message(0xc6, address, (size as u32).to_le_bytes()))
    }

    /// Follows a client that reads in blocks.
    fn continue_block<D: Dictionary>(
        &mut self,
        request: &Bytes,
        mut transfer: Transfer,
        stage: Stage,
        objects: &Objects<'_, D>,
    ) -> Option<Bytes> {
        let refused = |abort| Some(aborted(transfer.address, abort));
        match (request[0] & 3, stage) {
            (3, Stage::BlockOffered(size)) => {
                transfer.stage = Stage::BlockRead { size, sent: 0 };
                self.transfer = Some(transfer);
                None
            }
            (2, Stage::BlockRead { sent, .. }) => {
                let (acknowledged, block) = (request[1], request[2]);
                if acknowledged > sent {
                    return refused(Abort::SequenceNumber);
                }
                if !(1..=MAX_BLOCK).contains(&block) {
                    return refused(Abort::BlockSize);
                }
                let Ok(size) = objects.size(transfer.address) else {
                    return refused(Abort::NoObject);
                };
                transfer.done += usize::from(acknowledged) * SEGMENT;
                let ends = transfer.done >= size;
                transfer.stage = if ends {
                    Stage::BlockReadEnds
                } else {
                    Stage::BlockRead {
                        size: block,
                        sent: 0,
                    }
                };
                self.transfer = Some(transfer);
                ends.then(|| {
                    let unused = (SEGMENT - size % SEGMENT) % SEGMENT;
                    let checksum = if transfer.checksum {
                        checksum_of(transfer.address, objects)
                    } else {
                        0
                    };
                    let [low, high] = checksum.to_le_bytes();
                    [0xc1 | (unused as u8) << 2, low, high, 0, 0, 0, 0, 0]
                })
            }
            (1, Stage::BlockReadEnds) => None,
            _ => refused(Abort::CommandSpecifier),
        }
    }

    /// Answers a request to write in blocks.
    fn begin_block<D: Dictionary>(
        &mut self,
        request: &Bytes,
        address: Address,
        objects: &Objects<'_, D>,
        now_us: u64,
    ) -> Result<Bytes, Abort> {
        let &[command, _, _, _, ref data @ ..] = request;
        let length = (command & 2 != 0).then_some(u32::from_le_bytes(*data) as usize);
        objects.check(address, length)?;
        let checksum = command & CHECKSUM != 0;
        self.begin(address, Stage::BlockWrite, checksum, now_us);
        Ok(message(0xa4, address, [MAX_BLOCK, 0, 0, 0]))
    }

    /// Takes a segment of a block. All that can be written fits into the first one. The answer
    /// waits for the end of the block, because until then the client sends segments, no requests.
    fn take_segment_of_block(&mut self, request: &Bytes, mut transfer: Transfer) -> Option<Bytes> {
        let &[number, ref data @ ..] = request;
        let (number, last) = (number & 0x7f, number & 0x80 != 0);
        if number == 1 {
            transfer.done = 0;
            transfer.append(Some(data));
        }
        let acknowledged = match (number, last) {
            (0, _) => return Some(aborted(transfer.address, Abort::SequenceNumber)),
            (1, true) => {
                transfer.stage = Stage::BlockWriteEnds;
                1
            }
            (MAX_BLOCK, _) | (_, true) if transfer.done > 0 => {
                return Some(aborted(transfer.address, Abort::TooLong));
            }
            // The first segment is lost: the client sends the block again.
            (MAX_BLOCK, _) | (_, true) => 0,
            _ => {
                self.transfer = Some(transfer);
                return None;
            }
        };
        self.transfer = Some(transfer);
        Some([0xa2, acknowledged, MAX_BLOCK, 0, 0, 0, 0, 0])
    }
}

impl Transfer {
    fn append(&mut self, data: Option<&[u8]>) {
        let data = data.unwrap_or_default();
        let places = self.written.iter_mut().skip(self.done);
        for (place, byte) in places.zip(data) {
            *place = *byte;
        }
        self.done += data.len();
    }
}

/// Writes what a client has sent in a block.
fn write_block<D: Dictionary>(
    request: &Bytes,
    transfer: &Transfer,
    objects: &mut Objects<'_, D>,
) -> Result<Bytes, Abort> {
    let unused = usize::from(request[0] >> 2 & 7);
    let written = transfer.written.get(..SEGMENT - unused).unwrap_or_default();
    let checksum = u16::from_le_bytes([request[1], request[2]]);
    if transfer.checksum && written.iter().fold(0, checked) != checksum {
        return Err(Abort::Crc);
    }
    objects.write(transfer.address, written)?;
    Ok([0xa1, 0, 0, 0, 0, 0, 0, 0])
}

/// Checksum of an object's value: CRC-16 with the polynomial 0x1021 and the start value 0.
fn checksum_of<D: Dictionary>(address: Address, objects: &Objects<'_, D>) -> u16 {
    let (mut sum, mut offset, mut data) = (0, 0, [0; SEGMENT]);
    while let Ok(length @ 1..) = objects.read(address, offset, &mut data) {
        sum = data.iter().take(length).fold(sum, checked);
        offset += length;
    }
    sum
}

fn checked(sum: u16, byte: &u8) -> u16 {
    (0..8).fold(sum ^ u16::from(*byte) << 8, |sum, _| {
        let carry = sum & 0x8000 != 0;
        sum << 1 ^ if carry { 0x1021 } else { 0 }
    })
}

/// Index and sub-index of the object that a request for a new transfer names. A segment names none.
fn address_in(request: &Bytes) -> Address {
    match request {
        [0x20..0x60 | 0xa0.., low, high, sub, ..] => Address {
            index: u16::from_le_bytes([*low, *high]),
            sub: *sub,
        },
        _ => Address { index: 0, sub: 0 },
    }
}

fn message(command: u8, address: Address, data: [u8; 4]) -> Bytes {
    let ([low, high], [a, b, c, d]) = (address.index.to_le_bytes(), data);
    [command, low, high, address.sub, a, b, c, d]
}

fn aborted(address: Address, abort: Abort) -> Bytes {
    message(0x80, address, (abort as u32).to_le_bytes())
}
