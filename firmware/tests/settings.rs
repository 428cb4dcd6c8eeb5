//! Tests of the settings as a client finds them: on the bus, in flash, and after a restart.

mod node;

use node::{MOTOR, Node, settings};
use std::path::PathBuf;
use tautrack::can::Frame;
use tautrack::link::Sensors;
use tautrack::settings::{Effect, FIRST_OBJECT, Setting, Settings, TABLE};

const NODE: u16 = 5;
const DEVICE_STATE: u32 = 0x0800_0022;
const SAVE: [u8; 4] = *b"save";
const LOAD: [u8; 4] = *b"load";

/// A node whose flash is a file.
struct Client {
    node: Node,
    steps: u32,
}

/// A path for a flash that does not exist yet.
fn blank(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.flash"));
    let _ = std::fs::remove_file(&path);
    path.into_os_string().into_string().expect("UTF-8")
}

impl Client {
    fn with(mut node: Node, flash: &str, settings: &[(u16, i32)]) -> Self {
        assert_eq!(node.start_with_flash(flash, settings, Some(MOTOR)), "");
        Self { node, steps: 0 }
    }

    /// Powers an axle up.
    fn new(flash: &str, settings: &[(u16, i32)]) -> Self {
        Self::with(Node::host("axle"), flash, settings)
    }

    fn send(&mut self, frames: &[Frame]) -> Vec<Frame> {
        self.steps += 1;
        let sensors = Sensors {
            supply_voltage: 24.0,
            ..Sensors::default()
        };
        self.node.step(sensors, frames).frames.to_vec()
    }

    /// Sends an SDO request; returns the answer's command and its last four bytes.
    fn sdo(&mut self, command: u8, index: u16, sub: u8, data: [u8; 4]) -> (u8, u32) {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = data;
        let request = Frame::new(0x600 + NODE, &[command, low, high, sub, a, b, c, d]);
        let answers = self.send(&[request.expect("a frame")]);
        let mut answers = answers.iter().filter(|frame| frame.id() == 0x580 + NODE);
        let data = answers.next().expect("an answer").data();
        assert_eq!(&data[1..4], [low, high, sub]);
        (
            data[0],
            u32::from_le_bytes(data[4..].try_into().expect("four")),
        )
    }

    fn read(&mut self, setting: Setting) -> i32 {
        let (command, value) = self.sdo(0x40, object(setting), 0, [0; 4]);
        assert_eq!(command, 0x43, "{value:#x}");
        value as i32
    }

    /// Writes an object; returns the abort code.
    fn write(&mut self, index: u16, sub: u8, data: [u8; 4]) -> Option<u32> {
        match self.sdo(0x23, index, sub, data) {
            (0x60, _) => None,
            (0x80, code) => Some(code),
            other => panic!("{other:x?}"),
        }
    }

    fn set(&mut self, setting: Setting, value: i32) -> Option<u32> {
        self.write(object(setting), 0, value.to_le_bytes())
    }

    /// Resets a fault, as of a heartbeat that ended, and leads the drive up to "operation enabled",
    /// with a guard's heartbeat.
    fn arm(&mut self) {
        self.send(&[Frame::new(0x000, &[1, 0]).expect("a frame")]);
        for step in 0..190 {
            let control = [0x80, 0x06, 0x07, 0x0f][(step / 40).min(3)];
            let data = [control, 0, 9, 0, 0, 0, 0];
            let set_point = Frame::new(0x300 + NODE, &data).expect("a frame");
            let heartbeat = Frame::new(0x701, &[5]).expect("a frame");
            // One set-point in each SYNC period.
            self.send(&[heartbeat, set_point][..if step % 4 == 0 { 2 } else { 1 }]);
        }
        let status = self.sdo(0x40, 0x6041, 0, [0; 4]).1 & 0x6f;
        assert_eq!(status, 0x27, "enabled");
    }

    fn disarm(&mut self) {
        for _ in 0..150 {
            let off = Frame::new(0x300 + NODE, &[0, 0, 9, 0, 0, 0, 0]).expect("a frame");
            self.send(&[off]);
        }
    }

