//! Tests of the tension of the belts that the screw estimates, against the plant's.

use super::{climb, outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::simulator::record::Sample;

/// Mean tension of the plant's belts, N.
fn tension(sample: &Sample) -> f64 {
    let channel = |name| sample.truth.channels[name];
    0.5 * (channel("left_belt_tension_n") + channel("right_belt_tension_n"))
}

/// Mean, 95th percentile and maximum of the error while the robot is armed, N.
fn errors(name: &str, samples: &[Sample]) -> [f64; 3] {
    let armed = samples.iter().filter(|s| s.received.guard_state == "armed");
    let mut errors: Vec<f64> = armed
        .map(|sample| (sample.received.belt_tension - tension(sample)).abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    let count = errors.len();
    assert!(count > 500, "{name}: {count} samples");
    let mean = errors.iter().sum::<f64>() / count as f64;
    let found = [mean, errors[count * 95 / 100], errors[count - 1]];
    println!(
        "{name}: mean {:.1} N, p95 {:.1} N, max {:.1} N",
        found[0], found[1], found[2]
    );
    found
}

/// The belts have 50 N at rest. The errors are the friction of the screw, 6.6 N, and the ground
/// that strikes axle 3.
#[test]
fn the_estimated_tension_follows_the_belts_over_stairs_and_a_curb() {
    unless_unchanged("belt-tension", || {
        let curb = scenario("curb-30-cm-released", |_| {});
        for (name, samples) in [
            ("staircase", &climb(Board::Host).1),
            ("curb", &outcome(&curb, Board::Host).1),
        ] {
            let [mean, p95, max] = errors(name, samples);
            assert!(mean < 6.0 && p95 < 13.0 && max < 150.0, "{name}");
        }
    });
}
