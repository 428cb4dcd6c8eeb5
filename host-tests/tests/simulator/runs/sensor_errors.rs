//! Tests of runs with constant errors of gyroscope and accelerometer.

use super::{outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::scenario::{Expect, Scenario};
use tautrack_host_tests::simulator::record::Sample;

/// A shipped scenario whose gyroscope is off by 4 degrees/s, and whose accelerometer is off by
/// 0.1 g, on every axis.
fn off(name: &str, sign: f64) -> Scenario {
    scenario(name, |description| {
        description.sensors.errors.rate_at_rest_deg_s = [4.0 * sign; 3];
        description.sensors.errors.accelerometer_g = [0.1 * sign; 3];
        description.expect = Expect::default();
    })
}

fn armed(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    let armed = |sample: &&Sample| sample.received.guard_state == "armed";
    samples.iter().filter(armed)
}

#[test]
fn hazards_are_held_and_legitimate_runs_pass_though_the_sensors_are_off() {
    unless_unchanged(
        "hazards_are_held_and_legitimate_runs_pass_though_the_sensors_are_off",
        || {
            for sign in [-1.0, 1.0] {
                for name in [
                    "hazards/front-kept-up",
                    "hazards/payload-4-kg",
                    "hazards/riser-18-cm",
                    "hazards/guard-restart-on-stairs",
                ] {
                    let (_, samples) = outcome(&off(name, sign), Board::Host);
                    assert!(armed(&samples).count() > 0, "{name} {sign}");
                    let toppled = samples.iter().any(|sample| sample.truth.toppled);
                    assert!(!toppled, "{name} {sign}");
                }
                for name in ["nominal", "descent", "turning"] {
                    let name = format!("legitimate/{name}");
                    let (_, samples) = outcome(&off(&name, sign), Board::Host);
                    assert!(armed(&samples).count() > 0, "{name} {sign}");
                    let hindered =
                        armed(&samples).find(|sample| sample.received.verdict != "passed");
                    let verdict = hindered.map(|sample| &sample.received.verdict);
                    assert_eq!(verdict, None, "{name} {sign}");
                }
            }
        },
    );
}
