//! CRC-32 of images and settings (the checksum of Ethernet and ZIP).

/// Remainders of the 16 values of four bits.
const TABLE: [u32; 16] = {
    let mut table = [0; 16];
    let mut value = 0;
    while value < 16 {
        let mut remainder = value as u32;
        let mut bit = 0;
        while bit < 4 {
            remainder = (remainder >> 1) ^ (0xedb8_8320 * (remainder & 1));
            bit += 1;
        }
        table[value] = remainder;
        value += 1;
    }
    table
};

/// CRC-32 of the bytes so far.
#[derive(Clone, Copy)]
pub struct Crc32(u32);

impl Crc32 {
    /// The checksum of `bytes`.
    pub fn of(bytes: &[u8]) -> Self {
        Self(u32::MAX).with(bytes)
    }

    /// Adds `bytes` at the end.
    #[must_use]
    pub fn with(mut self, bytes: &[u8]) -> Self {
        for byte in bytes {
            self.0 ^= u32::from(*byte);
            for _ in 0..2 {
                self.0 = (self.0 >> 4) ^ TABLE[(self.0 & 15) as usize];
            }
        }
        self
    }

    /// The checksum.
    pub const fn value(self) -> u32 {
        !self.0
    }
}
