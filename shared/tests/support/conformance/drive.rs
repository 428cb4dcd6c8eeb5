//! What the node of a drive sends by CiA 301 and CiA 402.
//!
//! `80` in an answer is an abort. Its codes are those of the table of SDO abort codes in CiA 301.
//! Where the standard leaves the code to the device, the row says so.

use super::{NO_HEARTBEAT, Row};

/// State of the node before the exchange. Its heartbeat is off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    PreOperational,
    Operational,
    Stopped,
    /// The heartbeat of the guard has just come.
    Guarded,
    /// Operation is enabled, and the motor has current.
    Armed,
    /// Pre-operational node of a screw. Its name "tautrack screw" has two times seven bytes.
    Screw,
}
use State::{Armed, Guarded, Operational, PreOperational, Screw, Stopped};

/// Exchange that brings a node from its start to the state.
fn before(state: State) -> String {
    let rest = match state {
        PreOperational | Screw => "",
        Operational => "000: 01 05 >",
        Stopped => "000: 02 05 >",
        Guarded => "701: 05 >",
        Armed => {
            "000: 01 05 >; 701: 05 >; 205: 0006 08 00000000 >; 5ms >; \
             205: 0007 08 00000000 >; 5ms >; 205: 000f 08 00000000 >; 5ms >"
        }
    };
    format!("{NO_HEARTBEAT}; {rest}")
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Axle,
    Screw,
}

/// Returns the rows for a node of this role, whose board has this serial number.
pub fn rows(role: Role, serial: u32) -> Vec<Row> {
    let rows = ROWS
        .iter()
        .filter(|(state, ..)| (*state == Screw) == (role == Role::Screw));
    let row = |(state, clause, exchange): &Entry| {
        let name = format!("{state:?}, {clause}");
        Row::new(&name, &before(*state), exchange, serial)
    };
    rows.map(row).collect()
}

/// State, clause of the standard, and exchange.
type Entry = (State, &'static str, &'static str);

