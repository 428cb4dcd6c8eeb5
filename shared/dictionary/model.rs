//! The object dictionary of one role as data. `load.rs` builds it, and the generators of code, EDS
//! files and pages read it.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::RangeInclusive;

/// The object dictionary of one role.
#[derive(Debug)]
pub struct Dictionary {
    /// Name of the role.
    pub role: String,
    /// What the node says about itself.
    pub device: Device,
    /// PDOs that the node receives, by number. `None` has no default and is not in use.
    pub rpdos: Vec<Option<Pdo>>,
    /// PDOs that the node sends, by number. `None` has no default and is not in use.
    pub tpdos: Vec<Option<Pdo>>,
    /// All objects, in the order of their indices. The objects of the settings are not among them.
    pub objects: Vec<Object>,
    /// Names and types of the variables in the expressions [`Entry::value`].
    pub publish: BTreeMap<String, String>,
}

/// What a node says about itself, and how many PDOs it has.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// Number of the device profile, and the kind of device in the high 16 bits (object 1000).
    pub profile: u32,
    /// Name of the device (object 1008).
    pub name: String,
    /// Version of the hardware (object 1009).
    pub hardware_version: String,
    /// Version of the program (object 100A).
    pub software_version: String,
    /// Period of the heartbeat, ms (object 1017).
    pub heartbeat_period: u16,
    /// Number of the vendor (object 1018:1).
    pub vendor_id: u32,
    /// Number of the product (object 1018:2).
    pub product_code: u32,
    /// Revision of the product (object 1018:3).
    pub revision_number: u32,
    /// Number of PDOs that the node can receive.
    pub rpdos: u8,
    /// Number of PDOs that the node can send.
    pub tpdos: u8,
    /// The node starts the other nodes of the bus.
    #[serde(default)]
    pub nmt_master: bool,
}

/// Defaults of one PDO.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pdo {
    /// Identifier of the frame.
    pub cob_id: u32,
    /// The node's id is added to `cob_id`.
    pub add_node_id: bool,
    /// The PDO is in use after start.
    pub enabled: bool,
    /// When the frame is sent or used (`CiA` 301): 1 to 240 with each n-th SYNC, 255 at once.
    pub transmission_type: u8,
    /// Name of the payload's type in `bus::pdo`. A PDO that receives another node's has none.
    #[serde(default)]
    pub payload: String,
    /// What the payload is.
    #[serde(default)]
    pub meaning: String,
    /// The mapped entries, in the order of the frame.
    pub mappings: Vec<Mapped>,
}

/// An entry that is mapped into a PDO.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mapped {
    /// Index of the object.
    pub index: u16,
    /// Sub-index of the entry.
    pub sub: u8,
    /// Size of its value, bits.
    pub size: u8,
    /// Field of the payload.
    #[serde(default)]
    pub field: String,
    /// What the field holds.
    #[serde(default)]
    pub meaning: String,
}

impl Dictionary {
    /// The PDOs with a payload, in the order of their numbers, first those that are received.
    pub fn payloads(&self) -> impl Iterator<Item = &Pdo> {
        let pdos = self.rpdos.iter().chain(&self.tpdos).flatten();
        pdos.filter(|pdo| !pdo.payload.is_empty())
    }
}

impl Mapped {
    /// The value of the PDO's mapping parameter.
    pub fn value(&self) -> u32 {
        u32::from(self.index) << 16 | u32::from(self.sub) << 8 | u32::from(self.size)
    }
}

/// One object.
#[derive(Debug)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// Name.
    pub name: String,
    /// What it consists of.
    pub code: ObjectCode,
    /// All entries: that with sub-index 0 of a variable; sub-index 0 and the elements of arrays and
    /// records.
    pub entries: Vec<Entry>,
}

impl Object {
    /// Returns an array or a record with these elements, and sub-index 0 in front of them.
    pub fn with_elements(index: u16, name: &str, code: ObjectCode, elements: Vec<Entry>) -> Self {
        let highest = elements.iter().map(|element| element.sub_index).max();
        let highest = DefaultValue::Number(highest.unwrap_or(0).into());
        let name_of_first = "Highest sub-index supported";
        let first = Entry::new(0, name_of_first, DataType::UInt8, Access::Const, highest);
        Self {
            index,
            name: name.to_owned(),
            code,
            entries: std::iter::once(first).chain(elements).collect(),
        }
    }

    /// The entries that hold data: all but sub-index 0 of arrays and records.
    pub fn elements(&self) -> &[Entry] {
        match self.code {
            ObjectCode::Var => &self.entries,
            ObjectCode::Array | ObjectCode::Record => &self.entries[1..],
        }
    }

    /// Whether the elements differ only in their sub-indices: those of an array without names of
    /// their own.
    pub fn is_uniform(&self) -> bool {
        let numbered = |element: &Entry| element.field == Entry::numbered(element.sub_index);
        self.code == ObjectCode::Array && self.elements().iter().all(numbered)
    }
}

/// What an object consists of (`CiA` 301).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum ObjectCode {
    /// One value.
    Var,
    /// Values of one type.
    Array,
    /// Values of several types.
    Record,
}

