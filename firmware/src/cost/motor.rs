//! Counts the control loops of one motor. Each loop keeps its state from call to call.

use super::counter::Table;
use super::inputs::number;
use crate::boards::{Board, Selected};
use crate::current_loop;
use core::hint::black_box;
use core::mem::MaybeUninit;
use tautrack::constants::CONTROL_PERIOD;
use tautrack::math::Bound;
use tautrack::motor::bridge::Readings;
use tautrack::motor::cascade::{self, Cascade, FeedForward};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::foc::{Dq, Foc, Step};
use tautrack::motor::current::{Config, CurrentLoop, MotorKind, OperatingPoint};
use tautrack::motor::from_radians;
use tautrack::motor::observer::Observer;
use tautrack::motor::profile::{Limits, Motion};
use tautrack::motor::rotor::{ElectricalAngle, Mounting, RotorSensor};
use tautrack::node::axle::BridgeDemand;
use tautrack::units::Angle;

pub fn count(table: &mut Table) {
    let mut observer = black_box(Observer::new(4_096, 60_000, 600.0, 0));
    let mut counts = 0_i32;
    table.kernel(
        "observer update",
        &mut observer,
        |_, call, random| {
            // Speeds up to 200 counts per period, and jumps of any size.
            let step = if call % 50 == 49 {
                random.bits()
            } else {
                random.bits() >> 24
            };
            counts = counts.wrapping_add(step);
            counts
        },
        |observer, counts| observer.update(counts, CONTROL_PERIOD),
    );

    let limits = black_box(Limits {
        velocity: 0.5,
        acceleration: 4.0,
    });
    let mut profile = (Motion::default(), limits, 0_i64);
    table.kernel(
        "profile step to a position",
        &mut profile,
        |profile, call, random| {
            if call % 200 == 0 {
                profile.2 = from_radians(random.within(0.3));
            }
        },
        |(set_point, limits, target), ()| {
            set_point.toward_position(*target, *limits, CONTROL_PERIOD);
        },
    );
    table.kernel(
        "profile step to a velocity",
        &mut profile,
        |_, call, random| number(call, random),
        |(set_point, limits, _), target| set_point.toward_velocity(target, *limits, CONTROL_PERIOD),
    );

    count_cascade(table);
    count_field_oriented_step(table);
    count_current_interrupt(table);
}

fn count_cascade(table: &mut Table) {
    #[repr(C)] // the order decides how many instructions load the inputs
    struct State {
        velocity: i32,
        bound: Bound,
        current: i32,
        cut: i32,
        error: i64,
        feed_forward: FeedForward,
        cascade: Cascade,
    }
    let gains = black_box(cascade::Gains {
        position: 20.0,
        velocity: 3.0,
        integral_time: 0.05,
        acceleration: 0.02,
        velocity_limit: 6.0,
        current_limit: 10.0,
        period: CONTROL_PERIOD,
    });
    let cascade = Cascade::new(&gains);
    let mut state = State {
        bound: cascade.bound(8.0),
        cascade,
        error: 0,
        feed_forward: FeedForward::default(),
        velocity: 0,
        current: 0,
        cut: 0,
    };
    table.kernel(
        "cascade position to current",
        &mut state,
        |state, call, random| {
            state.feed_forward = state.cascade.feed_forward(&Motion {
                position: 0,
                velocity: number(call, random),
                acceleration: random.within(20.0),
            });
            // Some errors exceed the range in which they count.
            let distance = if call % 50 == 49 { 1e6 } else { 1.0 };
            state.error = from_radians(random.within(distance));
            state.velocity = state.cascade.rate(random.within(5.0));
        },
        |state, ()| {
            let (error, ahead) = (state.error, state.feed_forward);
            let demand = state
                .cascade
                .position(error, ahead, state.velocity, state.bound);
            (state.current, state.cut) = (demand.current, demand.cut());
            state.cascade.advance(&demand, None);
        },
    );
}

/// Counts the controllers of both axes with their feed-forward, the modulation and the compensation
/// of the dead time: the interrupt without its limits, its measurements and the rotor's sensor.
fn count_field_oriented_step(table: &mut Table) {
    struct State {
        foc: Foc,
        angle: ElectricalAngle,
        currents: [i32; 2],
        demand: Dq,
        point: OperatingPoint,
        step: MaybeUninit<Step>,
    }
    let config = config(MotorKind::ThreePhase);
    let Ok(foc) = config.field_oriented(&Selected::POWER_STAGE) else {
        return; // these values are valid; otherwise the host finds no entry
    };
    let fixed = config.fixed(&Selected::POWER_STAGE);
    let mut state = State {
        foc,
        angle: ElectricalAngle::default(),
        currents: [0; 2],
        demand: Dq::default(),
        point: OperatingPoint::default(),
        step: MaybeUninit::uninit(),
    };
    table.kernel(
        "field-oriented step",
        &mut state,
        |state, _, random| {
            state.angle = ElectricalAngle(Angle::from_bits(random.bits()));
            state.currents = [random.bits() >> 2, random.bits() >> 2];
            state.demand = Dq {
                d: random.bits() >> 5,
                q: random.bits() >> 5,
            };
            let voltage = 24.0 + random.within(1.0);
            state.point = OperatingPoint::new(&fixed, voltage, random.within(8.0));
        },
        |state, ()| {
            let point = &state.point;
            let step = state
                .foc
                .step(state.angle, state.currents, state.demand, point);
            state.step.write(step);
        },
    );
}

/// A brushed motor and a three-phase motor with the same numbers.
const KINDS: [(&str, MotorKind); 2] = [
    ("current interrupt, brushed motor", MotorKind::Brushed),
    ("current interrupt, three phases", MotorKind::ThreePhase),
];

fn config(kind: MotorKind) -> Config {
    black_box(Config {
        kind,
        resistance: 0.6,
        inductance: [3e-4, 3.6e-4],
        torque_constant: 0.04,
        current_limit: 10.0,
        bandwidth: 4_000.0,
        gear_ratio: 60.0,
        mounting: Mounting {
            counts_per_turn: 4_096,
            pole_pairs: 7,
            offset: ElectricalAngle::from_milli_degrees(40_000),
            reversed: false,
        },
        sensor: RotorSensor::Absolute,
        dead_time: 0.6e-6,
        periods_per_control: 20,
    })
}

/// Counts the whole interrupt except its entry: with the cell that it shares with the control task.
fn count_current_interrupt(table: &mut Table) {
    for (name, kind) in KINDS {
        let Ok(mut current_loop) = CurrentLoop::new(&config(kind), &Selected::POWER_STAGE) else {
            return; // these values are valid; otherwise the host finds no entries
        };
        let wave = Wave {
            cosine: 0.3,
            sine: -0.4,
        };
        current_loop.set_cogging(6, wave);
        current_loop::install(current_loop);
        table.kernel(
            name,
            &mut (),
            |(), call, random| {
                let demand = match call % 16 {
                    14 => BridgeDemand::Off,
                    15 => BridgeDemand::Brake,
                    _ => BridgeDemand::Current(random.within(12.0)),
                };
                current_loop::demand(demand, 24.0 + random.within(1.0), random.within(8.0));
                // Some samples exceed the current limit.
                let code = |bits: i32| (32_768 + (bits >> 20)) as u16;
                Readings {
                    currents: [code(random.bits()), code(random.bits())],
                    rotor: random.bits() as u32 >> 20,
                }
            },
            |(), readings| {
                black_box(current_loop::pwm_period(&readings));
            },
        );
    }
}