    /// Object 2020.
    fn in_flash(&mut self, sub: u8) -> u32 {
        self.sdo(0x40, 0x2020, sub, [0; 4]).1
    }
}

fn object(setting: Setting) -> u16 {
    FIRST_OBJECT + setting.description().key
}

#[test]
fn every_setting_is_an_object_with_the_bounds_of_its_row() {
    let mut client = Client::new("", &settings(NODE.into()));
    let mut expected = Settings::default();
    for (key, value) in settings(NODE.into()) {
        expected.set(key, value).expect("a setting");
    }
    for row in TABLE {
        let setting = Setting::from_key(row.key).expect("a setting");
        assert_eq!(client.read(setting), expected.get(setting), "{}", row.name);
        for (value, code) in [
            (Some(row.minimum), None),
            (Some(row.maximum), None),
            (row.minimum.checked_sub(1), Some(0x0609_0032)),
            (row.maximum.checked_add(1), Some(0x0609_0031)),
        ] {
            if let Some(value) = value {
                assert_eq!(client.set(setting, value), code, "{} = {value}", row.name);
            }
        }
        assert_eq!(client.read(setting), row.maximum);
    }
    let unused = FIRST_OBJECT + 0xff;
    assert_eq!(client.sdo(0x40, unused, 0, [0; 4]), (0x80, 0x0602_0000));
    assert_eq!(client.write(unused, 0, [0; 4]), Some(0x0602_0000));
    // A setting has four bytes.
    let current_limit = object(Setting::CurrentLimit);
    assert_eq!(
        client.sdo(0x2b, current_limit, 0, [0; 4]),
        (0x80, 0x0607_0013)
    );
}

#[test]
fn a_saved_setting_survives_a_power_cycle_and_an_unsaved_one_does_not() {
    for board in ["host", "mps2"] {
        let flash = blank(&format!("power-cycle-{board}"));
        let start = |settings: &[(u16, i32)]| {
            let node = match board {
                "host" => Node::host("axle"),
                _ => Node::emulated("axle"),
            };
            Client::with(node, &flash, settings)
        };
        let mut client = start(&settings(NODE.into()));
        assert_eq!(client.in_flash(1), 0, "blank at start");
        assert_eq!(client.in_flash(7), 0, "no restart is needed");
        assert_eq!(client.set(Setting::VelocityGain, 1_234), None);
        assert_eq!(client.in_flash(7), 0, "the node uses it already");
        assert_eq!(client.set(Setting::FollowingLimit, 400), None);
        assert_eq!(client.in_flash(7), 1, "a restart is needed");
        assert_eq!(client.write(0x1010, 1, SAVE), None);
        assert_eq!(client.set(Setting::PositionGain, 4_321), None);
        drop(client);
        // The start message fills blank flash alone: this one has another gear and another id.
        let mut other = settings(77);
        other.push((Setting::GearRatio.description().key, 1_000));
        let mut client = start(&other);
        assert_eq!(client.in_flash(1), 1, "loaded");
        assert_eq!(client.read(Setting::VelocityGain), 1_234);
        assert_eq!(client.read(Setting::FollowingLimit), 400);
        assert_eq!(client.read(Setting::PositionGain), 20_000);
        assert_eq!(client.read(Setting::GearRatio), 50_000);
    }
}

#[test]
fn a_save_is_refused_while_the_motor_has_current() {
    let flash = blank("armed");
    let mut client = Client::new(&flash, &settings(NODE.into()));
    client.arm();
    // A gain may be changed, and a limit only downward.
    assert_eq!(client.set(Setting::VelocityGain, 1_234), None);
    assert_eq!(
        client.set(Setting::CurrentLimit, 20_001),
        Some(DEVICE_STATE)
    );
    assert_eq!(client.set(Setting::CurrentLimit, 19_000), None);
    let before = std::fs::read(&flash).expect("the flash");
    assert_eq!(client.write(0x1010, 1, SAVE), Some(DEVICE_STATE));
    assert_eq!(client.write(0x1011, 1, LOAD), Some(DEVICE_STATE));
    assert_eq!(std::fs::read(&flash).expect("the flash"), before);
    client.disarm();
    assert_eq!(client.write(0x1010, 1, *b"evas"), Some(0x0800_0020));
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    assert_ne!(std::fs::read(&flash).expect("the flash"), before);
}

