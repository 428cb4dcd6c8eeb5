//! Counts whole ticks of the axle, the screw and B2P2's guard. Axle and screw run in closed loop
//! with a simple model of a shaft.

use super::counter::{Count, Table, instructions};
use super::inputs::{Random, settings};
use super::traffic::{Source, Traffic};
use core::f32::consts::TAU;
use core::hint::black_box;
use heapless::Vec;
use tautrack::bus::cia402::{controlword, mode, status};
use tautrack::bus::network::sync;
use tautrack::bus::pdo::{DriveMotion, DriveStatus, OperatorCommand, Payload, transmit};
use tautrack::can::Frame;
use tautrack::motor::current::Electrical;
use tautrack::node::axle::{self, Axle, BridgeDemand, SetPoint};
use tautrack::node::guard::{self, Guard};
use tautrack::node::screw::{self, Screw};
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack::screw::Geometry;
use tautrack::sensors::{BodySensors, Switches, Temperatures};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// Ticks before counting starts, in which the node starts up.
const WARM_UP: u32 = 400;
/// The same for the guard, which is armed half a second after its first reading.
const GUARD_WARM_UP: u32 = 1_000;
/// Ticks from one SYNC to the next.
const SYNC_TICKS: u32 = 4;

pub fn count(table: &mut Table) {
    count_axle(table);
    count_screw(table);
    count_guard(table, Traffic::Quiet);
    count_guard(table, Traffic::Busy);
}

/// Model of an output shaft: inertia 0.05 kg m^2, torque 2.4 N m per ampere, encoder as in the
/// nominal settings.
#[derive(Default)]
struct Shaft {
    angle: f32,
    velocity: f32,
    current: f32,
}

impl Shaft {
    fn step(&mut self, bridge: BridgeDemand) {
        self.current = match bridge {
            BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => current,
            _ => 0.0,
        };
        self.velocity += (2.4 * self.current - 0.5 * self.velocity) / 0.05 * 1e-3;
        self.angle += self.velocity * 1e-3;
    }

    fn inputs(&self, tick: u32, set_point: Option<SetPoint>, random: &mut Random) -> axle::Inputs {
        axle::Inputs {
            now_us: u64::from(tick) * 1_000,
            encoder: (self.angle * (4_096.0 * 60.0 / TAU)) as i32,
            encoder_broken: false,
            current: self.current + random.within(0.1),
            // Some samples are out of range, but never long enough for the dwell time of a fault.
            supply_voltage: if tick.is_multiple_of(37) {
                40.0
            } else {
                24.0 + random.within(1.0)
            },
            electrical: Electrical {
                voltage: Some([0.0, 2.4 * self.velocity + 0.6 * self.current]),
                ..Electrical::default()
            },
            temperatures: Temperatures::default(),
            switches: Switches {
                home: tick % 64 < 32,
                ..Switches::default()
            },
            set_point,
            // Comes half a SYNC period after a set-point.
            torque_offset: (tick % 16 == 2).then_some((random.bits() >> 16) as i16),
            guard_received: tick.is_multiple_of(50),
            bench_mode: false,
        }
    }
}

/// Returns the controlwords that enable a drive: "shutdown" and "switch on" for one SYNC period
/// each, then "enable operation".
fn word(tick: u32) -> u16 {
    match tick / SYNC_TICKS {
        0 => controlword::SHUTDOWN,
        1 => controlword::SWITCH_ON,
        _ => controlword::ENABLE_OPERATION,
    }
}

/// Returns the nominal settings with higher limits: those of an axle that needs no homing and is
/// fast enough for the screw.
fn drive_settings() -> Settings {
    let mut settings = settings();
    for (setting, value) in [
        (Setting::VelocityLimit, 60_000),
        (Setting::FollowingLimit, 100_000),
    ] {
        let _ = settings.set(setting.description().key, value); // cannot fail: within the bounds
    }
    settings
}

