//! Traffic of a busy guard, besides what it needs: the bytes of a GNSS receiver that sends all the
//! time, and frames for others.

use core::fmt::{Arguments, Write};
use heapless::String;
use tautrack::can::Frame;

/// Bytes of the receiver in one tick; 115200 baud bring 12.
pub const BYTES: usize = 16;
/// Frames of eight bytes that a bus at 1 Mbit/s can carry in one tick.
pub const FRAMES: usize = 8;

/// Returns the receiver's bytes: a GGA and an RMC sentence for each fix, without a pause.
pub fn receiver() -> impl Iterator<Item = u8> {
    (0..).flat_map(|number| fix(number).into_bytes())
}

/// Returns both sentences of a fix. The time and the last digits of the place change.
fn fix(number: u32) -> String<192> {
    let (second, hundredth) = (number / 5 % 60, number % 5 * 20);
    let noise = number * 37 % 100;
    let mut text = String::new();
    // There is room for both sentences.
    let mut add = |body: Arguments| {
        let start = text.len() + 1;
        let _ = write!(text, "${body}");
        let checksum = text.bytes().skip(start).fold(0, |sum, byte| sum ^ byte);
        let _ = write!(text, "*{checksum:02X}\r\n");
    };
    add(format_args!(
        "GPGGA,1200{second:02}.{hundredth:02},4728.704{noise:02},N,00033.792{noise:02},W,\
         4,12,0.80,40.{noise:02}3,M,48.000,M,1.0,0000"
    ));
    add(format_args!(
        "GPRMC,1200{second:02}.{hundredth:02},A,4728.704{noise:02},N,00033.792{noise:02},W,\
         0.5{noise:02},123.{noise:02},231126,0.5,W,R"
    ));
    text
}

/// Returns frames that the guard does not use: answers of its drives to a client, and frames of
/// another robot with all function codes.
pub fn others(drives: &[u8]) -> impl Iterator<Item = Frame> {
    (0..=u16::MAX).cycle().filter_map(|number| {
        let turn = number / 2;
        let id = if number % 2 == 0 {
            0x580 + u16::from(drives[usize::from(turn) % drives.len()])
        } else {
            // No node of the counted robot has one of these ids.
            (turn % 16) << 7 | (32 + turn / 16 % 64)
        };
        Frame::new(id, &[number as u8; 8])
    })
}
