//! Tests who may command an axle: the guard, a client in bench mode, or nobody.

use super::bench::{Bench, state};
use super::code;
use tautrack::bus::cia402::{CONTROL_FAULT_RESET, State, controlword, mode};
use tautrack::faults::Fault;
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

/// Creates an axle without a guard, in bench mode and in operation.
fn on_the_bench(target: i32) -> Bench {
    let mut bench = Bench::axle(&[]);
    bench.guard_alive = false;
    bench.client = true;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, target);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));
    bench
}

#[test]
fn without_guard_and_bench_mode_nobody_enables_an_axle() {
    let mut bench = Bench::axle(&[]);
    bench.guard_alive = false;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    assert_eq!(state(&outputs), Some(State::SwitchOnDisabled));
    assert_eq!(outputs.bridge, BridgeDemand::Off);
}

#[test]
fn bench_mode_has_low_limits() {
    let mut bench = on_the_bench(50_000_000);
    for _ in 0..3_000 {
        let outputs = bench.tick();
        assert!(bench.velocity < 1.1, "{} rad/s", bench.velocity);
        match outputs.bridge {
            BridgeDemand::Current(current) => assert!(current.abs() <= 2.0, "{current} A"),
            bridge => panic!("{bridge:?}"),
        }
    }
    assert!((bench.velocity - 1.0).abs() < 0.05, "{}", bench.velocity);
    // A position loop with a large following error does not exceed the limits either.
    bench.command(
        controlword::ENABLE_OPERATION,
        mode::CYCLIC_POSITION,
        1 << 20,
    );
    for _ in 0..500 {
        bench.tick();
        assert!(bench.velocity < 1.1, "{} rad/s", bench.velocity);
    }
}

#[test]
fn bench_mode_ends_when_commands_stop() {
    let mut bench = on_the_bench(500_000);
    bench.set_point = None;
    let outputs = bench.run(70);
    assert_eq!(code(&outputs), Some(Fault::CommandLost));
    assert!(!outputs.bench_mode);
    // The reset alone does not restore bench mode; a new request does.
    bench.command(controlword::QUICK_STOP | CONTROL_FAULT_RESET, 0, 0);
    let outputs = bench.run(20);
    assert_eq!(code(&outputs), None);
    bench.command(
        controlword::ENABLE_OPERATION,
        mode::CYCLIC_VELOCITY,
        500_000,
    );
    let outputs = bench.run(200);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!(bench.velocity.abs() < 0.01, "{}", bench.velocity);

    // Bench mode also ends if the client enables it and never sends a command.
    let mut bench = Bench::axle(&[]);
    bench.guard_alive = false;
    bench.client = true;
    assert!(bench.run(59).bench_mode);
    assert!(!bench.run(5).bench_mode);
}

#[test]
fn bench_mode_ends_when_the_guards_heartbeat_comes_and_the_axle_holds() {
    let mut bench = on_the_bench(1_000_000);
    bench.run(500);
    bench.guard_alive = true;
    let outputs = bench.run(300);
    assert!(!outputs.bench_mode);
    assert_eq!(state(&outputs), Some(State::QuickStopActive));
    assert!(bench.velocity.abs() < 0.01, "{}", bench.velocity);
    // While the guard is alive, the request is refused.
    bench.client = true;
    assert!(!bench.tick().bench_mode);
}

#[test]
fn bench_mode_ends_with_any_fault() {
    let mut bench = on_the_bench(500_000);
    bench.current_reading = Some(f32::NAN);
    let outputs = bench.run(3);
    assert_eq!(code(&outputs), Some(Fault::InvalidReading));
    assert!(!outputs.bench_mode);
}

#[test]
fn bench_mode_replaces_a_guard_that_was_lost() {
    let mut bench = Bench::axle(&[(Setting::BenchSpeed, 400)]);
    bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    bench.guard_alive = false;
    assert_eq!(code(&bench.run(300)), Some(Fault::GuardLost));
    bench.command(controlword::DISABLE_VOLTAGE, 0, 0);
    bench.run(8);
    bench.command(CONTROL_FAULT_RESET, 0, 0);
    assert_eq!(code(&bench.run(8)), None);
    bench.client = true;
    let outputs = bench.enable(mode::CYCLIC_VELOCITY, 1_000_000);
    assert_eq!(state(&outputs), Some(State::OperationEnabled));
    bench.run(1_000);
    assert!((bench.velocity - 0.4).abs() < 0.02, "{}", bench.velocity);
}
