//! Limit switches: while one is closed, nothing moves the axle outward, in any mode.

use super::drive_bench::{Bench, MOTOR, turns};
use super::wire::{Wire, set_point};
use crate::random::Random;
use crate::sweep::stamp_of_executable;
use tautrack::bus::cia402::{CONTROL_HALT, CONTROL_START, controlword, mode};
use tautrack::node::axle::BridgeDemand;
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

const OPERATION: u16 = controlword::ENABLE_OPERATION;
/// Angles at which a switch closes and opens, rad. A long cam, or a switch with hysteresis.
const CLOSES: f64 = 1.0;
const OPENS: f64 = 0.3;
/// How far the shaft overshoots or lags behind its set-point, rad.
const SLACK: f64 = 0.1;

/// The limit switch of one direction, and where the axle may be.
#[derive(Clone, Copy)]
struct Side {
    sign: f64,
    closed: bool,
    /// How far outward the axle may be; it is stopped there.
    most: f64,
}

impl Side {
    fn update(&mut self, angle: f64, velocity: f64, powered: bool, case: &str) {
        let (angle, velocity) = (self.sign * angle, self.sign * velocity);
        let was_closed = self.closed;
        self.closed = angle > if was_closed { OPENS } else { CLOSES };
        if !self.closed {
            return;
        }
        // An axle that moves outward brakes with the current limit: with 480 rad/s^2.
        let stopping = angle + SLACK + 0.01 * velocity.max(0.0).powi(2);
        self.most = if was_closed && powered {
            self.most.min(stopping)
        } else {
            stopping
        };
        assert!(
            angle <= self.most,
            "{case}: {} rad outward",
            angle - self.most
        );
    }
}

/// The same two switches as the drive reads them.
fn switches(sides: [Side; 2]) -> fn(f64) -> Switches {
    match sides.map(|side| side.closed) {
        [false, false] => |_| Switches::default(),
        [true, _] => |_| Switches {
            positive_limit: true,
            ..Switches::default()
        },
        [false, true] => |_| Switches {
            negative_limit: true,
            ..Switches::default()
        },
    }
}

#[test]
fn no_order_of_events_moves_an_axle_outward_while_a_limit_switch_is_closed() {
    let Some(_stamp) = stamp_of_executable(
        "no_order_of_events_moves_an_axle_outward_while_a_limit_switch_is_closed",
    ) else {
        return;
    };
    let mut random = Random(91);
    let mut pick = |count: usize| ((random.next() + 1.0) * 0.5 * count as f64) as usize % count;
    let mut stopped = 0;
    for _ in 0..60 {
        let mut bench = Bench::new(&[(Setting::HomingSpeed, 1_000)], MOTOR);
        bench.enable(mode::CYCLIC_VELOCITY, 0);
        let mut sides = [1.0, -1.0].map(|sign| Side {
            sign,
            closed: false,
            most: 0.0,
        });
        for _ in 0..120 {
            match pick(8) {
                0 => {
                    let methods = [17, 18, 19, 20, 21, 22, 23, 24, 37];
                    let method = methods[pick(methods.len())];
                    bench.set(|p| p.homing_method = method);
                    bench.mode = mode::HOMING;
                }
                1 => bench.mode = mode::PROFILE_POSITION,
                2 => bench.mode = mode::CYCLIC_POSITION,
                3 | 4 => bench.mode = mode::CYCLIC_VELOCITY,
                5 => bench.mode = mode::CYCLIC_TORQUE,
                6 => bench.mode = 2, // unknown
                _ => {}
            }
            let part = pick(2_001) as f64 * 1e-3 - 1.0;
            bench.target = match bench.mode {
                mode::CYCLIC_VELOCITY => (part * 5e6) as i32,
                mode::CYCLIC_TORQUE => (part * 300.0) as i32,
                _ => turns(part * 3.0),
            };
            bench.word = match pick(16) {
                0 => controlword::SHUTDOWN,
                1 => controlword::SWITCH_ON,
                2 => 0x02, // quick stop
                3 => OPERATION | CONTROL_HALT,
                4..=9 => OPERATION | CONTROL_START,
                _ => OPERATION,
            };
            for _ in 0..20 + pick(300) {
                let powered = !matches!(
                    bench.outputs.bridge,
                    BridgeDemand::Off | BridgeDemand::Brake
                );
                let case = format!(
                    "mode {}, {:#x}, {} at {:.3} rad, {:.3} rad/s",
                    bench.mode,
                    bench.word,
                    bench.target,
                    bench.angle(),
                    bench.velocity()
                );
                for side in &mut sides {
                    side.update(bench.angle(), bench.velocity(), powered, &case);
                    stopped += usize::from(side.closed && powered);
                }
                bench.switches = switches(sides);
                bench.tick();
            }
            if bench.word & 0x0f != OPERATION {
                bench.send(controlword::SHUTDOWN, 8);
                bench.send(controlword::SWITCH_ON, 8);
            }
        }
    }
    println!("{stopped} ms at a switch");
    assert!(stopped > 100_000);
}

