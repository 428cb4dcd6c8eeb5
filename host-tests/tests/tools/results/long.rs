//! Tests that a long run needs no more memory and no larger page than a short one, and that its
//! page loses no peak.

use super::{SCENARIOS, carried, scenario};
use crate::report::embedded;
use serde_json::Value;
use std::io;
use std::process::Command;
use tautrack::can::Frame;
use tautrack_host_tests::results::mcap::Recording;
use tautrack_host_tests::results::report::Page;
use tautrack_host_tests::results::summary::Statistics;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::facts::RunFacts;
use tautrack_host_tests::simulator::record::{BusFrame, SAMPLE_HZ, Sample};

/// A path of `carried` again and again, in small steps, with values that change.
fn long(scenario: &Scenario, samples: usize) -> impl Iterator<Item = Sample> {
    let path = carried(scenario);
    (0..samples).map(move |index| {
        let mut sample = path[index % path.len()].clone();
        let noise = (index * 7_919 % 1_000) as f64 * 1e-3;
        sample.time_s = (index + 1) as f64 / f64::from(SAMPLE_HZ);
        sample.truth.pitch = 0.1 * noise;
        sample.truth.ground_speed = 0.1 + 0.01 * noise;
        sample.truth.backward_margin = Some(0.2 + 0.01 * noise);
        sample.truth.tension_error = 1e-4 * noise;
        sample.received.verdict = "passed".into();
        sample.received.currents = vec![noise; 16];
        for value in sample.truth.channels.values_mut() {
            *value = noise;
        }
        sample
    })
}

/// The data of the page of these samples, and its size in bytes.
fn page(scenario: &Scenario, samples: impl Iterator<Item = Sample>) -> (Value, usize) {
    let mut page = Page::new(scenario);
    samples.for_each(|sample| page.add(&sample));
    let mut text = Vec::new();
    let summary = Statistics::new(scenario).summary(scenario, &RunFacts::default());
    page.write(scenario, &summary, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    (embedded(&text), text.len())
}

fn numbers(values: &Value) -> Vec<i64> {
    let values = values.as_array().unwrap().iter();
    values.map(|value| value.as_i64().unwrap()).collect()
}

#[test]
fn the_page_of_a_long_run_is_as_large_as_that_of_a_shorter_one() {
    for name in SCENARIOS {
        let scenario = scenario(name);
        let (_, five_minutes) = page(&scenario, long(&scenario, 30_000));
        let (_, ten_minutes) = page(&scenario, long(&scenario, 60_000));
        assert!(
            ten_minutes < five_minutes * 11 / 10,
            "{name}: {five_minutes} and {ten_minutes} bytes"
        );
    }
}

#[test]
fn the_curves_of_a_long_run_have_minimum_and_maximum_of_every_interval() {
    let scenario = scenario("staircase");
    let count = 40_000;
    // One sample of these is far below or above all others.
    let peaks = [(7, -40), (20_001, 55), (33_333, -17), (39_999, 70)];
    let spiked = |(index, mut sample): (usize, Sample)| {
        if let Some((_, degrees)) = peaks.iter().find(|(at, _)| *at == index) {
            sample.truth.pitch = f64::from(*degrees).to_radians();
        }
        sample
    };
    let samples: Vec<_> = long(&scenario, count).enumerate().map(spiked).collect();
    let (data, _) = page(&scenario, samples.iter().cloned());
    let pitch = &data["columns"]["pitch"];
    let [first, below, above] = ["values", "below", "above"].map(|name| numbers(&pitch[name]));
    // 40 000 samples need intervals of 16 samples, if there may be 3 000 intervals.
    assert_eq!(first.len(), count / 16);
    for (index, interval) in samples.chunks(16).enumerate() {
        let hundredths = interval
            .iter()
            .map(|sample| (sample.truth.pitch.to_degrees() * 100.0).round() as i64);
        assert_eq!(first[index], hundredths.clone().next().unwrap());
        let least = hundredths.clone().min().unwrap();
        let most = hundredths.max().unwrap();
        assert_eq!(first[index] - below[index], least, "interval {index}");
        assert_eq!(first[index] + above[index], most, "interval {index}");
    }
    for (at, degrees) in peaks {
        let interval = at / 16;
        let ends = [-below[interval], above[interval]].map(|end| first[interval] + end);
        assert!(ends.contains(&i64::from(degrees * 100)), "{degrees}");
    }
}

#[test]
fn the_page_of_a_long_run_shows_an_intervention_of_one_sample() {
    let scenario = scenario("staircase");
    let mut samples: Vec<_> = long(&scenario, 40_000).collect();
    samples[20_005].received.verdict = "scaled: backward margin".into();
    let (data, _) = page(&scenario, samples.into_iter());
    let interval = 20_005 / 16;
    let expected = serde_json::json!([
        [0, "passed"],
        [interval, "scaled: backward margin"],
        [interval + 1, "passed"],
    ]);
    assert_eq!(data["verdict"], expected);
}

/// Variable of the environment with the number of samples for [`feeds_the_results`].
const SAMPLES: &str = "TAUTRACK_FED_SAMPLES";

/// Feeds the results when it runs as a child process of the test below, and prints the maximum of
/// the memory of this process.
#[test]
fn feeds_the_results() {
    let Some(count) = std::env::var(SAMPLES).ok().and_then(|it| it.parse().ok()) else {
        return;
    };
    let scenario = scenario("staircase");
    let mut statistics = Statistics::new(&scenario);
    let mut page = Page::new(&scenario);
    let mut recording = Recording::new(&scenario, io::sink()).unwrap();
    for sample in long(&scenario, count) {
        for millisecond in 0..10 {
            let frame = BusFrame {
                time_us: (sample.time_s * 1e6) as u64 - 9_000 + 1_000 * millisecond,
                sender: 0,
                frame: Frame::new(0x181, &millisecond.to_le_bytes()).unwrap(),
            };
            recording.frame(&frame).unwrap();
        }
        statistics.add(&sample);
        page.add(&sample);
        recording.sample(&sample).unwrap();
    }
    let summary = statistics.summary(&scenario, &RunFacts::default());
    page.write(&scenario, &summary, io::sink()).unwrap();
    recording.finish().unwrap();
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    println!(
        "{}",
        status
            .lines()
            .find(|line| line.starts_with("VmHWM:"))
            .unwrap()
    );
}

/// Maximum of the memory of a process that feeds so many samples to the results, kB.
#[cfg(target_os = "linux")]
fn peak_memory_kb(samples: usize) -> u64 {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "results::long::feeds_the_results", "--nocapture"]);
    let output = command.env(SAMPLES, samples.to_string()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find_map(|line| line.split_once("VmHWM:"));
    let (_, figure) = line.unwrap_or_else(|| panic!("no VmHWM in {text}"));
    figure.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_of_twice_the_length_needs_no_more_memory() {
    let [shorter, longer] = [20_000, 40_000].map(peak_memory_kb);
    // 20 000 samples in memory would be 25 MB and their frames 5 MB.
    assert!(longer < shorter + 2_000, "{shorter} and {longer} kB");
    assert!(longer < 40_000, "{longer} kB");
}
