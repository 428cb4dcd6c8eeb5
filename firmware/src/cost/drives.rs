//! Counts whole ticks of the axle and the screw, in closed loop with a simple model of a shaft.

use super::counter::Table;
use super::inputs::{Random, settings};
use core::f32::consts::TAU;
use tautrack::bus::cia402::{controlword, mode};
use tautrack::bus::pdo::DriveMotion;
use tautrack::motor::current::Electrical;
use tautrack::node::axle::{self, Axle, BridgeDemand, SetPoint};
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// Ticks from one SYNC to the next.
const SYNC_TICKS: u32 = 4;

/// Modes of the axle in turn.
const MODES: [i8; 5] = [
    mode::CYCLIC_POSITION,
    mode::CYCLIC_VELOCITY,
    mode::PROFILE_POSITION,
    mode::PROFILE_VELOCITY,
    mode::HOMING,
];

pub fn count(table: &mut Table) -> Option<()> {
    count_axle(table)?;
    count_screw(table)
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
            bridge_stop: None,
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

/// Returns the settings of an axle that needs no homing and is fast enough for the screw.
fn drive_settings() -> Option<Settings> {
    settings(&[
        (Setting::VelocityLimit, 60_000),
        (Setting::FollowingLimit, 100_000),
    ])
}

fn count_axle(table: &mut Table) -> Option<()> {
    let shaft = Shaft::default();
    let inputs = shaft.inputs(0, None, &mut Random::new());
    table.kernel(
        "axle tick",
        &mut (
            Axle::new(&drive_settings()?),
            inputs,
            shaft,
            BridgeDemand::Off,
        ),
        |(_, inputs, shaft, bridge), tick, random| {
            shaft.step(*bridge);
            let mode = MODES[(tick / SYNC_TICKS) as usize / 2 % MODES.len()];
            let set_point = tick.is_multiple_of(SYNC_TICKS).then(|| SetPoint {
                // In homing mode, every second set-point starts homing (bit 4).
                controlword: word(tick) | (((tick / SYNC_TICKS) & 1) as u16) << 4,
                mode,
                target: match mode {
                    mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY => random.bits() >> 8,
                    _ => (shaft.angle * (65_536.0 / TAU)) as i32 + (random.bits() >> 22),
                },
            });
            *inputs = shaft.inputs(tick, set_point, random);
        },
        |(axle, inputs, _, bridge)| *bridge = axle.tick(inputs).bridge,
    )
}

fn count_screw(table: &mut Table) -> Option<()> {
    let shaft = Shaft::default();
    let inputs = screw::Inputs {
        axle: shaft.inputs(0, None, &mut Random::new()),
        joint: None,
    };
    let screw = Screw::new(&drive_settings()?).ok()?;
    table.kernel(
        "screw tick",
        &mut (screw, inputs, shaft, BridgeDemand::Off),
        |(_, inputs, shaft, bridge), tick, random| {
            shaft.step(*bridge);
            let set_point = tick.is_multiple_of(SYNC_TICKS).then(|| SetPoint {
                controlword: word(tick),
                mode: if tick % 256 < 128 {
                    mode::TAUT
                } else {
                    mode::RELEASED
                },
                target: 200_000,
            });
            let measured_us = u64::from(tick).saturating_sub(1) * 1_000;
            *inputs = screw::Inputs {
                axle: shaft.inputs(tick, set_point, random),
                joint: (tick % SYNC_TICKS == 1).then(|| (joint(tick), measured_us)),
            };
        },
        |(screw, inputs, _, bridge)| *bridge = screw.tick(inputs).bridge,
    )
}

/// Returns the chassis joint's motion: from -1 to 1 rad at 0.5 rad/s in 4000 ticks.
pub fn joint(tick: u32) -> DriveMotion {
    DriveMotion {
        position: Angle::from_radians(tick as f32 * 0.5e-3 - 1.0).to_bits(),
        velocity: 500_000,
    }
}
