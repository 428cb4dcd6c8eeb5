//! Process data objects (PDOs): their parameters (0x1400 to 0x1BFF) and their mapping (CiA 301).
//!
//! A PDO's places are looked up when its mapping is enabled, so that a frame costs no search.

use super::dictionary::{Abort, Address, Dictionary, PdoDefaults, Table, Value, number};
use crate::can::Frame;

/// Maximum number of objects in a PDO.
const MAX_OBJECTS: usize = 8;
/// Bits of an identifier's object: the PDO is not used; remote frames are not served; the
/// identifier has 29 bits.
const NOT_USED: u32 = 1 << 31;
const NO_REMOTE_FRAMES: u32 = 1 << 30;
const EXTENDED: u32 = 1 << 29;

/// Transmission types. Up to the first, a PDO follows SYNC.
const LAST_SYNCHRONOUS: u8 = 240;
const FIRST_EVENT_DRIVEN: u8 = 254;

/// A PDO and its parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pdo {
    receives: bool,
    id: u16,
    enabled: bool,
    kind: u8,
    count: u8,
    objects: [u32; MAX_OBJECTS],
    places: [Place; MAX_OBJECTS],
    length: u8,
    /// 0.1 ms.
    inhibit_time: u16,
    /// ms.
    event_timer: u16,
    /// SYNCs since it was sent.
    syncs: u8,
    /// What was sent last, and when, us; or what waits for the next SYNC.
    newest: Option<(Frame, u64)>,
}

/// Bytes of an object in [`Dictionary::values`] or [`Table::constants`].
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    at: u16,
    size: u8,
}

impl Pdo {
    /// A PDO that is not used.
    pub const fn unused(receives: bool) -> Self {
        Self {
            receives,
            id: 0,
            enabled: false,
            kind: FIRST_EVENT_DRIVEN,
            count: 0,
            objects: [0; MAX_OBJECTS],
            places: [Place { at: 0, size: 0 }; MAX_OBJECTS],
            length: 0,
            inhibit_time: 0,
            event_timer: 0,
            syncs: 0,
            newest: None,
        }
    }

    /// Restores the defaults.
    pub fn restore(&mut self, defaults: Option<&PdoDefaults>, node: u8, table: &Table) {
        // The count of SYNCs goes on.
        *self = Self {
            syncs: self.syncs,
            ..Self::unused(self.receives)
        };
        let Some(defaults) = defaults else {
            return;
        };
        self.id = defaults.id + u16::from(node) * u16::from(defaults.adds_node_id);
        self.kind = defaults.kind;
        for (place, object) in self.objects.iter_mut().zip(defaults.mapping) {
            *place = *object;
        }
        // The generated defaults are valid: a test maps every one.
        let mapped = self.map(defaults.mapping.len() as u8, table);
        self.enabled = defaults.enabled && mapped.is_ok();
    }

    /// Listens to this identifier.
    pub fn listen(&mut self, id: u16) {
        (self.id, self.enabled) = (id, true);
    }

    /// Whether the PDO is used and has this identifier.
    #[inline]
    pub fn is(&self, id: u16) -> bool {
        self.enabled && self.id == id
    }

    /// Whether a receive PDO takes effect with the next SYNC only.
    pub fn waits_for_sync(&self) -> bool {
        self.kind <= LAST_SYNCHRONOUS
    }

    /// Keeps a frame for the next SYNC.
    pub fn keep(&mut self, frame: Frame, now_us: u64) {
        self.newest = Some((frame, now_us));
    }

    /// Returns the frame that was kept.
    pub fn take(&mut self) -> Option<Frame> {
        self.newest.take().map(|(frame, _)| frame)
    }

    /// Whether the PDO carries no object.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Whether `data` carries all objects of the PDO.
    pub fn fits(&self, data: &[u8]) -> bool {
        data.len() >= usize::from(self.length)
    }

    /// Writes `data` to the objects of the PDO.
    pub fn store(&self, mut data: &[u8], values: &mut [u8]) {
        for place in self.places.iter().take(usize::from(self.count)) {
            let (at, size) = (usize::from(place.at), usize::from(place.size));
            let Some((value, rest)) = data.split_at_checked(size) else {
                return;
            };
            if let Some(to) = values.get_mut(at..at + size) {
                to.copy_from_slice(value);
            }
            data = rest;
        }
    }

