//! Homing: whatever happens meanwhile, an axle that counts as homed knows where it is.

use super::drive_bench::{Bench, MOTOR, turns};
use crate::random::Random;
use crate::sweep::stamp_of_executable;
use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_HALT, CONTROL_START, State, controlword, mode, status};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

const OPERATION: u16 = controlword::ENABLE_OPERATION;
/// Distance from the place of power-up to the switch, and the position there, rad.
const SWITCH: f64 = 0.5;
const HOME: f64 = 0.35;
/// Largest error of the position, rad: the travel of ten ticks of the second approach, which has a
/// fifth of 1 rad/s. A disturbance of four ticks may come when the switch has been closed for four.
const TOLERANCE: f64 = 2e-3;

/// What the test has seen.
#[derive(Default, Debug)]
struct Seen {
    homed: usize,
    faults: usize,
    /// Events with the mode of homing after which the axle is not in operation.
    ended: usize,
    worst: f64,
}

/// The home switch in this direction, also with its signal inverted.
fn switches(direction: i32, inverted: bool) -> fn(f64) -> Switches {
    fn home(home: bool) -> Switches {
        Switches {
            home,
            ..Switches::default()
        }
    }
    match (direction, inverted) {
        (1, false) => |angle| home(angle >= SWITCH),
        (1, true) => |angle| home(angle < SWITCH),
        (_, false) => |angle| home(angle <= -SWITCH),
        (_, true) => |angle| home(angle > -SWITCH),
    }
}

/// Runs some milliseconds and compares the position of a homed axle with that of its shaft.
fn run(bench: &mut Bench, sign: f64, milliseconds: usize, seen: &mut Seen) {
    for _ in 0..milliseconds {
        let was_homed = bench.status() & status::HOMED != 0;
        bench.tick();
        if bench.status() & status::HOMED == 0 {
            continue;
        }
        seen.homed += usize::from(!was_homed);
        let believed = f64::from(bench.outputs.motion.position) / 65_536.0 * TAU;
        let error = believed - (bench.angle() - sign * SWITCH + HOME);
        seen.worst = seen.worst.max(error.abs());
        assert!(
            error.abs() < TOLERANCE,
            "mode {}, {:#x}, {} at {:.3} rad, {:.3} rad/s: {error} rad, {seen:?}",
            bench.mode,
            bench.word,
            bench.target,
            bench.angle(),
            bench.velocity()
        );
    }
}

#[test]
fn no_order_of_events_homes_an_axle_at_a_wrong_place() {
    let Some(_stamp) = stamp_of_executable("no_order_of_events_homes_an_axle_at_a_wrong_place")
    else {
        return;
    };
    let mut random = Random(17);
    let mut pick = |count: usize| ((random.next() + 1.0) * 0.5 * count as f64) as usize % count;
    let mut seen = Seen::default();
    for case in 0..240 {
        let direction = if case % 2 == 0 { 1 } else { -1 };
        let mut bench = Bench::new(
            &[
                (Setting::HomingDirection, direction),
                (Setting::HomePosition, (HOME * 1e6) as i32),
                (Setting::HomingSpeed, 1_000),
            ],
            MOTOR,
        );
        bench.switches = switches(direction, false);
        let sign = f64::from(direction);
        bench.enable(mode::HOMING, 0);
        for _ in 0..20 {
            match pick(10) {
                0..=4 => bench.mode = mode::HOMING,
                5 | 6 => bench.mode = mode::CYCLIC_VELOCITY,
                7 => bench.mode = mode::PROFILE_POSITION,
                8 => bench.mode = mode::CYCLIC_TORQUE,
                _ => bench.mode = 2, // unknown
            }
            let part = pick(2_001) as f64 * 1e-3 - 1.0;
            bench.target = match bench.mode {
                mode::CYCLIC_VELOCITY => (part * 3e6) as i32,
                mode::CYCLIC_TORQUE => (part * 100.0) as i32,
                _ => turns(part * 2.0),
            };
            bench.word = match pick(16) {
                0 => controlword::SHUTDOWN,
                1 => 0,    // no voltage
                2 => 0x02, // quick stop
                3 => OPERATION | CONTROL_HALT,
                4 => OPERATION,
                _ => OPERATION | CONTROL_START,
            };
            // A load turns the shaft when the axle does not, a broken lead is a fault later.
            bench.load = [0.0, 0.0, 1.5, -1.5][pick(4)];
            let lead = [None, None, None, None, None, Some(0)][pick(6)];
            bench.motor.open_lead(lead);
            let was_homing = bench.mode == mode::HOMING;
            let long = if was_homing && bench.word & CONTROL_START != 0 {
                2_000
            } else {
                400
            };
            run(&mut bench, sign, pick(long), &mut seen);
            // A disturbance that is shorter than the debouncing.
            bench.switches = switches(direction, true);
            run(&mut bench, sign, pick(5), &mut seen);
            bench.switches = switches(direction, false);
            run(&mut bench, sign, 20, &mut seen);
            bench.motor.open_lead(None);
            seen.ended += usize::from(was_homing && bench.state() != State::OperationEnabled);
            if bench.state() == State::Fault {
                seen.faults += 1;
                for word in [0, 0x80] {
                    bench.word = word;
                    run(&mut bench, sign, 8, &mut seen);
                }
            }
            if bench.state() != State::OperationEnabled {
                for word in [controlword::SHUTDOWN, controlword::SWITCH_ON, OPERATION] {
                    bench.word = word;
                    run(&mut bench, sign, 8, &mut seen);
                }
            }
        }
    }
    println!("{seen:?}");
    assert!(seen.homed > 100 && seen.faults > 50 && seen.ended > 100);
}

/// A switch that is stuck closed, and one that never closes. The travel is that of the chassis
/// joint.
#[test]
fn homing_moves_no_farther_than_the_travel_is_wide() {
    const WIDTH: f64 = 1.04 + 1.74;
    for stuck in [true, false] {
        for direction in [1, -1] {
            let mut bench = Bench::new(
                &[
                    (Setting::HomingDirection, direction),
                    (Setting::HomingSpeed, 300),
                    (Setting::PositionMinimum, -1_040),
                    (Setting::PositionMaximum, 1_740),
                ],
                MOTOR,
            );
            bench.switches = if stuck {
                |_| Switches {
                    home: true,
                    ..Switches::default()
                }
            } else {
                |_| Switches::default()
            };
            bench.enable(mode::HOMING, 0);
            bench.send(OPERATION | CONTROL_START, 22_000);
            let moved = bench.angle().abs();
            assert!(moved < 1.1 * WIDTH, "{stuck} {direction}: {moved} rad");
            assert_eq!(bench.outputs.status.error_code, 0x8613);
            assert_eq!(bench.state(), State::QuickStopActive);
        }
    }
}
