//! Tests that a motor that runs away is switched off in time.

use super::bench::{Bench, state};
use super::code;
use tautrack::bus::cia402::{State, mode};
use tautrack::faults::Fault;
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;

/// Runs until the bridge is off. Returns the maximum speed, rad/s, and the time from the first
/// motion until the bridge is off, ms.
fn runs_away(bench: &mut Bench) -> (f64, u64) {
    let (mut fastest, mut moving_since) = (0.0_f64, None);
    for _ in 0..2_000 {
        let outputs = bench.tick();
        fastest = fastest.max(bench.velocity.abs());
        if bench.velocity.abs() > 0.01 && moving_since.is_none() {
            moving_since = Some(bench.now_us);
        }
        if outputs.bridge == BridgeDemand::Off
            && let Some(since) = moving_since
        {
            assert_eq!(state(&outputs), Some(State::Fault));
            assert!(matches!(
                code(&outputs),
                Some(Fault::Overspeed | Fault::VelocityDeviation)
            ));
            return (fastest, (bench.now_us - since) / 1_000);
        }
    }
    panic!("the bridge is still on at {fastest} rad/s");
}

#[test]
fn swapped_encoder_channels_end_with_the_gates_off_before_twice_the_speed_limit() {
    for mode in [mode::CYCLIC_VELOCITY, mode::CYCLIC_POSITION] {
        for inertia in [0.05, 0.1, 0.3] {
            let mut bench = Bench::axle(&[]);
            bench.inertia = inertia;
            bench.encoder_sign = -1;
            let target = if mode == mode::CYCLIC_VELOCITY {
                500_000
            } else {
                200
            };
            bench.enable_quietly(mode, target);
            let (fastest, milliseconds) = runs_away(&mut bench);
            println!("mode {mode}, {inertia} kg m^2: {fastest:.2} rad/s, {milliseconds} ms");
            assert!(fastest < 12.0, "{fastest} rad/s with {inertia} kg m^2");
            assert!(
                milliseconds < 100,
                "{milliseconds} ms with {inertia} kg m^2"
            );
        }
    }
}

#[test]
fn an_axle_that_is_dragged_beyond_its_speed_limit_is_switched_off() {
    let mut bench = Bench::axle(&[]);
    bench.enable(mode::CYCLIC_VELOCITY, 5_000_000);
    bench.run(500);
    bench.load = -60.0;
    let (fastest, _) = runs_away(&mut bench);
    assert!(fastest < 12.0, "{fastest}");
}

/// Hard use of a motor that works correctly is no fault.
#[test]
fn no_hard_use_counts_as_a_runaway() {
    for inertia in [0.05, 0.3, 2.0] {
        let mut bench = Bench::axle(&[(Setting::VelocityGain, 10_000)]);
        bench.inertia = inertia;
        bench.enable(mode::CYCLIC_VELOCITY, 6_000_000);
        for second in 0..40 {
            let target = [6_000_000, -6_000_000, 0, 5_000_000, -300_000][second % 5];
            bench.command(0x0f, mode::CYCLIC_VELOCITY, target);
            for tick in 0..1_000 {
                // Loads up to nearly the torque at the current limit, against and with the motion,
                // in steps and as shocks of 5 ms.
                bench.load = match (second / 5 % 4, tick % 100) {
                    (1, 0..50) => 15.0,
                    (2, 0..50) => -15.0,
                    (3, 0..5) => 80.0 * inertia.min(1.0),
                    _ => 0.0,
                };
                let outputs = bench.tick();
                assert_eq!(
                    code(&outputs),
                    None,
                    "{inertia} kg m^2, second {second}, tick {tick}, {} rad/s",
                    bench.velocity
                );
            }
        }
    }
}
