//! What tautrack puts on a `CANopen` bus, as pure code: identifiers and payloads ([`pdo`]), network management and error
//! frames ([`network`]), heartbeats ([`heartbeat`]). The object dictionaries map the same payloads.

pub mod cia402;
pub mod heartbeat;
pub mod network;
pub mod pdo;
pub mod scale;
