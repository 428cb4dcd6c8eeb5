//! Tests that a run with a limited speed follows the wall clock and never sleeps for long.

use std::time::{Duration, Instant};
use tautrack_host_tests::simulator::run::pace::Pace;

/// Simulates steps that take `work(step)` each. Returns the pauses and the total time.
fn play(speed: f64, steps: u32, work: impl Fn(u32) -> Duration) -> (Vec<Duration>, Duration) {
    let began = Instant::now();
    let mut now = began;
    let mut pace = Pace::new(Some(speed), began);
    let mut pauses = Vec::new();
    for step in 0..steps {
        now += work(step);
        let pause = pace.pause(now);
        now += pause;
        pauses.push(pause);
    }
    (pauses, now - began)
}

#[test]
fn no_pause_is_longer_than_a_step_whatever_the_run_did_before() {
    for (speed, step) in [(1.0, 1_000), (0.5, 2_000), (4.0, 250)] {
        let step = Duration::from_micros(step);
        // Fast steps, then one of two seconds, then fast steps again; every 97th step is slow.
        let (pauses, _) = play(speed, 5_000, |number| match number {
            1_000 => Duration::from_secs(2),
            number if number % 97 == 0 => 30 * step,
            _ => step / 10,
        });
        let longest = pauses.iter().max().copied().unwrap_or_default();
        assert!(longest <= step, "{speed}: {longest:?}");
    }
}

#[test]
fn a_run_keeps_its_pace_and_does_not_race_after_it_was_held_up() {
    let even = |_| Duration::from_micros(100);
    let (_, took) = play(1.0, 3_000, even);
    assert!((took.as_secs_f64() - 3.0).abs() < 0.002, "{took:?}");
    let (_, took) = play(0.25, 1_000, even);
    assert!((took.as_secs_f64() - 4.0).abs() < 0.005, "{took:?}");
    // One step in the middle takes 2 s, of which 0.1 s is made up.
    let (_, took) = play(1.0, 3_000, |step| match step {
        1_500 => Duration::from_secs(2),
        _ => Duration::from_micros(100),
    });
    assert!((took.as_secs_f64() - 4.9).abs() < 0.005, "{took:?}");
}

#[test]
fn without_a_speed_nothing_pauses() {
    let began = Instant::now();
    assert_eq!(Pace::new(None, began).pause(began), Duration::ZERO);
}
