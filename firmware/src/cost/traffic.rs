//! Traffic of a busy guard, besides what it needs: the bytes of a GNSS receiver that sends all the
//! time, and the frames of another robot on the same bus.

use core::fmt::{Arguments, Write};
use heapless::String;
use tautrack::bus::network::function;
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

/// Returns the frames that another robot sends.
pub fn others() -> impl Iterator<Item = Frame> {
    const FUNCTIONS: [u16; 8] = [
        function::SYNC_OR_EMERGENCY,
        function::TPDO[0],
        function::TPDO[1],
        function::TPDO[2],
        function::RPDO[0],
        0x580,
        0x600,
        function::HEARTBEAT,
    ];
    (0_u16..).cycle().filter_map(|number| {
        // No node of the counted robots has one of these ids.
        let node = 32 + number / 8 % 64;
        Frame::new(
            FUNCTIONS[usize::from(number) % 8] + node,
            &[number as u8; 8],
        )
    })
}
