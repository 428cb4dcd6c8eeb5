//! CRC-32 of images and settings pages (the checksum of Ethernet and ZIP).

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

/// Computes the CRC-32 of all `parts` in order.
pub fn crc32(parts: &[&[u8]]) -> u32 {
    let mut crc = u32::MAX;
    for part in parts {
        for byte in *part {
            crc ^= u32::from(*byte);
            for _ in 0..2 {
                crc = (crc >> 4) ^ TABLE[(crc & 15) as usize];
            }
        }
    }
    !crc
}
