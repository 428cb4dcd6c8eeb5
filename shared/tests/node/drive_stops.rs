//! Tests of the current that holds a stopped shaft against a load.

use super::drive_bench::{Bench, MOTOR};
use tautrack::bus::cia402::{CONTROL_HALT, State, controlword, mode};
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

/// Hold current of the drive, A; its current limit is 10 A, and a motor current of 1 A makes
/// 2.4 N m at the output shaft.
const HOLD: f32 = 3.0;

fn operating() -> Bench {
    let mut bench = Bench::new(&[(Setting::HoldCurrent, 3_000)], MOTOR);
    bench.enable(mode::CYCLIC_VELOCITY, 0);
    bench
}

/// Largest current demanded within 30 ms. After that the load has made the shaft too fast.
fn largest(bench: &mut Bench) -> f32 {
    (0..30)
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
fn after_a_quick_stop_the_hold_current_holds_and_during_a_halt_the_full_one() {
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
        if state == State::QuickStopActive {
            assert!((demanded - HOLD).abs() < 0.01, "{demanded} A");
        } else {
            assert!(demanded > 4.0 && demanded <= 10.0, "{demanded} A");
        }
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
