//! A drive's node as a value on a CANopen bus: what it sends, and when.

mod any_frame;
mod conformance;
mod exchange;
mod guard;

pub use crate::conformance::NODE;
use tautrack::bus::network::NmtState;
use tautrack::can::Frame;
use tautrack::motor::bridge::Ratings;
use tautrack::motor::capture::{Capture, Request};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{
    BridgeDemand, CurrentLoop, Electrical, Excitation, Means, Measurement,
};
use tautrack::node::axle::Axle;
use tautrack::node::screw::Screw;
use tautrack::roles::drive::{Control, Drive, Measurements, Motor, Parts, Readings};
use tautrack::roles::settings::{Found, SaveError, Store};
use tautrack::screw::Geometry;
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{SettingError, Settings};

/// Serial number of the boards.
pub const SERIAL: u32 = 7;
static RATINGS: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 40.0,
    highest_supply: 36.0,
};

/// Settings of a client, without flash, and whether one was changed that needs a restart.
pub struct Memory(pub Settings, bool);

impl Store for Memory {
    fn value(&self, key: u16) -> Option<i32> {
        self.0.of_key(key)
    }

    fn set(&mut self, key: u16, value: i32, live: bool) -> Result<(), SettingError> {
        self.0.set(key, value)?;
        self.1 |= !live;
        Ok(())
    }

    fn save(&mut self) -> Result<(), SaveError> {
        Ok(())
    }

    fn clear(&mut self) -> Result<(), SaveError> {
        Ok(())
    }

    fn found(&self) -> Found {
        Found::default()
    }

    fn restart_needed(&self) -> bool {
        self.1
    }

    fn unconfigured(&self) -> bool {
        false
    }
}

/// A motor without current, whose rotor is at this count.
#[derive(Default)]
pub struct Rotor(pub i32);

impl Motor for Rotor {
    fn readings(&mut self) -> Readings {
        Readings {
            encoder: self.0,
            encoder_broken: false,
            bridge_stop: None,
            means: Some(Means {
                current: 0.0,
                electrical: Electrical::default(),
            }),
            supply_voltage: 24.0,
            temperatures: Temperatures::default(),
            switches: Switches::default(),
        }
    }

    fn install(&mut self, _: CurrentLoop) {}

    fn set_limits(&mut self, _: &Settings) {}

    fn set_cogging(&mut self, _: i32, _: Wave) {}

    fn demand(&mut self, _: BridgeDemand, _: f32, _: f32) {}

    fn excite(&mut self, _: &Excitation, _: f32) {}

    fn take_measurement(&mut self, _: f32) -> Option<Measurement> {
        None
    }

    fn set_brake(&mut self, _: bool) {}

    fn capture<R>(&mut self, _: impl FnOnce(&mut Capture) -> R) -> Option<R> {
        None
    }

    fn request_capture(&mut self, _: Request) {}
}

/// A node, its motor, and the time.
pub struct Node<C> {
    create: fn() -> Drive<C, Measurements, Memory>,
    drive: Drive<C, Measurements, Memory>,
    pub rotor: Rotor,
    pub now_us: u64,
}

impl Node<Axle> {
    /// A node of an axle after its boot-up message.
    pub fn axle() -> Self {
        Self::boot(|| {
            let settings = settings();
            Drive::axle(parts(&settings, Axle::new(&settings)))
        })
    }
}

impl Node<Screw<Geometry>> {
    /// A node of a screw after its boot-up message.
    pub fn screw() -> Self {
        Self::boot(|| {
            let settings = settings();
            let screw = Screw::new(&settings).expect("a belt");
            Drive::screw(parts(&settings, screw))
        })
    }
}

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.set(1, i32::from(NODE)).expect("a node id");
    settings
}

/// What a drive's node is made of, without flash.
pub fn parts<C>(settings: &Settings, control: C) -> Parts<'_, C, Measurements, Memory> {
    Parts {
        settings,
        control,
        measurements: Measurements::new(settings, &RATINGS),
        store: Memory(settings.clone(), false),
        serial: SERIAL,
        ratings: &RATINGS,
    }
}

/// A node that is tested.
pub trait Subject {
    /// Runs one millisecond with a control tick, or without. Returns what the node sends. A node
    /// that is to restart begins anew.
    fn run(&mut self, tick: bool) -> Vec<Frame>;
    /// Returns what the node sends because of a frame.
    fn receive(&mut self, id: u16, data: &[u8]) -> Vec<Frame>;
    /// Turns the rotor of a drive.
    fn turn(&mut self);
}

impl<C: Control> Node<C> {
    fn boot(create: fn() -> Drive<C, Measurements, Memory>) -> Self {
        let (mut drive, mut sent) = (create(), Vec::new());
        drive.boot(0, &mut |frame| sent.push(frame));
        assert_eq!(sent, [Frame::new(0x700 + NODE, &[0]).unwrap()]);
        Self {
            create,
            drive,
            rotor: Rotor::default(),
            now_us: 0,
        }
    }

    pub fn state(&self) -> NmtState {
        self.drive.state()
    }
}

impl<C: Control> Subject for Node<C> {
    fn turn(&mut self) {
        self.rotor.0 += 20;
    }

    fn run(&mut self, tick: bool) -> Vec<Frame> {
        let mut sent = Vec::new();
        self.now_us += 1_000;
        if tick {
            let mut send = |frame| sent.push(frame);
            let ticked = self.drive.tick(self.now_us, &mut self.rotor, &mut send);
            if ticked.restart {
                self.drive = (self.create)();
                self.drive.boot(self.now_us, &mut send);
            }
        }
        sent
    }

    fn receive(&mut self, id: u16, data: &[u8]) -> Vec<Frame> {
        let mut sent = Vec::new();
        let frame = Frame::new(id, data).expect("a frame");
        self.drive
            .receive(&frame, self.now_us, &mut |frame| sent.push(frame));
        sent
    }
}

#[test]
fn a_node_whose_ticks_stop_sends_neither_heartbeat_nor_process_data() {
    let mut node = Node::axle();
    node.receive(0x000, &[1, 0]);
    let mut second = |ticks: bool| {
        let sent: Vec<_> = (0..1_000).flat_map(|_| node.run(ticks)).collect();
        let beats = sent.iter().filter(|frame| frame.id() == 0x700 + NODE);
        (beats.count(), node.receive(0x080, &[]).len())
    };
    assert_eq!(second(true), (20, 1), "every 50 ms, and the position");
    assert_eq!(second(false), (0, 0));
    assert_eq!(second(true).1, 1);
}
