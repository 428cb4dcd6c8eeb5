//! Counts the current loop of a motor with three phases. It keeps its state from call to call.

use super::counter::Table;
use crate::boards::{Board, Selected};
use crate::current_loop;
use core::hint::black_box;
use tautrack::motor::bridge::Readings;
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::foc::Dq;
use tautrack::motor::current::{Config, CurrentLoop, MotorKind, OperatingPoint};
use tautrack::motor::rotor::{ElectricalAngle, Mounting, RotorSensor};
use tautrack::node::axle::BridgeDemand;
use tautrack::units::Angle;

const CONFIG: Config = Config {
    kind: MotorKind::ThreePhase,
    resistance: 0.6,
    inductance: [3e-4, 3.6e-4],
    torque_constant: 0.04,
    current_limit: 10.0,
    bandwidth: 4_000.0,
    gear_ratio: 60.0,
    mounting: Mounting {
        counts_per_turn: 4_096,
        pole_pairs: 7,
        offset: ElectricalAngle(Angle::from_bits(477_218_588)),
        reversed: false,
    },
    sensor: RotorSensor::Absolute,
    dead_time: 0.6e-6,
    continuous_current: 10.0,
    periods_per_control: 20,
};

pub fn count(table: &mut Table) -> Option<()> {
    count_field_oriented_step(table)?;
    count_current_interrupt(table)
}

/// Counts the controllers of both axes with their feed-forward, the modulation and the compensation
/// of the dead time: the interrupt without its limits, its measurements and the rotor's sensor.
fn count_field_oriented_step(table: &mut Table) -> Option<()> {
    let config = black_box(CONFIG);
    let fixed = config.fixed(&Selected::POWER_STAGE);
    let foc = config.field_oriented(&Selected::POWER_STAGE).ok()?;
    let inputs = (ElectricalAngle::default(), [0; 2], Dq::default());
    table.kernel(
        "field-oriented step",
        &mut (foc, inputs, OperatingPoint::default(), None),
        |(_, (angle, currents, demand), point, _), _, random| {
            *angle = ElectricalAngle(Angle::from_bits(random.bits()));
            *currents = [random.bits() >> 2, random.bits() >> 2];
            [demand.d, demand.q] = [random.bits() >> 5, random.bits() >> 5];
            let voltage = 24.0 + random.within(1.0);
            *point = OperatingPoint::new(&fixed, voltage, random.within(8.0));
        },
        |(foc, (angle, currents, demand), point, result)| {
            *result = Some(foc.step(*angle, *currents, *demand, point));
        },
    )
}

/// Counts the whole interrupt except its entry: with the cell that it shares with the control task.
fn count_current_interrupt(table: &mut Table) -> Option<()> {
    let mut current_loop = CurrentLoop::new(&black_box(CONFIG), &Selected::POWER_STAGE).ok()?;
    let wave = Wave {
        cosine: 0.3,
        sine: -0.4,
    };
    current_loop.set_cogging(6, wave);
    current_loop::install(current_loop);
    table.kernel(
        "current interrupt, three phases",
        &mut Readings {
            currents: [0; 2],
            ..Readings::default()
        },
        |readings, call, random| {
            let demand = match call % 16 {
                14 => BridgeDemand::Off,
                15 => BridgeDemand::Brake,
                _ => BridgeDemand::Current(random.within(12.0)),
            };
            current_loop::demand(demand, 24.0 + random.within(1.0), random.within(8.0));
            // Some samples exceed the current limit.
            let code = |bits: i32| (32_768 + (bits >> 20)) as u16;
            *readings = Readings {
                currents: [code(random.bits()), code(random.bits())],
                rotor: random.bits() as u32 >> 20,
                ..Readings::default()
            };
        },
        |readings| {
            black_box(current_loop::pwm_period(readings));
        },
    )
}
