//! Counts the control loops of one motor. Each loop keeps its state from call to call.

use super::counter::Table;
use super::inputs::{angle, number};
use crate::boards::{Board, Selected};
use crate::current_loop;
use core::hint::black_box;
use core::mem::MaybeUninit;
use tautrack::constants::CONTROL_PERIOD;
use tautrack::math::Bound;
use tautrack::motor::cascade::{Cascade, Demand, Gains, Reference};
use tautrack::motor::current::{CurrentLoop, Winding};
use tautrack::motor::foc::{Config, Dq, ElectricalAngle, Foc};
use tautrack::motor::from_radians;
use tautrack::motor::observer::Observer;
use tautrack::motor::profile::{Limits, Motion};
use tautrack::node::axle::BridgeDemand;

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
    count_current_loop(table);
    count_foc(table);
}

fn count_cascade(table: &mut Table) {
    struct State {
        cascade: Cascade,
        bound: Bound,
        reference: Reference,
        position: i64,
        velocity: i32,
        demand: MaybeUninit<Demand>,
    }
    let gains = black_box(Gains {
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
        reference: Reference::default(),
        position: 0,
        velocity: 0,
        demand: MaybeUninit::uninit(),
    };
    table.kernel(
        "cascade position to current",
        &mut state,
        |state, call, random| {
            state.reference = state.cascade.reference(&Motion {
                position: from_radians(random.within(0.5)),
                velocity: number(call, random),
                acceleration: random.within(20.0),
            });
            // Some distances exceed the range in which the difference of positions is computed.
            let distance = if call % 50 == 49 { 1e6 } else { 0.5 };
            state.position = from_radians(random.within(distance));
            state.velocity = state.cascade.rate(random.within(5.0));
        },
        |state, ()| {
            state.demand.write(state.cascade.position(
                &state.reference,
                state.position,
                state.velocity,
                state.bound,
            ));
        },
    );
}

fn count_current_loop(table: &mut Table) {
    let winding = black_box(Winding {
        resistance: 0.6,
        inductance: 3e-4,
        current_limit: 10.0,
    });
    let Ok(current_loop) = CurrentLoop::new(&winding, 4_000.0, Selected::PWM_HZ as f32) else {
        return; // these values are valid; otherwise the host finds no entries
    };
    current_loop::install(current_loop.clone(), 20);
    let mut current_loop = black_box(current_loop);
    table.kernel(
        "current loop step",
        &mut current_loop,
        |_, call, random| (number(call, random), number(call / 7, random)),
        |current_loop, (sample, demand)| current_loop.step(sample, demand, 24.0),
    );
    table.kernel(
        "current interrupt",
        &mut (),
        |(), call, random| {
            current_loop::demand(match call % 16 {
                14 => BridgeDemand::Off,
                15 => BridgeDemand::Brake,
                _ => BridgeDemand::Current(random.within(12.0)),
            });
            (random.within(12.0), 24.0 + random.within(1.0))
        },
        |(), (sample, supply_voltage)| {
            black_box(current_loop::pwm_period(sample, supply_voltage));
        },
    );
}

fn count_foc(table: &mut Table) {
    struct State {
        foc: Foc,
        angle: ElectricalAngle,
        currents: [i32; 2],
        demand: Dq,
        compare: [u16; 3],
    }
    let config = black_box(Config {
        resistance: 0.4,
        inductance: 3e-4,
        supply_voltage: 24.0,
        current_full_scale: 20.0,
        bandwidth: 2_000.0,
        rate_hz: 20_000.0,
        period: 4_250,
    });
    let Ok(foc) = Foc::new(&config) else {
        return; // these values are valid; otherwise the host finds no entry
    };
    let mut state = black_box(State {
        foc,
        angle: ElectricalAngle::default(),
        currents: [0; 2],
        demand: Dq::default(),
        compare: [0; 3],
    });
    table.kernel(
        "FOC step",
        &mut state,
        |state, call, random| {
            state.angle = ElectricalAngle(angle(call));
            state.currents = [random.bits(), random.bits()];
            state.demand = Dq {
                d: random.bits() >> 1,
                q: random.bits() >> 1,
            };
        },
        |state, ()| {
            state.compare = state.foc.step(state.angle, state.currents, state.demand);
        },
    );
}
