//! One classic CAN frame with an 11-bit identifier. All bus code exchanges frames in this form.

use serde::{Deserialize, Serialize};

/// A CAN 2.0A data frame. Bytes beyond `length` are zero, so that equal frames are equal values.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Frame {
    id: u16,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// Largest identifier of a CAN 2.0A frame.
    pub const MAX_ID: u16 = 0x7ff;

    /// Creates a frame with the identifier `id` and the bytes of `data`; `None` if `id` is above
    /// [`Self::MAX_ID`] or if there are more than eight bytes.
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

    /// Returns the 11-bit identifier. The lowest identifier wins arbitration.
    pub fn id(&self) -> u16 {
        self.id
    }

    /// Returns the payload, 0 to 8 bytes.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.length.min(8))]
    }
}