    /// Returns the mapped objects.
    pub fn objects(&self) -> &[u32] {
        self.objects
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    fn frame(&self, dictionary: &impl Dictionary) -> Frame {
        let (mut data, mut length) = ([0; 8], 0);
        let values = dictionary.values();
        for place in self.places.iter().take(usize::from(self.count)) {
            let (at, size) = (usize::from(place.at), usize::from(place.size));
            let from = values.get(at..at + size);
            if let (Some(from), Some(to)) = (from, data.get_mut(length..length + size)) {
                to.copy_from_slice(from);
                length += size;
            }
        }
        Frame::new(self.id, data.get(..length).unwrap_or_default()).unwrap_or_default()
    }

    /// Returns the frame that a transmit PDO sends on a SYNC, if one is due.
    pub fn on_sync(&mut self, dictionary: &impl Dictionary, now_us: u64) -> Option<Frame> {
        if !self.enabled || self.kind > LAST_SYNCHRONOUS || self.length == 0 {
            return None;
        }
        if self.kind == 0 {
            let frame = self.frame(dictionary);
            let changed = self.newest.is_none_or(|(sent, _)| sent != frame);
            self.newest = Some((frame, now_us));
            return changed.then_some(frame);
        }
        self.syncs = self.syncs.wrapping_add(1);
        if self.syncs < self.kind {
            return None;
        }
        self.syncs = 0;
        Some(self.frame(dictionary))
    }

    /// Returns the frame that an event-driven transmit PDO sends, if one is due: because a value
    /// has changed, or because the event timer has run out. The inhibit time is the least time
    /// between two frames.
    pub fn on_event(&mut self, dictionary: &impl Dictionary, now_us: u64) -> Option<Frame> {
        if !self.enabled || self.kind < FIRST_EVENT_DRIVEN || self.length == 0 {
            return None;
        }
        let frame = self.frame(dictionary);
        if let Some((sent, sent_us)) = self.newest {
            let since_us = now_us.saturating_sub(sent_us);
            let timer_us = u64::from(self.event_timer) * 1_000;
            let elapsed = timer_us != 0 && since_us >= timer_us;
            let inhibited = since_us < u64::from(self.inhibit_time) * 100;
            if inhibited || sent == frame && !elapsed {
                return None;
            }
        }
        self.newest = Some((frame, now_us));
        Some(frame)
    }

    /// Enables the mapping of the first `count` objects.
    fn map(&mut self, count: u8, table: &Table) -> Result<(), Abort> {
        let mut length = 0;
        let objects = self.objects.get(..usize::from(count));
        let objects = objects.ok_or(Abort::PdoTooLong)?;
        for (object, place) in objects.iter().zip(&mut self.places) {
            *place = locate(*object, self.receives, table)?;
            length += place.size;
            if length > 8 {
                return Err(Abort::PdoTooLong);
            }
        }
        (self.count, self.length) = (count, length);
        Ok(())
    }

    fn read(&self, address: Address) -> Result<Value, Abort> {
        let mapping = address.index & 0x200 != 0;
        let not_used = if self.enabled { 0 } else { NOT_USED };
        Ok(match (mapping, address.sub) {
            (false, 0) => Value::new(if self.receives { 2 } else { 5 }, 1),
            (false, 1) if self.receives => Value::new(not_used | u32::from(self.id), 4),
            (false, 1) => Value::new(not_used | NO_REMOTE_FRAMES | u32::from(self.id), 4),
            (false, 2) => Value::new(self.kind.into(), 1),
            (false, 3) if !self.receives => Value::new(self.inhibit_time.into(), 2),
            (false, 5) if !self.receives => Value::new(self.event_timer.into(), 2),
            (true, 0) => Value::new(self.count.into(), 1),
            (true, sub) => {
                let object = self.objects.get(usize::from(sub) - 1);
                Value::new(*object.ok_or(Abort::NoSubIndex)?, 4)
            }
            _ => return Err(Abort::NoSubIndex),
        })
    }

    fn write(&mut self, address: Address, value: u32, table: &Table) -> Result<(), Abort> {
        let mapping = address.index & 0x200 != 0;
        match (mapping, address.sub) {
            (false, 0) => Err(Abort::ReadOnly),
            (false, 1) => self.write_id(value),
            (false, 2) => {
                let kind = value as u8;
                if (LAST_SYNCHRONOUS + 1..FIRST_EVENT_DRIVEN).contains(&kind) {
                    return Err(Abort::Range);
                }
                (self.kind, self.syncs, self.newest) = (kind, 0, None);
                Ok(())
            }
            (false, 3) if !self.receives && self.enabled => Err(Abort::DeviceState),
            (false, 3) if !self.receives => {
                self.inhibit_time = value as u16;
                Ok(())
            }
            (false, 5) if !self.receives => {
                self.event_timer = value as u16;
                Ok(())
            }
            (true, _) if self.enabled => Err(Abort::DeviceState),
            (true, 0) => self.map(value as u8, table),
            (true, _) if self.count > 0 => Err(Abort::DeviceState),
            (true, sub) => {
                let place = self.objects.get_mut(usize::from(sub) - 1);
                let place = place.ok_or(Abort::NoSubIndex)?;
                // An entry of 0 is empty.
                if value != 0 {
                    locate(value, self.receives, table)?;
                }
                *place = value;
                Ok(())
            }
            _ => Err(Abort::NoSubIndex),
        }
    }

    fn write_id(&mut self, value: u32) -> Result<(), Abort> {
        let enabled = value & NOT_USED == 0;
        let id = value & !(NOT_USED | NO_REMOTE_FRAMES);
        if value & EXTENDED != 0 || id > u32::from(Frame::MAX_ID) {
            return Err(Abort::Range);
        }
        let id = id as u16;
        if !self.receives && value & NO_REMOTE_FRAMES == 0 {
            return Err(Abort::Range);
        }
        if self.enabled && enabled && id != self.id {
            return Err(Abort::DeviceState);
        }
        if enabled && is_restricted(id) {
            return Err(Abort::Range);
        }
        (self.id, self.enabled, self.newest) = (id, enabled, None);
        Ok(())
    }
}

/// Identifiers that no PDO may have (CiA 301, table of restricted CAN-IDs).
fn is_restricted(id: u16) -> bool {
    matches!(
        id,
        0..=0x80 | 0x101..=0x180 | 0x581..=0x5ff | 0x601..=0x67f | 0x6e0..=0x6ff | 0x701..
    )
}

/// Returns the place of a mapped object: index, sub-index and number of bits. The dummy objects
/// 0x0002 to 0x0007 (CiA 301) are not supported.
fn locate(object: u32, receives: bool, table: &Table) -> Result<Place, Abort> {
    let address = Address {
        index: (object >> 16) as u16,
        sub: (object >> 8) as u8,
    };
    // CiA 301 has one code for an object and for a sub-index that cannot be mapped.
    let row = table.find(address).map_err(|_| Abort::NoObject)?;
    if !row.access.is_mappable(receives) || object & 0xff != u32::from(row.size) * 8 {
        return Err(Abort::NotMappable);
    }
    Ok(Place {
        at: row.place,
        size: row.size as u8,
    })
}

/// Number of the PDO that the parameter `index` belongs to, and whether it is a receive PDO.
fn number_of(index: u16) -> (usize, bool) {
    (usize::from(index & 0x1ff), index & 0x800 == 0)
}

/// Whether `index` is that of a parameter of a PDO.
pub(super) fn is_parameter(index: u16) -> bool {
    matches!(index, 0x1400..0x1c00)
}

/// All PDOs of a node.
#[derive(Clone, Debug)]
pub(super) struct Pdos {
    pub receive: [Pdo; Pdos::RECEIVE],
    pub transmit: [Pdo; Pdos::TRANSMIT],
}

impl Pdos {
    const RECEIVE: usize = 4;
    const TRANSMIT: usize = 6;