/// A value of an object, with its own sub-index.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Sub-index.
    pub sub_index: u8,
    /// Name. That of a variable is the object's.
    pub name: String,
    /// Name of its field in the generated code.
    pub field: String,
    /// Type of the value.
    pub data_type: DataType,
    /// What other nodes may do with the value.
    pub access: Access,
    /// Whether PDOs can contain the value.
    pub pdo_mapping: PdoMapping,
    /// Value at start.
    pub default: DefaultValue,
    /// Smallest and largest value that the node accepts; `None` if it accepts every value of the
    /// type.
    pub limits: Option<[i64; 2]>,
    /// What the value means, as a sentence of a page.
    pub meaning: Option<String>,
    /// Expression with one of the variables [`Dictionary::publish`], from which the program writes
    /// the value.
    pub value: Option<String>,
}

impl Entry {
    /// Returns an entry that no PDO contains, without limits, meaning and expression.
    pub fn new(
        sub_index: u8,
        name: &str,
        data_type: DataType,
        access: Access,
        default: DefaultValue,
    ) -> Self {
        Self {
            sub_index,
            name: name.to_owned(),
            field: Self::numbered(sub_index),
            data_type,
            access,
            pdo_mapping: PdoMapping::None,
            default,
            limits: None,
            meaning: None,
            value: None,
        }
    }

    /// Field of an entry without a name of its own.
    pub fn numbered(sub_index: u8) -> String {
        format!("sub{sub_index}")
    }
}

/// Type of a value.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "String")]
pub enum DataType {
    /// Signed integer of 8 bits.
    Int8,
    /// Signed integer of 16 bits.
    Int16,
    /// Signed integer of 32 bits.
    Int32,
    /// Unsigned integer of 8 bits.
    UInt8,
    /// Unsigned integer of 16 bits.
    UInt16,
    /// Unsigned integer of 32 bits.
    UInt32,
    /// Text.
    VisibleString,
    /// This number of bytes.
    OctetString(usize),
}

impl DataType {
    /// Code of the type (`CiA` 301).
    pub fn code(self) -> u16 {
        match self {
            Self::Int8 => 2,
            Self::Int16 => 3,
            Self::Int32 => 4,
            Self::UInt8 => 5,
            Self::UInt16 => 6,
            Self::UInt32 => 7,
            Self::VisibleString => 9,
            Self::OctetString(_) => 10,
        }
    }

    /// Smallest and largest value of an integer; `None` for strings.
    pub fn bounds(self) -> Option<RangeInclusive<i64>> {
        Some(match self {
            Self::Int8 => i8::MIN.into()..=i8::MAX.into(),
            Self::Int16 => i16::MIN.into()..=i16::MAX.into(),
            Self::Int32 => i32::MIN.into()..=i32::MAX.into(),
            Self::UInt8 => 0..=u8::MAX.into(),
            Self::UInt16 => 0..=u16::MAX.into(),
            Self::UInt32 => 0..=u32::MAX.into(),
            Self::VisibleString | Self::OctetString(_) => return None,
        })
    }
}

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Int8 => f.write_str("int8"),
            Self::Int16 => f.write_str("int16"),
            Self::Int32 => f.write_str("int32"),
            Self::UInt8 => f.write_str("uint8"),
            Self::UInt16 => f.write_str("uint16"),
            Self::UInt32 => f.write_str("uint32"),
            Self::VisibleString => f.write_str("visiblestring"),
            Self::OctetString(length) => write!(f, "octetstring({length})"),
        }
    }
}

impl TryFrom<String> for DataType {
    type Error = String;

    /// Reads what [`fmt::Display`] writes.
    fn try_from(words: String) -> Result<Self, String> {
        let octets = words.strip_prefix("octetstring(");
        let octets = octets.and_then(|rest| rest.strip_suffix(')')?.parse().ok());
        let types = [
            Self::Int8,
            Self::Int16,
            Self::Int32,
            Self::UInt8,
            Self::UInt16,
            Self::UInt32,
            Self::VisibleString,
        ];
        let mut types = types.into_iter().chain(octets.map(Self::OctetString));
        types
            .find(|data_type| data_type.to_string() == words)
            .ok_or_else(|| format!("`{words}` is no data type"))
    }
}

/// What other nodes may do with a value.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum Access {
    /// They read it.
    Ro,
    /// They read and write it.
    Rw,
    /// They read it, and it never changes.
    Const,
}

/// PDOs that can contain a value.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum PdoMapping {
    /// No PDO.
    None,
    /// PDOs that the node receives.
    Rpdo,
    /// PDOs that the node sends.
    Tpdo,
}

/// Value of an entry at start.
#[derive(Clone, Debug, PartialEq)]
pub enum DefaultValue {
    /// An integer.
    Number(i64),
    /// A string.
    Text(String),
    /// An integer whose bits have meanings: a COB-ID or a mapped entry.
    Bits {
        /// The integer.
        value: u32,
        /// The node's id is added to it.
        add_node_id: bool,
    },
}
