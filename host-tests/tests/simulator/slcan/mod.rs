//! Tests of clients that use SLCAN to take part in the bus: `channel` is the protocol, `port` its
//! connections over TCP.

mod channel;
mod port;

use tautrack::can::Frame;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}
