//! Objects of the dictionary as rows of a table.
//!
//! The generator of zencan, `zencan-build`, makes a type with its own functions of each object:
//! 20 KB for the 70 objects of a drive. Here all objects have one type, and numbers of all widths
//! have another.

use core::cell::RefCell;
use core::marker::PhantomData;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use zencan_node::common::objects::{AccessType, DataType, ObjectCode, PdoMappable, SubInfo};
use zencan_node::common::sdo::AbortCode;
use zencan_node::object_dict::{ObjectAccess, SubObjectAccess};

/// Number of at most 32 bits that the tasks and the bus read and write.
pub struct Number<T> {
    bits: AtomicU32,
    kind: PhantomData<T>,
}

impl<T> Number<T> {
    /// Creates a number. Only the bits of `T` count.
    pub const fn new(value: u32) -> Self {
        Self {
            bits: AtomicU32::new(value),
            kind: PhantomData,
        }
    }

    /// Where the number is, for a row.
    pub const fn place(&'static self) -> Value {
        Value::Number(&self.bits)
    }
}

macro_rules! numbers {
    ($($kind:ty),*) => {$(
        impl Number<$kind> {
            /// Returns the value.
            #[inline]
            pub fn load(&self) -> $kind {
                self.bits.load(Ordering::Relaxed) as $kind
            }

            /// Changes the value.
            #[inline]
            pub fn store(&self, value: $kind) {
                self.bits.store(value as u32, Ordering::Relaxed);
            }
        }
    )*};
}
numbers!(u8, i8, u16, i16, u32, i32);

/// Bytes that a task writes and the bus reads.
pub struct Bytes<const N: usize>(Mutex<RefCell<[u8; N]>>);

impl<const N: usize> Bytes<N> {
    /// Creates bytes of value 0.
    pub const fn zeros() -> Self {
        Self(Mutex::new(RefCell::new([0; N])))
    }

    /// Replaces all bytes at once.
    pub fn store(&self, value: [u8; N]) {
        critical_section::with(|cs| self.0.replace(cs, value));
    }
}

impl<const N: usize> SubObjectAccess for Bytes<N> {
    fn read(&self, offset: usize, buffer: &mut [u8]) -> Result<usize, AbortCode> {
        // Cannot fail: the critical section excludes any other borrow.
        critical_section::with(|cs| match self.0.borrow(cs).try_borrow() {
            Ok(bytes) => Ok(copy(&*bytes, offset, buffer)),
            Err(_) => Err(AbortCode::GeneralError),
        })
    }

    fn read_size(&self) -> usize {
        N
    }

    fn write(&self, _: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::ReadOnly)
    }
}

/// Bytes that never change.
pub struct Constant(pub &'static [u8]);

impl SubObjectAccess for Constant {
    fn read(&self, offset: usize, buffer: &mut [u8]) -> Result<usize, AbortCode> {
        Ok(copy(self.0, offset, buffer))
    }

    fn read_size(&self) -> usize {
        self.0.len()
    }

    fn write(&self, _: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::ReadOnly)
    }
}

/// Where a sub-index has its value.
#[derive(Clone, Copy)]
pub enum Value {
    /// Number whose length follows from the row's data type.
    Number(&'static AtomicU32),
    /// Bytes that the bus can only read.
    Bytes(&'static dyn SubObjectAccess),
}

/// Row of an object: one sub-index.
#[derive(Clone, Copy)]
pub struct Row {
    /// The sub-index.
    pub number: u8,
    /// What a client may do.
    pub access: AccessType,
    /// Which process data may contain it.
    pub mapping: PdoMappable,
    /// Code of the data type after CiA 301.
    pub data_type: u8,
    /// The value.
    pub value: Value,
}

impl Row {
    /// Length of the value, bytes.
    fn size(&self) -> usize {
        match self.value {
            Value::Bytes(bytes) => bytes.read_size(),
            Value::Number(_) => match self.data_type() {
                DataType::Int8 | DataType::UInt8 => 1,
                DataType::Int16 | DataType::UInt16 => 2,
                _ => 4,
            },
        }
    }

    fn data_type(&self) -> DataType {
        u16::from(self.data_type).into()
    }

    fn read(&self, offset: usize, buffer: &mut [u8]) -> Result<usize, AbortCode> {
        match self.value {
            Value::Bytes(bytes) => bytes.read(offset, buffer),
            Value::Number(number) => {
                let bytes = number.load(Ordering::Relaxed).to_le_bytes();
                let bytes = bytes.get(..self.size()).unwrap_or_default();
                Ok(copy(bytes, offset, buffer))
            }
        }
    }

    fn write(&self, data: &[u8]) -> Result<(), AbortCode> {
        let Value::Number(number) = self.value else {
            return Err(AbortCode::ReadOnly);
        };
        if data.len() < self.size() {
            return Err(AbortCode::DataTypeMismatchLengthLow);
        }
        if data.len() > self.size() {
            return Err(AbortCode::DataTypeMismatchLengthHigh);
        }
        let bytes = data.iter().rev();
        let bits = bytes.fold(0, |bits, byte| bits << 8 | u32::from(*byte));
        number.store(bits, Ordering::Relaxed);
        Ok(())
    }
}

/// Copies what `buffer` holds of `bytes` from `offset` on. Returns the number of bytes.
fn copy(bytes: &[u8], offset: usize, buffer: &mut [u8]) -> usize {
    let rest = bytes.get(offset..).unwrap_or_default();
    let places = buffer.iter_mut().zip(rest);
    places.map(|(place, byte)| *place = *byte).count()
}

/// One object of a dictionary.
pub struct Object {
    /// Kind of object after CiA 301.
    pub code: ObjectCode,
    /// Its sub-indices.
    pub rows: &'static [Row],
}

impl Object {
    fn row(&self, sub: u8) -> Result<&Row, AbortCode> {
        let mut rows = self.rows.iter();
        rows.find(|row| row.number == sub)
            .ok_or(AbortCode::NoSuchSubIndex)
    }
}

impl ObjectAccess for Object {
    fn read(&self, sub: u8, offset: usize, buffer: &mut [u8]) -> Result<usize, AbortCode> {
        let row = self.row(sub)?;
        if !row.access.is_readable() {
            return Err(AbortCode::WriteOnly);
        }
        row.read(offset, buffer)
    }

    fn read_size(&self, sub: u8) -> Result<usize, AbortCode> {
        self.row(sub).map(Row::size)
    }

    fn write(&self, sub: u8, data: &[u8]) -> Result<(), AbortCode> {
        let row = self.row(sub)?;
        if !row.access.is_writable() {
            return Err(AbortCode::ReadOnly);
        }
        row.write(data)
    }

    fn object_code(&self) -> ObjectCode {
        self.code
    }

    fn sub_info(&self, sub: u8) -> Result<SubInfo, AbortCode> {
        self.row(sub).map(|row| SubInfo {
            size: row.size(),
            data_type: row.data_type(),
            access_type: row.access,
            pdo_mapping: row.mapping,
            persist: false,
        })
    }
}
