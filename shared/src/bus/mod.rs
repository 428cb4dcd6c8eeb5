//! Defines what tautrack sends on a CANopen bus, as pure code without I/O.
//!
//! * [`pdo`]: payloads of the process data objects (PDOs); the object dictionaries map the same
//!   payloads
//! * [`network`]: identifiers, network management (NMT), SYNC and emergency frames
//! * [`heartbeat`]: monitoring of another node's heartbeat
//! * [`pace`]: finds identifiers that two nodes send
//! * [`node`]: a node of the bus: its objects, service data and process data
//! * [`lss`]: layer setting services, which give a new node its id
//! * [`cia402`]: the drive state machine
//! * [`drive_parameters`]: option codes, windows and limits of a drive
//! * [`scale`]: converts integers on the bus to SI units, and back

pub mod cia402;
pub mod drive_parameters;
pub mod heartbeat;
pub mod lss;
pub mod network;
pub mod node;
pub mod pace;
pub mod pdo;
pub mod scale;