#[test]
fn an_axle_that_was_pushed_past_a_closed_switch_stays_there_when_it_is_enabled() {
    let mut bench = Bench::new(&[], MOTOR);
    bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    bench.switches = |angle| Switches {
        positive_limit: angle > 0.5,
        ..Switches::default()
    };
    bench.run(1_500);
    bench.send(controlword::SHUTDOWN, 200);
    bench.load = -1.0;
    while bench.angle() < 1.0 {
        bench.tick();
    }
    bench.load = 0.0;
    bench.run(1_000);
    let start = bench.angle();
    bench.enable(mode::PROFILE_POSITION, 0);
    bench.run(1_000);
    let moved = bench.angle() - start;
    assert!(start > 0.9 && moved.abs() < 0.01, "{start}: {moved} rad");
}

/// Also when a stop begins where the shaft is, behind its set-point.
#[test]
fn a_closed_limit_switch_changes_nothing_for_an_axle_that_moves_inward() {
    for mode in [mode::CYCLIC_POSITION, mode::PROFILE_POSITION] {
        for milliseconds in [40, 80, 120, 200, 300] {
            let mut benches = [true, false].map(|closed| {
                let mut bench = Bench::new(&[], MOTOR);
                bench.enable(mode::HOMING, 0);
                bench.set(|p| p.homing_method = 37); // the present position
                bench.send(OPERATION | CONTROL_START, 50);
                if closed {
                    bench.switches = |_| Switches {
                        positive_limit: true,
                        ..Switches::default()
                    };
                }
                (bench.mode, bench.target) = (mode, turns(-4.0));
                bench.send(OPERATION, 8);
                bench.send(OPERATION | CONTROL_START, milliseconds);
                bench.word = OPERATION | CONTROL_HALT;
                bench
            });
            for millisecond in 0..150 {
                benches.iter_mut().for_each(Bench::tick);
                let [closed, open] = benches.each_ref().map(Bench::velocity);
                assert!(
                    (closed - open).abs() < 0.02,
                    "mode {mode}, {milliseconds} ms, then {millisecond}: {closed}, {open} rad/s"
                );
            }
            assert!(benches[0].angle() < -0.01);
        }
    }
}

/// A screw in its own mode, whose switch closes at `CLOSED_AT` turns.
const CLOSED_AT: f64 = 2.0 * std::f64::consts::TAU;

#[test]
fn a_limit_switch_stops_a_screw_in_its_own_mode_whatever_the_joint_does() {
    let positive = Switches {
        positive_limit: true,
        ..Switches::default()
    };
    for rate in [0.0, -1e-6, 1e-6, -0.3, 0.3] {
        let mut wire = Wire::screw(&[]);
        wire.joint = Some((0.0, rate));
        wire.operate(mode::TAUT, 0);
        let mut farthest = 0.0_f64;
        for _ in 0..3_000 {
            let closed = wire.rotor.angle >= CLOSED_AT;
            wire.rotor.switches = if closed {
                positive
            } else {
                Switches::default()
            };
            wire.tick(&[]);
            farthest = farthest.max(wire.rotor.angle);
        }
        // It brakes from 100 mm/s with 1000 rad/s^2.
        let beyond = (farthest - CLOSED_AT) / std::f64::consts::TAU;
        assert!(
            beyond < 2.0,
            "{rate} rad/s: {beyond} turns beyond the switch"
        );
        let stands = wire.rotor.velocity.abs() < 0.5;
        assert!(
            stands || !wire.outputs().faults.is_empty(),
            "{} rad/s",
            wire.rotor.velocity
        );
    }
}