fn count_axle(table: &mut Table) {
    struct Rig {
        axle: Axle,
        shaft: Shaft,
        bridge: BridgeDemand,
    }
    let mut rig = Rig {
        axle: Axle::new(&drive_settings()),
        shaft: Shaft::default(),
        bridge: BridgeDemand::Off,
    };
    let modes = [
        mode::CYCLIC_POSITION,
        mode::CYCLIC_VELOCITY,
        mode::PROFILE_POSITION,
        mode::PROFILE_VELOCITY,
        mode::HOMING,
    ];
    let mut tick = 0;
    let mut inputs = |rig: &mut Rig, random: &mut Random| {
        let mode = modes[(tick / SYNC_TICKS) as usize / 2 % modes.len()];
        let set_point = tick.is_multiple_of(SYNC_TICKS).then(|| SetPoint {
            // In homing mode, every second set-point starts homing (bit 4).
            controlword: word(tick) | (((tick / SYNC_TICKS) & 1) as u16) << 4,
            mode,
            target: match mode {
                mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY => random.bits() >> 8,
                _ => (rig.shaft.angle * (65_536.0 / TAU)) as i32 + (random.bits() >> 22),
            },
        });
        let inputs = rig.shaft.inputs(tick, set_point, random);
        tick += 1;
        inputs
    };
    let act = |rig: &mut Rig, inputs: &axle::Inputs| {
        rig.bridge = black_box(&rig.axle.tick(inputs)).bridge;
    };
    let mut random = Random::new();
    let mut count = Count::NONE;
    for call in 0..WARM_UP + table.calls() {
        let inputs = inputs(&mut rig, &mut random);
        if call < WARM_UP {
            act(&mut rig, &inputs);
        } else {
            count.take(instructions(&mut rig, &inputs, act));
        }
        rig.shaft.step(rig.bridge);
    }
    table.write(
        "axle tick",
        &count,
        act as fn(&mut Rig, &'static axle::Inputs) as usize,
    );
}

fn count_screw(table: &mut Table) {
    struct Rig {
        screw: Screw,
        shaft: Shaft,
        bridge: BridgeDemand,
    }
    let Ok(screw) = Screw::new(&drive_settings()) else {
        return; // the nominal geometry is valid; otherwise the host finds no entry
    };
    let mut rig = Rig {
        screw,
        shaft: Shaft::default(),
        bridge: BridgeDemand::Off,
    };
    let act = |rig: &mut Rig, inputs: &screw::Inputs| {
        rig.bridge = black_box(&rig.screw.tick(inputs)).bridge;
    };
    let mut random = Random::new();
    let mut count = Count::NONE;
    for tick in 0..WARM_UP + table.calls() {
        let sync = tick.is_multiple_of(SYNC_TICKS);
        let set_point = sync.then(|| SetPoint {
            controlword: word(tick),
            mode: mode::TAUT,
            target: 0,
        });
        let inputs = screw::Inputs {
            axle: rig.shaft.inputs(tick, set_point, &mut random),
            joint: (tick % SYNC_TICKS == 1).then(|| (joint(tick), u64::from(tick) * 1_000 - 1_000)),
            slack: if tick % 256 < 128 { 0 } else { 200_000 },
        };
        if tick < WARM_UP {
            act(&mut rig, &inputs);
        } else {
            count.take(instructions(&mut rig, &inputs, act));
        }
        rig.shaft.step(rig.bridge);
    }
    table.write(
        "screw tick",
        &count,
        act as fn(&mut Rig, &'static screw::Inputs) as usize,
    );
}

/// Returns the chassis joint's motion: back and forth between -1 and 1 rad at 0.5 rad/s.
fn joint(tick: u32) -> DriveMotion {
    let phase = (tick % 8_000) as f32 * 0.5e-3;
    let (angle, velocity) = if phase < 2.0 {
        (phase - 1.0, 500_000)
    } else {
        (3.0 - phase, -500_000)
    };
    DriveMotion {
        position: Angle::from_radians(angle).to_bits(),
        velocity,
    }
}

/// Returns the frames that the four drives of a standing or driving robot send in answer to a SYNC.
fn answers(tick: u32, geometry: &Geometry, settings: &Settings) -> Vec<Frame, 12> {
    let joint = joint(tick);
    let taut = geometry.length(Angle::from_bits(joint.position)).to_bits() >> 4;
    let track = DriveMotion {
        position: (tick as i32) << 8,
        velocity: 2_000_000,
    };
    let screw = DriveMotion {
        position: taut,
        velocity: 0,
    };
    let status = DriveStatus {
        statusword: super::guards::drive_state(tick).statusword() | status::HOMED,
        ..DriveStatus::default()
    };
    let drives = [
        (Setting::LeftId, track),
        (Setting::RightId, track),
        (Setting::JointId, joint),
        (Setting::ScrewId, screw),
    ];
    let mut frames = Vec::new();
    for (id, motion) in drives {
        let id = settings.id(id);
        let heartbeat = Frame::new(0x700 + u16::from(id), &[5]).unwrap_or_default();
        // There is room for exactly these twelve frames.
        let _ = frames.push(motion.frame(transmit(1), id));
        let _ = frames.push(status.frame(transmit(2), id));
        let _ = frames.push(heartbeat);
    }
    frames
}

/// Guard in open loop: the frames of the four drives and the operator do not depend on its outputs.
#[derive(Clone)]
struct GuardRig {
    guard: Guard<B2p2>,
}

impl GuardRig {
    fn tick(&mut self, inputs: guard::Inputs<'_>) {
        self.guard.tick(&inputs);
    }
}

fn count_guard(table: &mut Table, traffic: Traffic) {
    let settings = settings();
    let ids = B2p2::drive_ids(&settings);
    let [l1, l2, k] = [Setting::LengthL1, Setting::LengthL2, Setting::LengthK]
        .map(|setting| settings.get(setting));
    let (Ok(mut guard), Ok(geometry)) = (
        Guard::<B2p2>::new(&settings),
        Geometry::from_micrometres(l1, l2, k),
    ) else {
        return; // the nominal geometry is valid; otherwise the host finds no entries
    };
    guard.tick(&guard::Inputs {
        now_us: 0,
        body: None,
        operator: None,
        emergency_stop: false,
        frames: &[],
        serial: &[],
    });
    let mut rig = GuardRig { guard };
    let (mut random, mut source) = (Random::new(), Source::new(traffic));
    // Builds the inputs of one tick and passes them to `act`.
    let mut tick =
        |tick: u32, rig: &mut GuardRig, act: &mut dyn FnMut(&mut GuardRig, guard::Inputs<'_>)| {
            // The answers of the drives fill the bus in their tick.
            let frames: Vec<Frame, 12> = if tick % SYNC_TICKS == 1 {
                answers(tick, &geometry, &settings)
            } else {
                let others = source.frames(settings.id(Setting::NodeId), &ids);
                others.into_iter().collect()
            };
            let serial = source.bytes();
            let operator = (tick % 20 == 3).then(|| OperatorCommand {
                forward: (random.bits() >> 23) as i16,
                yaw_rate: if tick % 40 == 3 {
                    0
                } else {
                    (random.bits() >> 24) as i16
                },
                posture: (random.bits() >> 18) as i16,
                request: super::guards::request(tick) as u8,
                sequence: tick as u8,
            });
            let body = BodySensors {
                inclination: [random.within(0.5), random.within(0.2)],
                specific_force: [random.within(2.0), random.within(2.0), 9.81],
                angular_rate: [random.within(1.0), random.within(1.0), random.within(1.0)],
                magnetic_field: [random.within(20.0), random.within(20.0), -42.0],
                ..BodySensors::default()
            };
            let inputs = guard::Inputs {
                now_us: u64::from(tick) * 1_000,
                body: Some(body),
                operator,
                emergency_stop: false,
                frames: &frames,
                serial: &serial,
            };
            act(rig, inputs);
        };
    super::guards::answer_scales(&mut rig.guard, &settings);
    for number in SYNC_TICKS..GUARD_WARM_UP {
        tick(number, &mut rig, &mut |rig, inputs| rig.tick(inputs));
    }
    // The tick after a SYNC receives the most frames, because all drives answer then.
    let names = match traffic {
        Traffic::Quiet => [
            "guard tick with SYNC",
            "guard tick with frames",
            "guard tick that evaluates",
            "guard tick that updates the estimate",
        ],
        Traffic::Busy => [
            "guard tick with SYNC, busy",
            "guard tick with frames, busy",
            "guard tick that evaluates, busy",
            "guard tick that updates the estimate, busy",
        ],
    };
    for (name, phase) in names.into_iter().zip(0..) {
        let (mut rig, mut count, mut armed) = (rig.clone(), Count::NONE, true);
        for number in GUARD_WARM_UP..GUARD_WARM_UP + SYNC_TICKS * table.calls() {
            if number % SYNC_TICKS != phase {
                tick(number, &mut rig, &mut |rig, inputs| rig.tick(inputs));
                continue;
            }
            tick(number, &mut rig, &mut |rig, inputs| {
                count.take(instructions(rig, inputs, GuardRig::tick));
            });
            armed &= rig.guard.outputs().state.state == guard::State::Armed.code();
            armed &= (rig.guard.outputs().frames.first() == Some(&sync())) == (phase == 0);
        }
        // If the robot was not armed all the time, or SYNC came in another tick, the counts are not
        // those of the named tick. No entry is written then, and the host reports it missing.
        if armed {
            table.write(
                name,
                &count,
                GuardRig::tick as fn(&mut GuardRig, guard::Inputs<'_>) as usize,
            );
        }
    }
}
