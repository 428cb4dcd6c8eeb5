//! One classic CAN frame with an 11-bit identifier: what every part of the bus code exchanges.

use serde::{Deserialize, Serialize};

/// A CAN 2.0A data frame. Bytes behind `length` are zero, so equal frames are equal values.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Frame {
    id: u16,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// Largest identifier of a CAN 2.0A frame.
    pub const MAX_ID: u16 = 0x7ff;

    /// Frame with identifier `id` and the bytes of `data`; `None` above [`Self::MAX_ID`] or for more than eight bytes.
    pub fn new(id: u16, data: &[u8]) -> Option<Self> {
        if id > Self::MAX_ID || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self {
            id,
            length: data.len() as u8,
            data: bytes,
        })
    }

    /// The 11-bit identifier; the lowest wins arbitration.
    pub fn id(&self) -> u16 {
        self.id
    }

    /// The payload, 0 to 8 bytes.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.length.min(8))]
    }
}
