//! TCP port for SLCAN clients. Each CAN client that connects is one more participant of the virtual
//! bus.
//!
//! SLCAN is the line protocol of serial CAN adapters (LAWICEL CAN232 and CANUSB manuals):
//! `t1232AABB\r` is a frame with identifier 0x123 and two bytes. Clients that accept the URL of a
//! serial port connect to `socket://host:port`. Every line gets one answer. The channel opens
//! without a bit rate, and the bus has only one: another one is refused, and so is everything else
//! that the port cannot do. Remote frames and those with 29-bit identifiers are answered like
//! others, but they do not reach the virtual bus: the nodes' CAN controllers would ignore them.
//!
//! `protocol` defines the lines, `channel` answers them, `client` is one connection, `port` is the
//! port with its clients.

mod channel;
mod client;
mod port;
mod protocol;

pub use channel::Channel;
pub use port::{MAX_CLIENTS, SlcanPort};
pub use protocol::{Request, line_of};
