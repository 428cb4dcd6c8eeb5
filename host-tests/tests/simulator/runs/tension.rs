//! Tests of the tension of the belts that the screw estimates, against the plant's.

use super::{climb, outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::simulator::record::Sample;

/// Mean tension of the plant's belts, N.
fn tension(sample: &Sample) -> f64 {
    let channel = |name| sample.truth.channels[name];
    0.5 * (channel("left_belt_tension_n") + channel("right_belt_tension_n"))
}

/// Mean and 95th percentile of the error while the robot is armed, N.
fn errors(name: &str, samples: &[Sample]) -> [f64; 2] {
    let armed = samples.iter().filter(|s| s.received.guard_state == "armed");
    let mut errors: Vec<f64> = armed
        .map(|sample| (sample.received.belt_tension - tension(sample)).abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    let count = errors.len();
    assert!(count > 500, "{name}: {count} samples");
    let mean = errors.iter().sum::<f64>() / count as f64;
    let p95 = errors[count * 95 / 100];
    println!(
        "{name}: mean {mean:.1} N, p95 {p95:.1} N, max {:.1} N",
        errors[count - 1]
    );
    if let Ok(place) = std::env::var("DUMP") {
        let mut text = String::new();
        for s in samples {
            text += &format!(
                "{} {} {} {} {} {} {} {} {} {}\n",
                s.time_s,
                s.received.belt_tension,
                tension(s),
                s.truth.theta,
                s.truth.extension,
                s.truth.pitch,
                s.drives[3].as_ref().map_or(0.0, |d| d.torque_nm),
                s.received.currents[3],
                s.drives[3].as_ref().map_or(0.0, |d| d.speed_radps),
                s.received.guard_state.replace(' ', "_")
            );
        }
        std::fs::write(format!("{place}/{name}.txt"), text).unwrap();
    }
    [mean, p95]
}

#[test]
fn the_estimated_tension_follows_the_belts_over_stairs_and_a_curb() {
    let [mean, p95] = errors("staircase", &climb(Board::Host).1);
    assert!(mean < 15.0 && p95 < 50.0);
    let curb = scenario("curb-30-cm-released", |_| {});
    let [mean, p95] = errors("curb", &outcome(&curb, Board::Host).1);
    assert!(mean < 15.0 && p95 < 50.0);
}

#[test]
fn dump_all() {
    for dir in ["legitimate", "hazards", "."] {
        let root = super::path("x").parent().unwrap().join(dir);
        for file in std::fs::read_dir(root).unwrap() {
            let file = file.unwrap().path();
            if file.extension().is_none_or(|e| e != "toml") {
                continue;
            }
            let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
            if ["bench", "client", "commissioning"].contains(&stem.as_str()) {
                continue;
            }
            let scenario = tautrack_host_tests::scenario::Scenario::load(&file).unwrap();
            let samples = outcome(&scenario, Board::Host).1;
            let _ = std::panic::catch_unwind(|| errors(&format!("all-{stem}"), &samples));
        }
    }
}