/// The joint goes where the taut belt is beyond the switch, and turns back.
#[test]
fn a_taut_screw_at_its_limit_switch_follows_the_joint_inward_only() {
    let mut wire = Wire::screw(&[]);
    wire.joint = Some((0.3, 0.0));
    wire.operate(mode::TAUT, 0);
    wire.run(4_000);
    let closes = wire.rotor.angle + 6.0;
    let (mut angle, mut farthest) = (0.3, 0.0_f64);
    let mut rate = 0.0_f64;
    for step in 0..6_000 {
        let target = if step < 1_500 { 0.4 } else { -0.4 };
        rate += (target - rate).clamp(-0.004, 0.004);
        angle += rate * 1e-3;
        wire.joint = Some((angle, rate));
        wire.rotor.switches.positive_limit = wire.rotor.angle >= closes;
        wire.tick(&[]);
        farthest = farthest.max(wire.rotor.angle);
        if angle < 0.2 {
            break;
        }
    }
    assert!(
        angle < 0.2 && wire.rotor.angle < closes - 5.0,
        "{} rad",
        wire.rotor.angle
    );
    assert!(farthest < closes + 1.0, "{} rad beyond", farthest - closes);
}

/// 1 rad and 230 mm, in every mode.
#[test]
fn a_software_position_limit_stops_motion_towards_it_in_every_mode() {
    for (target_mode, target) in [
        (mode::CYCLIC_VELOCITY, 2_000_000),
        (mode::PROFILE_VELOCITY, 2_000_000),
        (mode::CYCLIC_TORQUE, 100),
        (mode::CYCLIC_POSITION, turns(3.0)),
        (mode::PROFILE_POSITION, turns(3.0)),
    ] {
        for sign in [1, -1] {
            let mut bench = Bench::new(&[], MOTOR);
            bench.enable(target_mode, sign * target);
            bench.set(|p| p.position_limits = [turns(-1.0), turns(1.0)]);
            bench.send(OPERATION | CONTROL_START, 3_000);
            let (angle, velocity) = (bench.angle() * f64::from(sign), bench.velocity());
            assert!(
                (0.9..1.1).contains(&angle),
                "mode {target_mode}: {angle} rad"
            );
            assert!(
                velocity.abs() < 0.01,
                "mode {target_mode}: {velocity} rad/s"
            );
            // Inward it is free.
            bench.target = -sign * target;
            bench.send(OPERATION, 20);
            bench.send(OPERATION | CONTROL_START, 3_000);
            let angle = bench.angle() * f64::from(sign);
            assert!(
                (-1.1..-0.9).contains(&angle),
                "mode {target_mode}: {angle} rad"
            );
        }
    }
    let mut wire = Wire::screw(&[
        (Setting::BenchSpeed, 1_000_000),
        (Setting::BenchCurrent, 20_000),
    ]);
    wire.guard = false;
    wire.write((0x2001, 0), [1]);
    wire.run(20);
    // 2^-24 m.
    wire.write((0x607d, 1), (-1_i32).to_le_bytes());
    wire.write((0x607d, 2), 3_858_759_i32.to_le_bytes());
    wire.joint = Some((1.0, -1e-6));
    wire.operate(mode::TAUT, 0);
    wire.run(10_000);
    let millimetres = wire.rotor.angle / std::f64::consts::TAU * 5.0;
    assert!((229.0..230.1).contains(&millimetres), "{millimetres} mm");
}

#[test]
fn a_quick_stop_does_not_pull_an_axle_back_that_a_load_has_pushed_past_a_switch() {
    let mut wire = Wire::axle(&[]);
    wire.operate(mode::CYCLIC_VELOCITY, 0);
    wire.rotor.switches.positive_limit = true;
    wire.run(50);
    let closed = wire.rotor.angle;
    // N m; the loop of the velocity takes it up after some travel.
    wire.rotor.load = 12.0;
    wire.run(500);
    assert!(
        wire.rotor.angle > closed + 0.05,
        "{} rad",
        wire.rotor.angle - closed
    );
    let start = wire.rotor.angle;
    wire.command = Some(set_point(0x02, 0, 0));
    for _ in 0..500 {
        wire.run(1);
        let moved = (wire.rotor.angle - start).abs();
        assert!(moved < 0.01, "{moved} rad");
    }
}
