//! Tests of the current that holds a stopped shaft against a load.

use super::drive_bench::{Bench, MOTOR};
use tautrack::bus::cia402::{CONTROL_FAULT_RESET, CONTROL_HALT, State, controlword, mode};
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

/// A load of 18 N m needs 7.5 A, and one of 14.9 N m needs 6.2 A. The hold current is 6 A.
#[test]
fn an_overloaded_hold_does_not_slip_and_is_reported_within_50_ms() {
    for load in [18.0, -18.0, 14.9, 20.0, -21.0] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.guard = true;
        bench.enable(mode::CYCLIC_VELOCITY, 0);
        bench.load = load;
        bench.run(1_000);
        assert_eq!(
            bench.outputs.status.error_code, 0,
            "operation holds {load} N m"
        );
        let start = bench.angle();
        bench.send(controlword::QUICK_STOP, 4);
        let reported = (0..2_000).position(|_| {
            bench.tick();
            bench.outputs.emergency == Some(0x8321)
        });
        let reported = reported.expect("a report");
        assert!(reported < 50, "{load} N m: {reported} ms");
        bench.run(2_000);
        let (moved, velocity) = (bench.angle() - start, bench.velocity());
        println!("{load} N m: {moved} rad, {reported} ms");
        assert!(moved.abs() < 0.01, "{load} N m: {moved} rad");
        assert!(velocity.abs() < 0.01, "{load} N m: {velocity} rad/s");
        assert_eq!(bench.state(), State::QuickStopActive);
    }
}

/// The load comes after the stop. In operation, an axle that stands with over 9 A is blocked.
#[test]
fn a_hold_bears_what_the_motor_bears_and_a_reset_leads_back_to_operation() {
    for load in [18.0, 22.5, -23.5] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.guard = true;
        bench.enable(mode::CYCLIC_VELOCITY, 0);
        bench.send(controlword::QUICK_STOP, 200);
        bench.load = load;
        bench.send(controlword::QUICK_STOP, 3_000);
        assert_eq!(bench.outputs.status.error_code, 0x8321, "{load} N m");
        assert_eq!(bench.state(), State::QuickStopActive, "{load} N m");
        let start = bench.angle();
        bench.send(controlword::QUICK_STOP | CONTROL_FAULT_RESET, 100);
        bench.send(controlword::QUICK_STOP, 100);
        assert_eq!(bench.outputs.status.error_code, 0, "{load} N m");
        bench.send(controlword::ENABLE_OPERATION, 30);
        assert_eq!(bench.state(), State::OperationEnabled, "{load} N m");
        let moved = bench.angle() - start;
        assert!(moved.abs() < 0.02, "{load} N m: {moved} rad");
    }
}

#[test]
fn a_hold_that_is_strong_enough_has_at_most_the_hold_current_and_no_fault() {
    for load in [5.0, 12.0, -13.5] {
        let mut bench = Bench::new(&[], MOTOR);
        bench.guard = true;
        bench.enable(mode::CYCLIC_VELOCITY, 5_000_000);
        bench.run(600);
        bench.load = load;
        bench.run(300);
        bench.send(controlword::QUICK_STOP, 1_500);
        assert_eq!(bench.outputs.status.error_code, 0, "{load} N m");
        assert!(bench.velocity().abs() < 0.01, "{load} N m");
    }
}

fn operating() -> Bench {
    let mut bench = Bench::new(&[(Setting::HoldCurrent, 3_000)], MOTOR);
    bench.enable(mode::CYCLIC_VELOCITY, 0);
    bench
}

/// Largest current demanded within 20 ms. A hold that is overloaded for 32 ms is a fault.
fn largest(bench: &mut Bench) -> f32 {
    (0..20)
        .map(|_| {
            bench.tick();
            match bench.outputs.bridge {
                BridgeDemand::Current(current) => current.abs(),
                other => panic!("{other:?}"),
            }
        })
        .fold(0.0, f32::max)
}

#[test]
fn after_a_quick_stop_and_during_a_halt_the_full_current_holds() {
    for (word, state) in [
        (controlword::QUICK_STOP, State::QuickStopActive),
        (
            controlword::ENABLE_OPERATION | CONTROL_HALT,
            State::OperationEnabled,
        ),
    ] {
        let mut bench = operating();
        bench.set(|parameters| parameters.quick_stop = 6);
        bench.send(word, 200);
        assert_eq!(bench.state(), state);
        // 8 A of load.
        bench.load = 20.0;
        let demanded = largest(&mut bench);
        assert!(demanded > 4.0 && demanded <= 10.0, "{demanded} A");
    }
}

#[test]
fn a_drive_that_holds_after_bench_mode_has_the_current_of_bench_mode_until_it_is_enabled_again() {
    let limits = [
        (Setting::BenchCurrent, 1_500),
        (Setting::HoldCurrent, 3_000),
    ];
    let mut bench = Bench::new(&limits, MOTOR);
    bench.enable(mode::CYCLIC_VELOCITY, 0);
    // The guard's heartbeat ends bench mode.
    bench.guard = true;
    for mode in [mode::CYCLIC_VELOCITY, mode::CYCLIC_POSITION] {
        bench.mode = mode;
        bench.send(controlword::ENABLE_OPERATION, 200);
        assert_eq!(bench.state(), State::QuickStopActive);
        assert!(!bench.outputs.bench_mode);
        // 2.5 A of load.
        bench.load = 6.0;
        let demanded = largest(&mut bench);
        assert!((demanded - 1.5).abs() < 0.01, "{demanded} A");
        bench.load = 0.0;
    }
    bench.send(controlword::DISABLE_VOLTAGE, 200);
    bench.enable(mode::CYCLIC_VELOCITY, 0);
    bench.load = 20.0;
    let demanded = largest(&mut bench);
    assert!(demanded > 4.0, "{demanded} A");
}