#[test]
fn a_flash_that_cannot_be_written_refuses_the_save() {
    let folder = blank("no-folder");
    let mut client = Client::new("", &settings(NODE.into()));
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    let mut node = Node::host("axle");
    let path = format!("{folder}/missing/axle.flash");
    let refusal = node.start_with_flash(&path, &settings(NODE.into()), Some(MOTOR));
    assert!(refusal.contains("flash refused"), "{refusal}");
}

#[test]
fn a_value_out_of_bounds_in_flash_is_refused_alone_and_named() {
    let flash = blank("refused");
    drop(Client::new(&flash, &settings(NODE.into())));
    // Writes the value as a later program with wider bounds would.
    let row = Setting::PositionBits.description();
    assert!(row.maximum < 99);
    let bytes = std::fs::read(&flash).expect("the flash");
    std::fs::write(&flash, with_value(&bytes, row.key, 99)).expect("written");
    let mut client = Client::new(&flash, &[]);
    assert_eq!(client.in_flash(1), 4, "partly refused");
    assert_eq!(client.in_flash(4), 1);
    assert_eq!(client.in_flash(5), u32::from(row.key));
    assert_eq!(client.in_flash(6), 99);
    assert_eq!(client.read(Setting::PositionBits), row.default);
    assert_eq!(client.read(Setting::GearRatio), 50_000, "the others load");
    // The guard does not arm with it, until the setting is set: to its default, too.
    assert_eq!(scale(&mut client), 0x8000 | 16);
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!(client.in_flash(1), 4, "the value stays in flash");
    assert_eq!(client.set(Setting::PositionBits, row.default), None);
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!((client.in_flash(1), scale(&mut client)), (1, 16));
}

/// Object 2010.
fn scale(client: &mut Client) -> u32 {
    client.sdo(0x40, 0x2010, 0, [0; 4]).1
}

/// Bandwidth of the current loop within its bounds, but too high for the PWM of the board.
const UNUSABLE: i32 = 20_000;

#[test]
fn settings_with_which_the_node_would_not_start_are_not_saved() {
    let flash = blank("unusable");
    let mut client = Client::new(&flash, &settings(NODE.into()));
    let before = std::fs::read(&flash).expect("the flash");
    assert_eq!(client.set(Setting::CurrentBandwidth, UNUSABLE), None);
    assert_eq!(client.write(0x1010, 1, SAVE), Some(0x0604_0043));
    assert_eq!(std::fs::read(&flash).expect("the flash"), before);
    assert_eq!(client.set(Setting::CurrentBandwidth, 3_000), None);
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!(client.read(Setting::CurrentBandwidth), 3_000);
}

#[test]
fn refused_settings_of_a_scenario_do_not_fill_the_flash() {
    let flash = blank("refused-scenario");
    let mut refused = settings(NODE.into());
    refused.push((Setting::CurrentBandwidth.description().key, UNUSABLE));
    let mut node = Node::host("axle");
    let refusal = node.start_with_flash(&flash, &refused, Some(MOTOR));
    assert!(refusal.contains("current loop"), "{refusal}");
    // The scenario is corrected.
    let mut client = Client::new(&flash, &settings(NODE.into()));
    assert_eq!(client.read(Setting::CurrentBandwidth), 4_000);
}

#[test]
fn a_file_that_is_no_flash_is_refused_and_stays() {
    for board in ["host", "mps2"] {
        for length in [0, 100, 8_191, 8_193] {
            let path = blank(&format!("no-flash-{board}"));
            let bytes = vec![0xff; length];
            std::fs::write(&path, &bytes).expect("written");
            let mut node = match board {
                "host" => Node::host("axle"),
                _ => Node::emulated("axle"),
            };
            let refusal = node.start_with_flash(&path, &settings(NODE.into()), Some(MOTOR));
            assert!(refusal.contains("length"), "{refusal}");
            assert_eq!(std::fs::read(&path).expect("the file"), bytes);
        }
    }
}

