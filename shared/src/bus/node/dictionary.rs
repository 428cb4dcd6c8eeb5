//! Object dictionary of a node: a constant table of its objects, and the bytes that hold their
//! values.

use core::marker::PhantomData;

/// Index and sub-index of an object.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Address {
    /// Index.
    pub index: u16,
    /// Sub-index; 0 for an object with one value.
    pub sub: u8,
}

/// Why a node refuses an SDO request: an abort code of CiA 301.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u32)]
#[allow(missing_docs)] // the names are those of CiA 301, shortened
pub enum Abort {
    ToggleNotAlternated = 0x0503_0000,
    TimedOut = 0x0504_0000,
    CommandSpecifier = 0x0504_0001,
    BlockSize = 0x0504_0002,
    SequenceNumber = 0x0504_0003,
    Crc = 0x0504_0004,
    UnsupportedAccess = 0x0601_0000,
    ReadOnly = 0x0601_0002,
    NoObject = 0x0602_0000,
    NotMappable = 0x0604_0041,
    PdoTooLong = 0x0604_0042,
    Incompatible = 0x0604_0043,
    Hardware = 0x0606_0000,
    Length = 0x0607_0010,
    TooLong = 0x0607_0012,
    TooShort = 0x0607_0013,
    NoSubIndex = 0x0609_0011,
    Range = 0x0609_0030,
    TooHigh = 0x0609_0031,
    TooLow = 0x0609_0032,
    NotStored = 0x0800_0020,
    DeviceState = 0x0800_0022,
    NoData = 0x0800_0024,
}

/// What may be done with an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Access(u8);

impl Access {
    /// Only reading.
    pub const READ: Self = Self(0);
    /// Reading and writing by SDO.
    pub const WRITE: Self = Self(1);
    /// Its value is in [`Table::constants`].
    pub const CONSTANT: Self = Self(2);

    /// Adds mapping into receive PDOs.
    #[must_use]
    pub const fn received(self) -> Self {
        Self(self.0 | 4)
    }

    /// Adds mapping into transmit PDOs.
    #[must_use]
    pub const fn transmitted(self) -> Self {
        Self(self.0 | 8)
    }

    /// Whether a client may write the object by SDO.
    pub const fn is_writable(self) -> bool {
        self.0 & 1 != 0
    }

    const fn is_constant(self) -> bool {
        self.0 & 2 != 0
    }

    /// Whether a receive PDO, or else a transmit PDO, may carry the object.
    pub const fn is_mappable(self, receive: bool) -> bool {
        self.0 & (if receive { 4 } else { 8 }) != 0
    }
}

/// One value of the dictionary.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    /// Index of the object.
    pub index: u16,
    /// First byte of the value, in [`Table::constants`] or in the bytes of [`Dictionary::values`].
    pub place: u16,
    /// Number of bytes.
    pub size: u16,
    /// Sub-index.
    pub sub: u8,
    /// What may be done with it.
    pub access: Access,
}

impl Row {
    /// Returns index and sub-index.
    pub fn address(&self) -> Address {
        Address {
            index: self.index,
            sub: self.sub,
        }
    }
}

/// Objects of a node that have places for their values, and defaults of its process data.
#[derive(Debug)]
pub struct Table {
    /// Every value, in the order of index and sub-index.
    pub rows: &'static [Row],
    /// Values that never change.
    pub constants: &'static [u8],
    /// Defaults of the receive PDOs.
    pub receive: &'static [PdoDefaults],
    /// Defaults of the transmit PDOs.
    pub transmit: &'static [PdoDefaults],
}

impl Table {
    /// Returns the row at `address`.
    ///
    /// # Errors
    /// [`Abort::NoObject`], or [`Abort::NoSubIndex`] if the object has others.
    pub fn find(&self, address: Address) -> Result<&'static Row, Abort> {
        let next = self.rows.partition_point(|row| row.address() < address);
        match self.rows.get(next) {
            Some(row) if row.address() == address => Ok(row),
            after => {
                let before = next.checked_sub(1).and_then(|last| self.rows.get(last));
                let mut near = [after, before].into_iter().flatten();
                Err(if near.any(|row| row.index == address.index) {
                    Abort::NoSubIndex
                } else {
                    Abort::NoObject
                })
            }
        }
    }
}

impl Table {
    /// Returns the number at this address among those that never change; 0 if there is none.
    pub fn constant(&self, index: u16, sub: u8) -> u32 {
        let row = self.find(Address { index, sub });
        let place = row.map_or(0, |row| usize::from(row.place));
        self.constants.get(place..place + 4).map_or(0, number)
    }
}

/// Default parameters of a PDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PdoDefaults {
    /// Identifier, without the node id if it is added.
    pub id: u16,
    /// The node id is added to the identifier.
    pub adds_node_id: bool,
    /// The PDO is used.
    pub enabled: bool,
    /// Transmission type.
    pub kind: u8,
    /// Mapped objects: index, sub-index and number of bits.
    pub mapping: &'static [u32],
}

/// A value of at most four bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Value {
    bytes: [u8; 4],
    length: u8,
}

