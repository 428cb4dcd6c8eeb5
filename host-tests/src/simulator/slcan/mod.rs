//! TCP port for SLCAN clients. Each CAN client that connects is one more participant of the virtual
//! bus.
//!
//! SLCAN is the line protocol of serial CAN adapters (LAWICEL CAN232 manual): `t1232AABB\r` is a
//! frame with identifier 0x123 and two bytes. Clients that accept the URL of a serial port connect
//! to `socket://host:port`. Any bit rate is accepted and has no effect. Extended and remote frames
//! are refused, because the virtual bus does not support them.
//!
//! `protocol` defines the lines, `port` is the port with its clients, `client` one connection.

mod client;
mod port;
mod protocol;

pub use port::{MAX_CLIENTS, SlcanPort};
pub use protocol::{Request, line_of};