#[rustfmt::skip] // a row is a line, or a line and its exchange
const ROWS: &[Entry] = &[
    // SDO upload, expedited: the number of bytes is in the command.
    (PreOperational, "upload initiate: 4 bytes; 1000h", "40 1000:00 > 43 1000:00 00020192"),
    (PreOperational, "upload initiate: 2 bytes", "40 2060:04 > 4b 2060:04 0100"),
    (PreOperational, "upload initiate: 1 byte; 1001h", "40 1001:00 > 4f 1001:00 00"),
    (PreOperational, "upload initiate: a text of 1 byte", "40 1009:00 > 4f 1009:00 2d"),
    (PreOperational, "1018h: highest sub-index", "40 1018:00 > 4f 1018:00 04"),
    (PreOperational, "1018h: vendor", "40 1018:01 > 43 1018:01 00000000"),
    (PreOperational, "1018h: product code", "40 1018:02 > 43 1018:02 00000001"),
    (PreOperational, "1018h: revision", "40 1018:03 > 43 1018:03 00000001"),
    (PreOperational, "1018h: serial number", "40 1018:04 > 43 1018:04 serial"),
    (PreOperational, "1018h: no more sub-indices", "40 1018:05 > 80 1018:05 06090011"),
    (PreOperational, "1010h: saves on command", "40 1010:01 > 43 1010:01 00000001"),
    (PreOperational, "402 60c2h: the period of SYNC, which alone may be written",
        "40 60c2:01 > 4f 60c2:01 04; 40 60c2:02 > 4f 60c2:02 fd; 2f 60c2:01 04 > 60 60c2:01; \
         2f 60c2:02 fd > 60 60c2:02; 2f 60c2:01 05 > 80 60c2:01 06090030; \
         2f 60c2:02 fc > 80 60c2:02 06090030"),
    (PreOperational, "402 6081h, 6083h: a profile that never moves is refused",
        "23 6081:00 00000000 > 80 6081:00 06090030; 23 6083:00 00000000 > 80 6083:00 06090030; \
         23 6081:00 00000001 > 60 6081:00"),
    (PreOperational, "402 6098h: the method at start may be written back",
        "40 6098:00 > 4f 6098:00 00; 2f 6098:00 00 > 60 6098:00; 2f 6098:00 14 > 60 6098:00; \
         2f 6098:00 01 > 80 6098:00 06090030"),
    (PreOperational, "402 6502h", "40 6502:00 > 43 6502:00 000003a5"),
    (Operational, "operational: SDO is served", "40 1000:00 > 43 1000:00 00020192"),
    (Guarded, "upload is allowed to everybody", "40 6060:00 > 4f 6060:00 00"),
    (Stopped, "stopped: no SDO", "40 1000:00 >; 2b 1017:00 0064 >; 80 1000:00 08000000 >"),
    (Stopped, "stopped: no block transfer",
        "a4 1008:00 7f >; a3 >; c6 607a:00 00000004 >; 5ms >"),
    (PreOperational, "an SDO has eight bytes",
        "605: 40 1000:00 >; 605: 40 1000:00 000000 >; 605: >"),
    (PreOperational, "another node's SDO",
        "606: 40 1000:00 00000000 >; 585: 40 1000:00 00000000 >; \
         5ms > 085: 8150 11 00000000 00"),

    // Unknown objects and commands.
    (PreOperational, "06020000: no object", "40 1002:00 > 80 1002:00 06020000"),
    (PreOperational, "06020000: below all", "40 0000:00 > 80 0000:00 06020000"),
    (PreOperational, "06020000: above all", "40 ffff:ff > 80 ffff:ff 06020000"),
    (PreOperational, "06020000: no such setting", "40 22ff:00 > 80 22ff:00 06020000"),
    (PreOperational, "06090011: a variable has sub-index 0", "40 1000:01 > 80 1000:01 06090011"),
    (PreOperational, "06090011: above the last", "40 607d:03 > 80 607d:03 06090011"),
    (PreOperational, "06090011: heartbeat", "40 1017:01 > 80 1017:01 06090011"),
    (PreOperational, "06090011: store", "40 1010:02 > 80 1010:02 06090011"),
    (PreOperational, "06020000 in a download", "2f 1002:00 01 > 80 1002:00 06020000"),
    (PreOperational, "06090011 in a download", "2b 6040:01 0006 > 80 6040:01 06090011"),
    (PreOperational, "06090011 in a download of 1017h", "2b 1017:01 0006 > 80 1017:01 06090011"),
    (PreOperational, "06020000, size not given", "22 5000:00 01 > 80 5000:00 06020000"),
    (PreOperational, "06020000, segmented", "20 5000:00 > 80 5000:00 06020000"),
    (PreOperational, "05040001: command 7", "e0 1000:00 > 80 .. .. .. 05040001"),
    (PreOperational, "05040001: a segment of no download", "00 > 80 .. .. .. 05040001"),
    (PreOperational, "05040001: a segment of no upload", "60 > 80 .. .. .. 05040001"),
    (PreOperational, "05040001: start of no block", "a3 > 80 .. .. .. 05040001"),
    (PreOperational, "05040001: acknowledgement of no block", "a2 01 7f > 80 .. .. .. 05040001"),
    (PreOperational, "05040001: end of no block", "c1 > 80 .. .. .. 05040001"),
    (PreOperational, "abort: it has no answer", "80 1000:00 08000000 >"),

    // SDO download, expedited.
    (PreOperational, "download initiate: 4 bytes",
        "23 607a:00 11223344 > 60 607a:00; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "download initiate: 2 bytes; 1017h",
        "2b 1017:00 0064 > 60 1017:00; 40 1017:00 > 4b 1017:00 0064"),
    (PreOperational, "download initiate: 1 byte; 402 6060h",
        "2f 6060:00 08 > 60 6060:00; 40 6060:00 > 4f 6060:00 08"),
    (Operational, "operational: SDO is served",
        "23 607a:00 00000001 > 60 607a:00; 40 607a:00 > 43 607a:00 00000001"),
    (PreOperational, "size not given: 4 bytes",
        "22 607a:00 11223344 > 60 607a:00; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "size not given: 2 bytes",
        "22 6040:00 0006 > 60 6040:00; 40 6040:00 > 4b 6040:00 0006"),
    (PreOperational, "size not given: 1 byte",
        "22 6060:00 09 > 60 6060:00; 40 6060:00 > 4f 6060:00 09"),
    (PreOperational, "size not given: 1017h",
        "22 1017:00 0064 > 60 1017:00; 40 1017:00 > 4b 1017:00 0064"),
    (PreOperational, "size not given: a PDO's parameter",
        "22 1800:02 05 > 60 1800:02; 40 1800:02 > 4f 1800:02 05"),
    (PreOperational, "06070013: 1 byte for 2", "2f 1017:00 64 > 80 1017:00 06070013"),
    (PreOperational, "06070012: 4 bytes for 2", "23 1017:00 00000064 > 80 1017:00 06070012"),
    (PreOperational, "06070012: 3 bytes for 2", "27 6040:00 06 00 00 > 80 6040:00 06070012"),
    (PreOperational, "06070013: 3 bytes for 4", "27 607a:00 01 02 03 > 80 607a:00 06070013"),
    (PreOperational, "06070013: 2 bytes for 4", "2b 607a:00 0001 > 80 607a:00 06070013"),
    (PreOperational, "06070012: 2 bytes for 1", "2b 6060:00 0008 > 80 6060:00 06070012"),
    (PreOperational, "06070013: a setting", "2b 2202:00 0001 > 80 2202:00 06070013"),
    (PreOperational, "06070012: a PDO's parameter", "2b 1800:02 0001 > 80 1800:02 06070012"),
    (PreOperational, "06010002: constant", "23 1000:00 00000000 > 80 1000:00 06010002"),
    (PreOperational, "06010002: 1018h", "23 1018:04 00000001 > 80 1018:04 06010002"),
    (PreOperational, "06010002: highest sub-index", "2f 1018:00 05 > 80 1018:00 06010002"),
    (PreOperational, "06010002: highest sub-index of 1010h", "2f 1010:00 02 > 80 1010:00 06010002"),
    (PreOperational, "06010002: 402 6041h", "2b 6041:00 0000 > 80 6041:00 06010002"),
    (PreOperational, "06010002: 402 6041h, size not given", "22 6041:00 > 80 6041:00 06010002"),
    (PreOperational, "06010002: a text, size not given", "22 1008:00 61 > 80 1008:00 06010002"),
    (PreOperational, "06010002: a text, segmented", "21 1008:00 0000000d > 80 1008:00 06010002"),
    (PreOperational, "06010002: the settings found", "2f 2020:01 00 > 80 2020:01 06010002"),
    (PreOperational, "06090032: a node id below 1", "23 2201:00 00000000 > 80 2201:00 06090032"),
    (PreOperational, "06090031: a node id above 127", "23 2201:00 00000080 > 80 2201:00 06090031"),
    (PreOperational, "the highest node id",
        "23 2201:00 0000007f > 60 2201:00; 40 2201:00 > 43 2201:00 0000007f"),
    (PreOperational, "06090030: 402 605Ah", "2b 605a:00 0003 > 80 605a:00 06090030"),
    (PreOperational, "402 6060h: manufacturer-specific modes",
        "2f 6060:00 fe > 60 6060:00; 40 6060:00 > 4f 6060:00 fe; 40 607a:00 > 43 607a:00 00000000; \
         2f 6060:00 fd > 80 6060:00 06090030"),
    (PreOperational, "06090030: 402 6060h", "2f 6060:00 63 > 80 6060:00 06090030"),
    (PreOperational, "06090030: 402 6098h", "2f 6098:00 01 > 80 6098:00 06090030"),
    (PreOperational, "402 605Ah: its values",
        "2b 605a:00 0000 > 60 605a:00; 2b 605a:00 0006 > 60 605a:00; 40 605a:00 > 4b 605a:00 0006"),
    (PreOperational, "1010h: the signature is \"save\"",
        "23 1010:01 73 61 76 65 > 60 1010:01; 23 1010:01 65 76 61 73 > 80 1010:01 08000020"),
    (PreOperational, "1011h: the signature is \"load\"",
        "23 1011:01 6c 6f 61 64 > 60 1011:01; 23 1011:01 73 61 76 65 > 80 1011:01 08000020"),
    (Guarded, "08000022: a guard commands the drive", "2f 6060:00 08 > 80 6060:00 08000022"),
    (Guarded, "08000022: a receive PDO", "23 1400:01 80000205 > 80 1400:01 08000022"),
    (Guarded, "08000022: segmented", "20 607a:00 > 80 607a:00 08000022"),
    (Guarded, "08000022: in a block", "c6 607a:00 00000004 > 80 607a:00 08000022"),
    (Guarded, "no longer than the guard lives",
        "2b 1017:00 0000 > 60 1017:00; 200ms >; 2f 6060:00 08 > 60 6060:00"),
    (Armed, "08000022: not saved while the motor has current",
        "23 1010:01 73 61 76 65 > 80 1010:01 08000022; \
         23 1011:01 6c 6f 61 64 > 80 1011:01 08000022"),
    (Armed, "402: operation enabled, voltage enabled",
        "40 6041:00 > 4b 6041:00 37 ..; 40 6061:00 > 4f 6061:00 08"),

    // SDO download in segments.
    (PreOperational, "download segment: one, size given",
        "21 607a:00 00000004 > 60 607a:00; 07 11223344 > 20; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "download segment: one, size not given",
        "20 607a:00 > 60 607a:00; 07 11223344 > 20; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "download segment: 2 bytes",
        "21 1017:00 00000002 > 60 1017:00; 0b 0064 > 20; 40 1017:00 > 4b 1017:00 0064"),
    (PreOperational, "download segment: 1 byte",
        "21 6060:00 00000001 > 60 6060:00; 0d 08 > 20; 40 6060:00 > 4f 6060:00 08"),
    (PreOperational, "download segment: two",
        "20 607a:00 > 60 607a:00; 0a 44 33 > 20; 1b 22 11 > 30; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "download segment: the last is empty",
        "20 607a:00 > 60 607a:00; 06 11223344 > 20; 1f > 30; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "download segment: four of a byte",
        "20 607a:00 > 60 607a:00; 0c 44 > 20; 1c 33 > 30; 0c 22 > 20; 1d 11 > 30; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "no value before the last segment",
        "20 607a:00 > 60 607a:00; 06 11223344 > 20; 80 607a:00 08000000 >; \
         40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "05030000: the first toggle bit is 0",
        "20 607a:00 > 60 607a:00; 17 11223344 > 80 607a:00 05030000; 07 > 80 .. .. .. 05040001"),
    (PreOperational, "05030000: it alternates",
        "20 607a:00 > 60 607a:00; 0a 44 33 > 20; 0b 22 11 > 80 607a:00 05030000"),
    (PreOperational, "06070012: size given", "21 607a:00 00000005 > 80 607a:00 06070012"),
    (PreOperational, "06070013: size given", "21 607a:00 00000003 > 80 607a:00 06070013"),
    (PreOperational, "06070013: size 0 given", "21 607a:00 00000000 > 80 607a:00 06070013"),
    (PreOperational, "06070012: a size of 4 GB", "21 607a:00 ffffffff > 80 607a:00 06070012"),
    (PreOperational, "06070013: fewer bytes than given",
        "21 607a:00 00000004 > 60 607a:00; 0b 22 11 > 80 607a:00 06070013"),
    (PreOperational, "06070013: no bytes", "20 607a:00 > 60 607a:00; 0f > 80 607a:00 06070013"),
    (PreOperational, "06070012: more bytes than the object",
        "20 607a:00 > 60 607a:00; 05 11223344 55 > 80 607a:00 06070012"),
    (PreOperational, "06070012: more bytes in two segments",
        "20 607a:00 > 60 607a:00; 00 11223344 > 20; 11 11223344 > 80 607a:00 06070012"),
    (PreOperational, "06090030 at the end",
        "20 605a:00 > 60 605a:00; 0b 0003 > 80 605a:00 06090030"),
    (PreOperational, "abort: it ends the transfer",
        "20 607a:00 > 60 607a:00; 80 607a:00 08000000 >; 07 > 80 .. .. .. 05040001"),
    (PreOperational, "05040000: the client sends nothing more",
        "20 607a:00 > 60 607a:00; 600ms > 80 607a:00 05040000; 07 > 80 .. .. .. 05040001"),
    (PreOperational, "a slow client",
        "20 607a:00 > 60 607a:00; 400ms >; 0a 44 33 > 20; 400ms >; 1b 22 11 > 30; 600ms >"),
    (PreOperational, "05040001: another command in a download",
        "20 607a:00 > 60 607a:00; 60 > 80 .. .. .. 05040001"),

    // SDO upload in segments: the name "tautrack axle" has 7 + 6 bytes.
    (PreOperational, "upload segment: toggle bit, unused bytes, last",
        "40 1008:00 > 41 1008:00 0000000d; 60 > 00 74 61 75 74 72 61 63; \
         70 > 13 6b 20 61 78 6c 65; 60 > 80 .. .. .. 05040001"),
    (PreOperational, "upload segment: 5 bytes",
        "40 100a:00 > 41 100a:00 00000005; 60 > 05 30 2e 31 2e 30"),
    (Screw, "upload segment: two times 7 bytes",
        "40 1008:00 > 41 1008:00 0000000e; 60 > 00 74 61 75 74 72 61 63; \
         70 > 11 6b 20 73 63 72 65 77"),
    (PreOperational, "upload initiate: 514 bytes",
        "40 2063:00 > 41 2063:00 00000202; 60 > 00; 70 > 10; 60 > 00"),
    (PreOperational, "05030000: the first toggle bit is 0",
        "40 1008:00 > 41 1008:00 0000000d; 70 > 80 1008:00 05030000; 60 > 80 .. .. .. 05040001"),
    (PreOperational, "05030000: it alternates",
        "40 1008:00 > 41 1008:00 0000000d; 60 > 00 74 61 75 74 72 61 63; 60 > 80 1008:00 05030000"),
    (PreOperational, "abort: it ends the transfer",
        "40 1008:00 > 41 1008:00 0000000d; 80 1008:00 08000000 >; 60 > 80 .. .. .. 05040001"),
    (PreOperational, "05040000",
        "40 1008:00 > 41 1008:00 0000000d; 600ms > 80 1008:00 05040000; 60 > 80 .. .. .. 05040001"),

    // SDO block upload. The checksums are those of Python's `binascii.crc_hqx(bytes, 0)`.
    (PreOperational, "block upload: two segments and the end",
        "a4 1008:00 7f > c6 1008:00 0000000d; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 02 7f > c5 e0d6; a1 >; 600ms >"),
    (Screw, "block upload: no unused bytes",
        "a4 1008:00 7f > c6 1008:00 0000000e; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 73 63 72 65 77; a2 02 7f > c1 385d; a1 >"),
    (PreOperational, "block upload: a small object",
        "a4 1000:00 7f > c6 1000:00 00000004; a3 >; 1ms > 81 92 01 02 00; a2 01 7f > cd 7aa5; \
         a1 >"),
    (PreOperational, "block upload: the checksum is 0 for a client without",
        "a0 1008:00 7f > c6 1008:00 0000000d; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 02 7f > c5 0000; a1 >"),
    (PreOperational, "block upload: blocks of one segment",
        "a4 1008:00 01 > c6 1008:00 0000000d; a3 >; 5ms > 01 74 61 75 74 72 61 63; a2 01 01 >; \
         5ms > 81 6b 20 61 78 6c 65; a2 01 01 > c5 e0d6; a1 >"),
    (PreOperational, "block upload: four of 74 segments",
        "a4 2063:00 04 > c6 2063:00 00000202; a3 >; 5ms > 01, 02, 03, 04; a2 04 02 >; \
         5ms > 01, 02"),
    (PreOperational, "block upload: 74 segments",
        "a4 2063:00 7f > c6 2063:00 00000202; a3 >; 20ms > .. *73, ca; a2 4a 7f > d1 0000; a1 >"),
    (PreOperational, "block upload: a lost segment among 74",
        "a4 2063:00 7f > c6 2063:00 00000202; a3 >; 20ms > .. *73, ca; a2 48 7f >; \
         20ms > 01, 82; a2 02 7f > d1 0000; a1 >; 600ms >"),
    (PreOperational, "block upload: the second segment again",
        "a4 1008:00 7f > c6 1008:00 0000000d; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 01 7f >; \
         1ms > 81 6b 20 61 78 6c 65; a2 01 7f > c5 e0d6; a1 >"),
    (PreOperational, "block upload: all segments again",
        "a4 1008:00 7f > c6 1008:00 0000000d; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 00 7f >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 02 7f > c5 e0d6; a1 >"),
    (PreOperational, "05040003: more than were sent",
        "a4 1008:00 7f > c6 1008:00 0000000d; a3 >; \
         1ms > 01 74 61 75 74 72 61 63, 82 6b 20 61 78 6c 65; a2 03 7f > 80 1008:00 05040003"),
    (PreOperational, "05040002: no segments", "a4 1008:00 00 > 80 1008:00 05040002"),
    (PreOperational, "05040002: 128 segments", "a4 1008:00 80 > 80 1008:00 05040002"),
    (PreOperational, "05040002: no segments in the next block",
        "a4 1008:00 01 > c6 1008:00 0000000d; a3 >; 1ms > 01 74 61 75 74 72 61 63; \
         a2 01 00 > 80 1008:00 05040002"),
    (PreOperational, "block upload: the threshold switches to segments",
        "a4 1008:00 7f 0d > 41 1008:00 0000000d; 60 > 00 74 61 75 74 72 61 63; \
         70 > 13 6b 20 61 78 6c 65"),
    (PreOperational, "block upload: the threshold switches to expedited",
        "a4 1000:00 7f 04 > 43 1000:00 00020192"),
    (PreOperational, "block upload: above the threshold",
        "a4 1008:00 7f 0c > c6 1008:00 0000000d"),
    (PreOperational, "block upload: abort before the start",
        "a4 1008:00 7f > c6 1008:00 0000000d; 80 1008:00 08000000 >; a3 > 80 .. .. .. 05040001"),
    (PreOperational, "block upload: abort between segments",
        "a4 2063:00 7f > c6 2063:00 00000202; a3 >; =1ms > 01, 02, 03, 04, 05, 06, 07, 08; \
         80 2063:00 08000000 >; 600ms >"),
    (PreOperational, "block upload: abort at the end",
        "a4 1000:00 7f > c6 1000:00 00000004; a3 >; 1ms > 81 92 01 02 00; a2 01 7f > cd 7aa5; \
         80 1000:00 05040004 >; 600ms >"),
    (PreOperational, "05040000: no acknowledgement",
        "a4 1000:00 7f > c6 1000:00 00000004; a3 >; 600ms > 81 92 01 02 00, 80 1000:00 05040000"),
    (PreOperational, "06020000 in a block upload", "a4 5000:00 7f > 80 5000:00 06020000"),
    (PreOperational, "06090011 in a block upload", "a4 1018:05 7f > 80 1018:05 06090011"),

    // SDO block download.
    (PreOperational, "block download: checksum, size given",
        "c6 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; cd 5a0c > a1; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "block download: size not given",
        "c4 607a:00 > a4 607a:00 ..; 81 11223344 > a2 01 ..; cd 5a0c > a1; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "block download: 2 bytes",
        "c6 1017:00 00000002 > a4 1017:00 ..; 81 0064 > a2 01 ..; d5 c7ee > a1; \
         40 1017:00 > 4b 1017:00 0064"),
    (PreOperational, "block download: a client without checksum",
        "c2 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; cd 0000 > a1; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "block download: what such a client sends does not count",
        "c2 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; cd ffff > a1"),
    (PreOperational, "05040004: wrong checksum",
        "c6 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; \
         cd 5a0d > 80 607a:00 05040004; 40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "05040004: 0 is a wrong checksum, too",
        "c6 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; \
         cd 0000 > 80 607a:00 05040004"),
    (PreOperational, "block download: the first segment is lost",
        "c6 607a:00 00000004 > a4 607a:00 ..; 82 11223344 > a2 00 ..; 81 11223344 > a2 01 ..; \
         cd 5a0c > a1; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "05040003: no segment has the number 0",
        "c6 607a:00 00000004 > a4 607a:00 ..; 00 11223344 > 80 607a:00 05040003"),
    (PreOperational, "06070012: size given", "c6 607a:00 00000005 > 80 607a:00 06070012"),
    (PreOperational, "06070013: size given", "c6 607a:00 00000003 > 80 607a:00 06070013"),
    (PreOperational, "06070012: more than one segment",
        "c4 607a:00 > a4 607a:00 ..; 01 11223344 >; 82 11223344 > 80 607a:00 06070012"),
    (PreOperational, "block download: no segment is a request",
        "c4 607a:00 > a4 607a:00 ..; 01 11223344 >; 2f 6060:00 08 >; 40 1000:00 >; \
         7f > 80 607a:00 06070012; 40 6060:00 > 4f 6060:00 00; 40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "block download: a segment comes twice",
        "c4 607a:00 > a4 607a:00 ..; 82 11223344 > a2 00 ..; 83 11223344 > a2 00 ..; \
         81 11223344 > a2 01 ..; cd 5a0c > a1"),
    (PreOperational, "06070012: fewer unused bytes",
        "c0 607a:00 > a4 607a:00 ..; 81 11223344 > a2 01 ..; c9 > 80 607a:00 06070012"),
    (PreOperational, "06070013: more unused bytes",
        "c0 607a:00 > a4 607a:00 ..; 81 11223344 > a2 01 ..; dd > 80 607a:00 06070013"),
    (PreOperational, "06010002 in a block download", "c6 1000:00 00000004 > 80 1000:00 06010002"),
    (PreOperational, "06020000 in a block download", "c6 5000:00 00000004 > 80 5000:00 06020000"),
    (PreOperational, "06090030 at the end of a block download",
        "c0 605a:00 > a4 605a:00 ..; 81 0003 > a2 01 ..; d5 > 80 605a:00 06090030"),
    (PreOperational, "block download: abort before the segment",
        "c6 607a:00 00000004 > a4 607a:00 ..; 80 607a:00 08000000 >; cd > 80 .. .. .. 05040001"),
    (PreOperational, "block download: abort before the end",
        "c6 607a:00 00000004 > a4 607a:00 ..; 81 11223344 > a2 01 ..; 80 607a:00 08000000 >; \
         40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "05040000 in a block download",
        "c6 607a:00 00000004 > a4 607a:00 ..; 600ms > 80 607a:00 05040000"),

    // Communication parameters of PDOs.
    (PreOperational, "1400h: highest sub-index",
        "40 1400:00 > 4f 1400:00 02; 2f 1400:00 05 > 80 1400:00 06010002"),
    (PreOperational, "1400h: predefined identifiers",
        "40 1400:01 > 43 1400:01 00000205; 40 1401:01 > 43 1401:01 00000305; \
         40 1402:01 > 43 1402:01 00000405; 40 1403:01 > 43 1403:01 00000505"),
    (PreOperational, "1800h: predefined identifiers, no remote frames",
        "40 1800:01 > 43 1800:01 40000185; 40 1801:01 > 43 1801:01 40000285"),
    (PreOperational, "1800h: sub-index 4 is reserved",
        "40 1800:00 > 4f 1800:00 05; 40 1800:04 > 80 1800:04 06090011; \
         2f 1800:04 00 > 80 1800:04 06090011"),
    (PreOperational, "no more PDOs", "40 1404:00 > 80 1404:00 06020000; \
         40 15ff:01 > 80 15ff:01 06020000; 40 1804:01 > 80 1804:01 06020000; \
         40 1604:00 > 80 1604:00 06020000; 40 1a04:00 > 80 1a04:00 06020000"),
    (PreOperational, "1800h: unused until bit 31 is 0",
        "40 1802:01 > 43 1802:01 .. .. .. c0; 23 1802:01 40000385 > 60 1802:01; \
         40 1802:01 > 43 1802:01 40000385"),
    (PreOperational, "1800h: restricted: NMT and reserved",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000000 > 80 1800:01 06090030; \
         23 1800:01 40000001 > 80 1800:01 06090030; 23 1800:01 4000007f > 80 1800:01 06090030"),
    (PreOperational, "1800h: SYNC has the identifier 080h",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000080 > 80 1800:01 06090030"),
    (PreOperational, "1800h: restricted: 101h to 180h",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000101 > 80 1800:01 06090030; \
         23 1800:01 40000180 > 80 1800:01 06090030"),
    (PreOperational, "1800h: restricted: SDO",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000581 > 80 1800:01 06090030; \
         23 1800:01 400005ff > 80 1800:01 06090030; 23 1800:01 40000601 > 80 1800:01 06090030; \
         23 1800:01 4000067f > 80 1800:01 06090030"),
    (PreOperational, "1800h: restricted: 6E0h to 6FFh, and from 701h on",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 400006e0 > 80 1800:01 06090030; \
         23 1800:01 400006ff > 80 1800:01 06090030; 23 1800:01 40000701 > 80 1800:01 06090030; \
         23 1800:01 4000077f > 80 1800:01 06090030; 23 1800:01 400007ff > 80 1800:01 06090030"),
    (PreOperational, "1800h: identifiers next to the restricted ones",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000181 > 60 1800:01; \
         23 1800:01 c0000181 > 60 1800:01; 23 1800:01 4000057f > 60 1800:01; \
         23 1800:01 c0000181 > 60 1800:01; 23 1800:01 40000680 > 60 1800:01; \
         23 1800:01 c0000181 > 60 1800:01; 23 1800:01 400006df > 60 1800:01; \
         40 1800:01 > 43 1800:01 400006df"),
    (PreOperational, "1400h: restricted, too",
        "23 1400:01 80000205 > 60 1400:01; 23 1400:01 00000000 > 80 1400:01 06090030; \
         23 1400:01 00000605 > 80 1400:01 06090030; 23 1400:01 00000705 > 80 1400:01 06090030"),
    (PreOperational, "1800h: bits 11 to 28 are 0 in a base frame",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000800 > 80 1800:01 06090030; \
         23 1800:01 50000185 > 80 1800:01 06090030"),
    (PreOperational, "bit 29: extended frames are not supported",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 60000185 > 80 1800:01 06090030; \
         23 1400:01 80000205 > 60 1400:01; 23 1400:01 20000205 > 80 1400:01 06090030"),
    (PreOperational, "1800h bit 30: remote frames are not supported",
        "23 1800:01 00000185 > 80 1800:01 06090030; 23 1800:01 80000185 > 80 1800:01 06090030"),
    (PreOperational, "1400h bit 30 does not count", "23 1400:01 c0000205 > 60 1400:01"),
    // The standard leaves this code to the device.
    (PreOperational, "bits 0 to 29 do not change while the PDO exists",
        "23 1800:01 40000385 > 80 1800:01 08000022; 23 1400:01 00000345 > 80 1400:01 08000022; \
         40 1800:01 > 43 1800:01 40000185; 40 1400:01 > 43 1400:01 00000205"),
    (PreOperational, "the same identifier while the PDO exists",
        "23 1800:01 40000185 > 60 1800:01; 23 1400:01 00000205 > 60 1400:01"),
    (PreOperational, "06070013: an identifier has 4 bytes",
        "2b 1400:01 0205 > 80 1400:01 06070013"),
    (PreOperational, "1800h: transmission types with SYNC",
        "2f 1800:02 00 > 60 1800:02; 2f 1800:02 01 > 60 1800:02; 2f 1800:02 f0 > 60 1800:02; \
         40 1800:02 > 4f 1800:02 f0"),
    (PreOperational, "1800h: event-driven transmission types",
        "2f 1800:02 fe > 60 1800:02; 2f 1800:02 ff > 60 1800:02; 40 1800:02 > 4f 1800:02 ff"),
    (PreOperational, "1800h: reserved transmission types",
        "2f 1800:02 f1 > 80 1800:02 06090030; 2f 1800:02 fb > 80 1800:02 06090030; \
         40 1800:02 > 4f 1800:02 01"),
    (PreOperational, "1800h: types of remote frames are not supported",
        "2f 1800:02 fc > 80 1800:02 06090030; 2f 1800:02 fd > 80 1800:02 06090030"),
    (PreOperational, "1400h: transmission types",
        "2f 1400:02 00 > 60 1400:02; 2f 1400:02 01 > 60 1400:02; 2f 1400:02 f0 > 60 1400:02; \
         2f 1400:02 fe > 60 1400:02; 2f 1400:02 ff > 60 1400:02"),
    (PreOperational, "1400h: reserved transmission types",
        "2f 1400:02 f1 > 80 1400:02 06090030; 2f 1400:02 fc > 80 1400:02 06090030; \
         2f 1400:02 fd > 80 1400:02 06090030; 40 1400:02 > 4f 1400:02 ff"),
    // The standard leaves this code to the device.
    (PreOperational, "1800h: the inhibit time does not change while the PDO exists",
        "2b 1800:03 0064 > 80 1800:03 08000022; 40 1800:03 > 4b 1800:03 0000"),
    (PreOperational, "1800h: inhibit time",
        "23 1800:01 c0000185 > 60 1800:01; 2b 1800:03 0064 > 60 1800:03; \
         40 1800:03 > 4b 1800:03 0064"),
    (PreOperational, "1800h: event timer",
        "2b 1800:05 000a > 60 1800:05; 40 1800:05 > 4b 1800:05 000a"),
    (PreOperational, "1400h: neither inhibit time nor event timer",
        "40 1400:03 > 80 1400:03 06090011; 2b 1400:05 0064 > 80 1400:05 06090011"),

    // Mapping parameters of PDOs. The third transmit PDO is not used at start.
    (PreOperational, "1600h: mapping at start",
        "40 1600:00 > 4f 1600:00 03; 40 1600:01 > 43 1600:01 60400010; \
         40 1600:02 > 43 1600:02 60600008; 40 1600:03 > 43 1600:03 607a0020"),
    (PreOperational, "1A00h: mapping at start",
        "40 1a00:00 > 4f 1a00:00 02; 40 1a00:01 > 43 1a00:01 60640020; \
         40 1a00:02 > 43 1a00:02 606c0020; 40 1a00:03 > 43 1a00:03 00000000; \
         40 1a00:09 > 80 1a00:09 06090011"),
    (PreOperational, "1A00h: mapped, counted, used",
        "23 1a02:01 60410010 > 60 1a02:01; 23 1a02:02 60640020 > 60 1a02:02; \
         2f 1a02:00 02 > 60 1a02:00; 23 1802:01 40000385 > 60 1802:01; \
         40 1a02:00 > 4f 1a02:00 02; 40 1a02:02 > 43 1a02:02 60640020"),
    (PreOperational, "06020000 or 06040041: 1017h is in no PDO",
        "23 1a02:01 10170010 > 80 1a02:01 .. 00 .. 06; 40 1a02:01 > 43 1a02:01 00000000"),
    (PreOperational, "06040041: an object of no PDO", "23 1a02:01 607d0120 > 80 1a02:01 06040041"),
    (PreOperational, "06040041: 402 6040h is received",
        "23 1a02:01 60400010 > 80 1a02:01 06040041"),
    (PreOperational, "06040041: 402 6041h is transmitted",
        "23 1400:01 80000205 > 60 1400:01; 2f 1600:00 00 > 60 1600:00; \
         23 1600:01 60410010 > 80 1600:01 06040041"),
    (PreOperational, "06020000: a mapped object is missing",
        "23 1a02:01 50000008 > 80 1a02:01 06020000"),
    (PreOperational, "06020000: a mapped sub-index is missing",
        "23 1a02:01 60410110 > 80 1a02:01 06020000"),
    (PreOperational, "06040041: a part of an object", "23 1a02:01 60410008 > 80 1a02:01 06040041"),
    (PreOperational, "06040041: more than an object", "23 1a02:01 60410020 > 80 1a02:01 06040041"),
    (PreOperational, "06040041: nothing of an object", "23 1a02:01 60410000 > 80 1a02:01 06040041"),
    (PreOperational, "06040042: more than 8 bytes",
        "23 1a02:01 60640020 > 60 1a02:01; 23 1a02:02 606c0020 > 60 1a02:02; \
         23 1a02:03 60410010 > 60 1a02:03; 2f 1a02:00 03 > 80 1a02:00 06040042; \
         40 1a02:00 > 4f 1a02:00 00; 2f 1a02:00 02 > 60 1a02:00"),
    (PreOperational, "06040042: more objects than 8", "2f 1a02:00 09 > 80 1a02:00 06040042"),
    (PreOperational, "06020000: an empty entry is counted",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 02 > 80 1a02:00 06020000"),
    (PreOperational, "0 empties an entry",
        "23 1a02:01 60640020 > 60 1a02:01; 23 1a02:01 00000000 > 60 1a02:01; \
         40 1a02:01 > 43 1a02:01 00000000"),
    (PreOperational, "06070012: a count has one byte", "2b 1a02:00 0001 > 80 1a02:00 06070012"),
    // The standard leaves these codes to the device.
    (PreOperational, "no mapping changes while the PDO exists",
        "2f 1a00:00 00 > 80 1a00:00 08000022; 23 1a00:03 60410010 > 80 1a00:03 08000022; \
         2f 1600:00 00 > 80 1600:00 08000022"),
    (PreOperational, "no entry changes while it counts",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 01 > 60 1a02:00; \
         23 1a02:01 60410010 > 80 1a02:01 08000022; 23 1a02:02 60410010 > 80 1a02:02 08000022"),

    // Receive PDOs.
    (Operational, "type 255 acts at once",
        "205: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 11223344; 40 6060:00 > 4f 6060:00 08"),
    (PreOperational, "type 254 acts at once", "2f 1400:02 fe > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "no PDO in pre-operational",
        "205: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 00000000"),
    (Stopped, "no PDO in stopped",
        "205: 0000 08 11223344 >; 000: 80 05 >; 40 607a:00 > 43 607a:00 00000000"),
    (Operational, "fewer bytes than mapped are not processed",
        "205: 0000 08 11 22 33 > 085: 8210 11 00000000 00; 205: >; 40 607a:00 > 43 607a:00 00000000; \
         40 6060:00 > 4f 6060:00 00; 40 1003:01 > 43 1003:01 00008210"),
    (Operational, "8210: once, and again after a second without",
        "205: > 085: 8210 11 00000000 00; 205: >; 305: >; 205: 0000 08 00000000 >; \
         305: >; =999ms >; 305: >; =1000ms >; 305: > 085: 8210 11 00000000 00"),
    (PreOperational, "no 8210 where process data do not count", "205: >"),
    (Operational, "of more bytes the first count",
        "205: 0000 08 11223344 ff >; 40 607a:00 > 43 607a:00 11223344"),
    (Operational, "another node's PDO",
        "206: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "type 0 acts at SYNC",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1400:02 00 > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 5ms >; 40 607a:00 > 43 607a:00 00000000; 080: >; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "type 1 acts at SYNC, with the last frame",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1400:02 01 > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 5ms >; 205: 0000 08 00000005 >; \
         40 607a:00 > 43 607a:00 00000000; 080: >; 40 607a:00 > 43 607a:00 00000005"),
    (PreOperational, "type 240 acts at the next SYNC",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1400:02 f0 > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 5ms >; 40 607a:00 > 43 607a:00 00000000; 080: >; \
         40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "a frame acts at one SYNC only",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1400:02 01 > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 5ms >; 080: >; 23 607a:00 00000005 > 60 607a:00; 080: >; \
         40 607a:00 > 43 607a:00 00000005"),
    (PreOperational, "what waits for SYNC does not outlive operational",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1400:02 01 > 60 1400:02; 000: 01 05 >; \
         205: 0000 08 11223344 >; 000: 80 05 >; 000: 01 05 >; 080: >; \
         40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "a new identifier",
        "23 1400:01 80000205 > 60 1400:01; 23 1400:01 00000345 > 60 1400:01; 000: 01 05 >; \
         205: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 00000000; \
         345: 0000 08 11223344 >; 40 607a:00 > 43 607a:00 11223344"),
    (PreOperational, "bit 31: the PDO does not exist",
        "23 1400:01 80000205 > 60 1400:01; 000: 01 05 >; 205: 0000 08 11223344 >; \
         40 607a:00 > 43 607a:00 00000000"),
    (PreOperational, "a new mapping",
        "23 1400:01 80000205 > 60 1400:01; 2f 1600:00 00 > 60 1600:00; \
         23 1600:01 60ff0020 > 60 1600:01; 23 1600:02 60710010 > 60 1600:02; \
         2f 1600:00 02 > 60 1600:00; 23 1400:01 00000205 > 60 1400:01; 000: 01 05 >; \
         205: 11223344 5566 >; 40 60ff:00 > 43 60ff:00 11223344; 40 6071:00 > 4b 6071:00 5566"),
    (PreOperational, "a mapping of nothing",
        "23 1400:01 80000205 > 60 1400:01; 2f 1600:00 00 > 60 1600:00; \
         23 1400:01 00000205 > 60 1400:01; 000: 01 05 >; 205: 0000 08 11223344 >; 205: >; \
         40 607a:00 > 43 607a:00 00000000"),

    // Transmit PDOs.
    (Operational, "type 1: each SYNC; type 5: each fifth",
        "5ms >; 080: *4 > 185: .. .. .. .. .. .. .. .. *4; \
         080: > 185: .. .. .. .. .. .. .. .., 285: .. .. .. .. .. .. .. ..; \
         080: *4 > 185: .. .. .. .. .. .. .. .. *4; \
         080: > 185: .. .. .. .. .. .. .. .., 285: .. .. .. .. .. .. .. .."),
    (Operational, "SYNC with a counter", "5ms >; 080: 01 > 185: .. .. .. .. .. .. .. .."),
    (PreOperational, "type 240",
        "23 1801:01 c0000285 > 60 1801:01; 2f 1800:02 f0 > 60 1800:02; 000: 01 05 >; 5ms >; \
         080: *239 >; 080: > 185: .. .. .. .. .. .. .. ..; 080: >"),
    (PreOperational, "no PDO in pre-operational", "5ms >; 080: >"),
    (Stopped, "no PDO in stopped", "5ms >; 080: >"),
    (PreOperational, "bit 31: the PDO does not exist",
        "23 1800:01 c0000185 > 60 1800:01; 000: 01 05 >; 5ms >; 080: >"),
    (PreOperational, "a new identifier",
        "23 1800:01 c0000185 > 60 1800:01; 23 1800:01 40000190 > 60 1800:01; 000: 01 05 >; \
         5ms >; 080: > 190: .. .. .. .. .. .. .. .."),
    (PreOperational, "a new mapping",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1a00:00 00 > 60 1a00:00; \
         23 1a00:01 60610008 > 60 1a00:01; 23 1a00:02 60410010 > 60 1a00:02; \
         2f 1a00:00 02 > 60 1a00:00; 23 1800:01 40000185 > 60 1800:01; 000: 01 05 >; 5ms >; \
         080: > 185: .. .. .."),
    (PreOperational, "a mapping of nothing",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1a00:00 00 > 60 1a00:00; \
         23 1800:01 40000185 > 60 1800:01; 000: 01 05 >; 5ms >; 080: >"),
    // The standard does not say whether the first SYNC counts as an event.
    (PreOperational, "type 0: at SYNC after a change only",
        "23 1801:01 c0000285 > 60 1801:01; 2f 1800:02 00 > 60 1800:02; 000: 01 05 >; 5ms >; \
         080: > 185: .. .. .. .. .. .. .. ..; 080: *3 >; turn >; 5ms >; \
         080: > 185: .. .. .. .. .. .. .. .."),
    (PreOperational, "type 254: after a change",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 01 > 60 1a02:00; 2f 1802:02 fe > 60 1802:02; \
         23 1802:01 40000385 > 60 1802:01; 000: 01 05 >; 5ms > 385: 00000000; 100ms >; turn >; \
         5ms > 385: .. .. .. ..; 100ms >"),
    (PreOperational, "type 255 does not follow SYNC",
        "2f 1800:02 ff > 60 1800:02; 000: 01 05 >; 5ms > 185: .. .. .. .. .. .. .. ..; 080: >"),
    (PreOperational, "event timer",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 01 > 60 1a02:00; 2f 1802:02 ff > 60 1802:02; \
         2b 1802:05 000a > 60 1802:05; 23 1802:01 40000385 > 60 1802:01; 000: 01 05 >; \
         1ms > 385: 00000000; 50ms > 385: 00000000 *5"),
    (PreOperational, "event timer: it runs from the last transmission",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 01 > 60 1a02:00; 2f 1802:02 ff > 60 1802:02; \
         2b 1802:05 0014 > 60 1802:05; 23 1802:01 40000385 > 60 1802:01; 000: 01 05 >; \
         1ms > 385: 00000000; 10ms >; turn >; 5ms > 385: .. .. .. ..; 10ms >; \
         10ms > 385: .. .. .. .."),
    (PreOperational, "event timer: not with SYNC",
        "2b 1800:05 000a > 60 1800:05; 000: 01 05 >; 100ms >"),
    (PreOperational, "inhibit time of 10 ms",
        "23 1a02:01 60640020 > 60 1a02:01; 2f 1a02:00 01 > 60 1a02:00; 2f 1802:02 ff > 60 1802:02; \
         2b 1802:03 0064 > 60 1802:03; 23 1802:01 40000385 > 60 1802:01; 000: 01 05 >; \
         1ms > 385: 00000000; turn >; 3ms >; turn >; 5ms >; 3ms > 385: .. .. .. ..; 100ms >"),

    // Network management. The heartbeat shows the state: 04 stopped, 05 operational, 7F
    // pre-operational.
    (PreOperational, "start", "2b 1017:00 000a > 60 1017:00; 000: 01 05 >; 10ms > 705: 05"),
    (PreOperational, "stop", "2b 1017:00 000a > 60 1017:00; 000: 02 05 >; 10ms > 705: 04"),
    (Operational, "pre-operational", "2b 1017:00 000a > 60 1017:00; 000: 80 05 >; 10ms > 705: 7f"),
    (Operational, "stop from operational",
        "2b 1017:00 000a > 60 1017:00; 000: 02 05 >; 10ms > 705: 04; 40 1000:00 >"),
    (Stopped, "start from stopped",
        "000: 01 05 >; 2b 1017:00 000a > 60 1017:00; 10ms > 705: 05; \
         40 1000:00 > 43 1000:00 00020192"),
    (PreOperational, "start of all nodes",
        "2b 1017:00 000a > 60 1017:00; 000: 01 00 >; 10ms > 705: 05"),
    (Operational, "stop of all nodes",
        "2b 1017:00 000a > 60 1017:00; 000: 02 00 >; 10ms > 705: 04"),
    (PreOperational, "start of another node",
        "2b 1017:00 000a > 60 1017:00; 000: 01 06 >; 10ms > 705: 7f"),
    (Operational, "stop and reset of another node",
        "2b 1017:00 000a > 60 1017:00; 000: 02 06 >; 000: 81 06 >; 000: 82 06 >; 10ms > 705: 05"),
    (Operational, "an unknown command",
        "2b 1017:00 000a > 60 1017:00; 000: 03 05 >; 000: 00 05 >; 000: ff 05 >; 10ms > 705: 05"),
    (Operational, "a command has two bytes",
        "2b 1017:00 000a > 60 1017:00; 000: 02 >; 000: >; 000: 02 05 00 >; 10ms > 705: 05"),
    (PreOperational, "reset node: boot-up", "000: 81 05 >; 20ms > 705: 00"),
    (PreOperational, "reset communication: boot-up", "000: 82 05 > 705: 00"),
    (Operational, "reset of all nodes", "000: 82 00 > 705: 00; 000: 81 00 >; 20ms > 705: 00"),
    (Operational, "reset ends in pre-operational",
        "000: 82 05 > 705: 00; 2b 1017:00 000a > 60 1017:00; 10ms > 705: 7f; 080: >"),
    (Stopped, "reset from stopped", "000: 81 05 >; 20ms > 705: 00; 40 1000:00 > 43 1000:00 00020192"),
    (PreOperational, "reset restores 1017h", "000: 82 05 > 705: 00; 40 1017:00 > 4b 1017:00 0032"),
    (PreOperational, "reset restores the PDOs",
        "23 1800:01 c0000185 > 60 1800:01; 2f 1800:02 05 > 60 1800:02; \
         2b 1800:03 0064 > 60 1800:03; \
         2b 1800:05 0064 > 60 1800:05; 2f 1a00:00 00 > 60 1a00:00; 000: 82 05 > 705: 00; \
         40 1800:01 > 43 1800:01 40000185; 40 1800:02 > 4f 1800:02 01; \
         40 1800:03 > 4b 1800:03 0000; 40 1800:05 > 4b 1800:05 0000; 40 1a00:00 > 4f 1a00:00 02"),
    (PreOperational, "reset ends a transfer",
        "20 607a:00 > 60 607a:00; 000: 82 05 > 705: 00; 2b 1017:00 0000 > 60 1017:00; \
         600ms >; 07 > 80 .. .. .. 05040001"),
    (PreOperational, "1003h: no error", "40 1003:00 > 4f 1003:00 00; 40 1003:01 > 80 1003:01 08000024"),
    (Operational, "1003h: the newest error is the first, and 0 clears the history",
        "205: > 085: 8210 11 00000000 00; 40 1003:00 > 4f 1003:00 01; \
         40 1003:01 > 43 1003:01 00008210; 40 1003:02 > 80 1003:02 08000024; \
         2f 1003:00 01 > 80 1003:00 06090030; 2f 1003:00 00 > 60 1003:00; \
         40 1003:00 > 4f 1003:00 00"),
    (PreOperational, "1003h: an error cannot be written", "23 1003:01 00000000 > 80 1003:01 06010002"),
    (PreOperational, "1003h: eight errors", "40 1003:09 > 80 1003:09 06090011"),
    (PreOperational, "1005h: SYNC, which the node does not send",
        "40 1005:00 > 43 1005:00 00000080; 23 1005:00 00000081 > 80 1005:00 06010002"),
    (PreOperational, "1014h: emergency",
        "40 1014:00 > 43 1014:00 00000085; 23 1014:00 00000085 > 80 1014:00 06010002"),
    (PreOperational, "1016h: two entries, of which the first is the guard",
        "40 1016:00 > 4f 1016:00 02; 40 1016:01 > 43 1016:01 00010078; \
         40 1016:02 > 43 1016:02 00000000; 23 1016:01 00000000 > 80 1016:01 06010002; \
         40 1016:03 > 80 1016:03 06090011"),
    (PreOperational, "1016h: 06040043: a node that is watched already",
        "23 1016:02 00010064 > 80 1016:02 06040043; 23 1016:02 00050064 > 80 1016:02 06040043"),
    (Guarded, "1016h: 08000022: not under a guard", "23 1016:02 00070064 > 80 1016:02 08000022"),
    (PreOperational, "1016h: no such node", "23 1016:02 00800064 > 80 1016:02 06090030"),
    (PreOperational, "1016h: an entry without time or node is not used",
        "23 1016:02 00070000 > 60 1016:02; 23 1016:02 00000064 > 60 1016:02; 300ms >"),
    (PreOperational, "1016h: a client that falls silent is 8130, once",
        "23 1016:02 00070064 > 60 1016:02; 300ms >; 707: 05 >; 99ms >; 707: 7f >; 99ms >; \
         10ms > 085: 8130 11 00000000 00; 300ms >; 40 603f:00 > 4b 603f:00 8130"),
    (PreOperational, "1016h: another node's heartbeat does not count",
        "23 1016:02 00070064 > 60 1016:02; 707: 05 >; 90ms >; 708: 05 >; \
         20ms > 085: 8130 11 00000000 00"),
    (PreOperational, "1016h: a reset of communication ends it",
        "23 1016:02 00070064 > 60 1016:02; 707: 05 >; 000: 82 05 > 705: 00; \
         2b 1017:00 0000 > 60 1017:00; 300ms >; 40 1016:02 > 43 1016:02 00000000"),
    (Operational, "402 fault reset: an edge between two frames of a millisecond counts, once",
        "23 1016:02 00070014 > 60 1016:02; 707: 05 >; 30ms > 085: 8130 11 00000000 00; \
         205: 0080 08 00000000 >; 205: 0000 08 00000000 >; 1ms > 085: 0000 00 00000000 00; \
         40 603f:00 > 4b 603f:00 0000; 707: 05 >; 30ms > 085: 8130 11 00000000 00; 50ms >; \
         40 603f:00 > 4b 603f:00 8130"),
    (PreOperational, "1029h: the network state does not change",
        "40 1029:00 > 4f 1029:00 01; 40 1029:01 > 4f 1029:01 01; \
         2f 1029:01 00 > 80 1029:01 06010002"),
    (PreOperational, "1017h: period", "2b 1017:00 000a > 60 1017:00; 100ms > 705: 7f *10"),
    (PreOperational, "1017h: 0 is no heartbeat", "500ms >"),
    (PreOperational, "1017h: it begins and ends with a write",
        "2b 1017:00 0014 > 60 1017:00; 100ms > 705: 7f *5; 2b 1017:00 0000 > 60 1017:00; 100ms >"),
    (PreOperational, "1017h: period at start",
        "000: 82 05 > 705: 00; 200ms > 705: 7f *4"),
];