impl Value {
    /// A number of `length` bytes, 1 to 4.
    pub fn new(number: u32, length: u8) -> Self {
        Self {
            bytes: number.to_le_bytes(),
            length,
        }
    }

    /// Returns the bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length.min(4))]
    }
}

/// Returns the number that `bytes` hold, of which the last four count.
pub fn number(bytes: &[u8]) -> u32 {
    let digits = bytes.iter().rev();
    digits.fold(0, |number, byte| number << 8 | u32::from(*byte))
}

/// The objects of a node, with their values.
pub trait Dictionary {
    /// Returns the objects in the table.
    fn table(&self) -> &'static Table;
    /// Returns the bytes that hold their values.
    fn values(&self) -> &[u8];
    /// Returns these bytes to change them.
    fn values_mut(&mut self) -> &mut [u8];

    /// Reads an object that the table does not have.
    ///
    /// # Errors
    /// [`Abort`].
    fn read(&self, address: Address) -> Result<Value, Abort>;
    /// Writes an object that the table does not have.
    ///
    /// # Errors
    /// [`Abort`]; nothing has changed.
    fn write(&mut self, address: Address, value: &[u8]) -> Result<(), Abort>;
    /// Whether [`Self::read`] and [`Self::write`] serve the object.
    fn serves(&self, index: u16) -> bool;
    /// Whether writing the object may move an axle. No client writes it under a living guard.
    fn moves(&self, index: u16) -> bool;
    /// Checks a value of the right size, before it is written by SDO.
    ///
    /// # Errors
    /// [`Abort`] for a value that the node does not support.
    fn check(&self, address: Address, value: &[u8]) -> Result<(), Abort>;

    /// Whether another node may restart the master of the network.
    fn may_restart(&self) -> bool {
        true
    }

    /// Takes note that a client has written an object of the table.
    fn written(&mut self, address: Address);
    /// Takes note that a client whose heartbeat the node watches has fallen silent.
    fn lost_client(&mut self);
    /// Takes note that a receive PDO with the identifier `id` has written its `objects` (index,
    /// sub-index and number of bits).
    fn received(&mut self, id: u16, objects: &[u32], now_us: u64);
}

/// Returns the bytes of a row's value.
pub(super) fn bytes(dictionary: &impl Dictionary, row: Row) -> &[u8] {
    let all = if row.access.is_constant() {
        dictionary.table().constants
    } else {
        dictionary.values()
    };
    let place = usize::from(row.place);
    all.get(place..place + usize::from(row.size))
        .unwrap_or_default()
}

/// A number that an object holds.
pub trait Number: Copy {
    /// Reads the number from the beginning of `bytes`; 0 if there are too few.
    fn read(bytes: &[u8]) -> Self;
    /// Writes the number to the beginning of `bytes`, if there are enough.
    fn write(self, bytes: &mut [u8]);
}

macro_rules! numbers {
    ($($kind:ty),*) => {$(
        impl Number for $kind {
            #[inline]
            fn read(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(0, |bytes| Self::from_le_bytes(*bytes))
            }

            #[inline]
            fn write(self, bytes: &mut [u8]) {
                if let Some(place) = bytes.first_chunk_mut() {
                    *place = self.to_le_bytes();
                }
            }
        }
    )*};
}
numbers!(i8, u8, i16, u16, i32, u32);

/// Place of a number of type `T`.
#[derive(Debug)]
pub struct Field<T> {
    place: u16,
    kind: PhantomData<T>,
}

impl<T> Clone for Field<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Field<T> {}

impl<T> Field<T> {
    /// The field that begins at this byte.
    pub const fn at(place: u16) -> Self {
        Self {
            place,
            kind: PhantomData,
        }
    }

    /// The field that is `number` places behind this one, in an array.
    #[must_use]
    pub const fn element(self, number: usize) -> Self {
        Self::at(self.place + (number * size_of::<T>()) as u16)
    }
}

/// Bytes with the values of a dictionary.
#[derive(Clone, Debug)]
pub struct Values<const N: usize>(pub [u8; N]);

impl<const N: usize> Values<N> {
    /// Sets the bytes at these places, and all others to 0.
    pub fn restart(&mut self, bytes: &[(u16, u8)]) {
        self.0 = [0; N];
        for (place, byte) in bytes {
            if let Some(value) = self.0.get_mut(usize::from(*place)) {
                *value = *byte;
            }
        }
    }

    /// Returns a number.
    #[inline]
    pub fn get<T: Number>(&self, field: Field<T>) -> T {
        T::read(self.0.get(usize::from(field.place)..).unwrap_or_default())
    }

    /// Changes a number.
    #[inline]
    pub fn set<T: Number>(&mut self, field: Field<T>, number: T) {
        if let Some(place) = self.0.get_mut(usize::from(field.place)..) {
            number.write(place);
        }
    }

    /// Changes the bytes from `field` on.
    pub fn set_bytes(&mut self, field: Field<u8>, bytes: &[u8]) {
        let places = self.0.iter_mut().skip(usize::from(field.place));
        for (place, byte) in places.zip(bytes) {
            *place = *byte;
        }
    }
}