    /// PDOs of which none is used.
    pub const fn unused() -> Self {
        Self {
            receive: [Pdo::unused(true); Self::RECEIVE],
            transmit: [Pdo::unused(false); Self::TRANSMIT],
        }
    }

    /// Restores the defaults of all.
    pub fn restore(&mut self, node: u8, table: &Table) {
        let receive = self.receive.iter_mut().zip(pad(table.receive));
        let transmit = self.transmit.iter_mut().zip(pad(table.transmit));
        for (pdo, defaults) in receive.chain(transmit) {
            pdo.restore(defaults, node, table);
        }
    }

    fn get(&self, index: u16, table: &Table) -> Result<&Pdo, Abort> {
        let (number, receives) = number_of(index);
        let (all, defaults) = if receives {
            (&self.receive[..], table.receive)
        } else {
            (&self.transmit[..], table.transmit)
        };
        let known = number < defaults.len();
        all.get(number).filter(|_| known).ok_or(Abort::NoObject)
    }

    /// Reads a parameter.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn read(&self, address: Address, table: &Table) -> Result<Value, Abort> {
        self.get(address.index, table)?.read(address)
    }

    /// Writes a parameter.
    ///
    /// # Errors
    /// [`Abort`]; nothing has changed.
    pub fn write(&mut self, address: Address, value: &[u8], table: &Table) -> Result<(), Abort> {
        let size = self.read(address, table)?.bytes().len();
        match value.len() {
            length if length < size => return Err(Abort::TooShort),
            length if length > size => return Err(Abort::TooLong),
            _ => {}
        }
        let (place, receives) = number_of(address.index);
        let pdo = if receives {
            self.receive.get_mut(place)
        } else {
            self.transmit.get_mut(place)
        };
        let pdo = pdo.ok_or(Abort::NoObject)?;
        let before = *pdo;
        let written = pdo.write(address, number(value), table);
        if written.is_err() {
            *pdo = before;
        }
        written
    }
}

/// The defaults, followed by none.
fn pad(defaults: &'static [PdoDefaults]) -> impl Iterator<Item = Option<&'static PdoDefaults>> {
    defaults.iter().map(Some).chain(core::iter::repeat(None))
}