#[test]
fn a_node_whose_flash_cannot_be_read_waits_for_an_id_like_a_blank_one() {
    let flash = blank("unreadable");
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let bytes: Vec<u8> = (0..8_192).map(|_| random()).collect();
    std::fs::write(&flash, bytes).expect("written");
    let mut client = Client::new(&flash, &settings(NODE.into()));
    assert_eq!((0..300).find(|_| !client.send(&[]).is_empty()), None);
    let requests = [
        [4, 1, 0, 0, 0, 0, 0, 0],
        [0x11, NODE as u8, 0, 0, 0, 0, 0, 0],
        [0x17, 0, 0, 0, 0, 0, 0, 0],
        [4, 0, 0, 0, 0, 0, 0, 0],
    ];
    for request in requests {
        let frames = client.send(&[Frame::new(0x7e5, &request).expect("a frame")]);
        let mut answers = frames.iter().filter(|frame| frame.id() == 0x7e4);
        assert!(answers.all(|frame| frame.data()[1] == 0), "{frames:?}");
    }
    client.send(&[]);
    assert_eq!(client.in_flash(1), 5, "it tells why");
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!((client.in_flash(1), scale(&mut client)), (1, 0x8010));
    assert_eq!(client.read(Setting::NodeId), i32::from(NODE));
}

/// Saves one more value in a flash, without bounds.
fn with_value(bytes: &[u8], key: u16, value: i32) -> Vec<u8> {
    use tautrack::settings::Bounds;
    use tautrack::store::{SCHEMA, Schema, Store};
    let row = Bounds {
        key,
        minimum: i32::MIN,
        maximum: i32::MAX,
        default: 0,
    };
    let schema = Schema {
        row: &|index| (index == 0).then_some(row),
        ..SCHEMA
    };
    let mut flash = memory::Flash(bytes.to_vec());
    let mut store = Store::open(&mut flash).expect("a store");
    store.save(&schema, &|_| value, &|_| true).expect("saved");
    flash.0
}

mod memory {
    //! Flash in memory.

    use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

    pub struct Flash(pub Vec<u8>);

    impl ErrorType for Flash {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for Flash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.0.len()
        }
    }

    impl NorFlash for Flash {
        const WRITE_SIZE: usize = 8;
        const ERASE_SIZE: usize = 2_048;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            self.0[from as usize..to as usize].fill(0xff);
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
            Ok(())
        }
    }
}

#[test]
fn a_blank_node_is_mute_until_lss_gives_it_an_id_which_survives() {
    let flash = blank("unconfigured");
    let mut client = Client::new(&flash, &[]);
    let lss = |data: [u8; 8]| Frame::new(0x7e5, &data).expect("a frame");
    // Neither a heartbeat, nor process data, nor an answer to node 127 or any other.
    for step in 0..300_u16 {
        let read = Frame::new(0x601 + step % 127, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        let others = [(0x000, &[1, 0][..]), (0x080, &[]), (0x701, &[5])]
            .map(|(id, data)| Frame::new(id, data).expect("a frame"));
        let mut frames = others.to_vec();
        frames.push(read.expect("a frame"));
        assert_eq!(client.send(&frames), []);
    }
    let answer = |client: &mut Client, data| {
        let frames = client.send(&[lss(data)]);
        frames
            .first()
            .map(|frame| (frame.id(), frame.data()[0], frame.data()[1]))
    };
    // Another node is selected: this one stays mute. Its serial number is 11, the seed.
    let product = 1;
    for serial in [12, 11] {
        for (command, number) in [(0x40, 0), (0x41, product), (0x42, 1)] {
            assert_eq!(
                answer(&mut client, [command, number, 0, 0, 0, 0, 0, 0]),
                None
            );
        }
        let selected = answer(&mut client, [0x43, serial, 0, 0, 0, 0, 0, 0]);
        assert_eq!(selected, (serial == 11).then_some((0x7e4, 0x44, 0)));
    }
    let configured = answer(&mut client, [0x11, NODE as u8, 0, 0, 0, 0, 0, 0]);
    assert_eq!(configured, Some((0x7e4, 0x11, 0)));
    let stored = answer(&mut client, [0x17, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(stored, Some((0x7e4, 0x17, 0)));
    client.send(&[lss([4, 0, 0, 0, 0, 0, 0, 0])]);
    let boot_up = client.send(&[]);
    let id = |client: &mut Client| client.read(Setting::NodeId);
    assert_eq!(id(&mut client), i32::from(NODE), "{boot_up:?}");
    let serial = client.sdo(0x40, 0x1018, 4, [0; 4]);
    assert_eq!(serial, (0x43, 11));
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!(id(&mut client), i32::from(NODE));
    // Its motor is unknown: low current and speed. The guard does not arm with its scale.
    assert_eq!(client.sdo(0x40, 0x2010, 0, [0; 4]).1, 0x8000 | 16);
    assert_eq!(client.read(Setting::CurrentLimit), 1_000);
    assert_eq!(client.read(Setting::VelocityLimit), 500);
    assert_eq!(client.in_flash(1), 1, "loaded");
    assert_eq!(client.set(Setting::GearRatio, 1_000), None);
    assert_eq!(client.write(0x1010, 1, SAVE), None);
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!(client.sdo(0x40, 0x2010, 0, [0; 4]).1, 16);
    // Restoring the defaults makes it blank again.
    assert_eq!(client.write(0x1011, 1, LOAD), None);
    drop(client);
    let mut client = Client::new(&flash, &[]);
    assert_eq!((0..200).find(|_| !client.send(&[]).is_empty()), None);
}

#[test]
fn a_restarted_drive_has_the_gains_and_limits_that_were_saved_last() {
    let live: Vec<_> = Setting::live().collect();
    let board_limited = [Setting::CurrentLimit, Setting::VelocityLimit];
    let mut state = 7_u32;
    let mut below = |end: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as usize % end
    };
    for run in 0..4 {
        let flash = blank(&format!("live-{run}"));
        let mut client = Client::new(&flash, &settings(NODE.into()));
        let mut expected: Vec<_> = live.iter().map(|it| client.read(*it)).collect();
        let mut saved = expected.clone();
        for _ in 0..40 {
            let armed = below(4) == 0;
            if armed {
                client.arm();
            }
            for _ in 0..below(5) {
                let index = below(live.len());
                let value = (f64::from(expected[index]) * [0.5, 0.9, 1.1][below(3)]) as i32;
                let row = live[index].bounds();
                let refused = client.set(live[index], value);
                let raises = armed
                    && match live[index].effect() {
                        Effect::Limit => value > expected[index],
                        Effect::Disarmed => true,
                        _ => false,
                    };
                let within = (row.minimum..=row.maximum).contains(&value);
                if raises {
                    assert!(refused.is_some(), "{:?} = {value}", live[index]);
                } else if within && !armed && !board_limited.contains(&live[index]) {
                    assert_eq!(refused, None, "{:?} = {value}", live[index]);
                }
                if refused.is_none() {
                    expected[index] = value;
                }
                assert_eq!(client.read(live[index]), expected[index]);
            }
            if armed {
                assert_eq!(client.write(0x1010, 1, SAVE), Some(DEVICE_STATE));
                client.disarm();
            }
            if below(3) == 0 {
                assert_eq!(client.write(0x1010, 1, SAVE), None);
                saved.clone_from(&expected);
            }
            if below(4) == 0 {
                drop(client);
                client = Client::new(&flash, &[]);
                expected.clone_from(&saved);
            }
            for (setting, value) in live.iter().zip(&expected) {
                assert_eq!(client.read(*setting), *value, "{setting:?}");
            }
            assert_eq!(client.in_flash(7), 0, "no restart is needed");
        }
    }
}
