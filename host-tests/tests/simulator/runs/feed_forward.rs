//! Tests of the effect of the guard's torque feed-forward: the distance of the chassis joint from
//! its set-point.

use super::{climb, outcome, scenario, unless_unchanged};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::simulator::record::{SAMPLE_HZ, Sample};

/// Distance of the chassis joint from the set-point that the guard passes on, rad.
#[derive(Debug)]
struct Tracking {
    rms: f64,
    /// 99th percentile. A single sample decides the largest distance.
    most: f64,
}

/// Computes the distance over the samples after arming at which the set-point has moved since the
/// previous sample, and over those within half a second after that. Bus and interpolation delay the
/// joint, which no torque can change; the delay with the smallest difference is therefore removed.
fn tracking(samples: &[Sample]) -> Tracking {
    const AFTER: usize = SAMPLE_HZ as usize / 2;
    const MARGIN: usize = 20;
    let armed: Vec<_> = samples
        .iter()
        .filter(|sample| sample.received.guard_state == "armed")
        .collect();
    let theta = |time: f64| {
        let place = (time - armed[0].time_s) * f64::from(SAMPLE_HZ);
        let index = place.floor() as usize;
        let [a, b] = [index, index + 1].map(|at| armed[at].truth.theta);
        a + (b - a) * (place - index as f64)
    };
    let passed = |index: usize| armed[index].received.passed_theta;
    let moved = |index: usize| passed(index) != passed(index - 1);
    // The guard publishes it with every fifth SYNC, which is every second sample.
    let counted: Vec<usize> = (AFTER..armed.len() - MARGIN)
        .filter(|&index| {
            let resting = !moved(index) && !moved(index - 1);
            moved(index) || resting && (index - AFTER + 1..index).any(moved)
        })
        .collect();
    let error = |index: usize, delay: f64| theta(armed[index].time_s + delay) - passed(index);
    let rms = |delay: f64| {
        let squares = counted.iter().map(|index| error(*index, delay).powi(2));
        (squares.sum::<f64>() / counted.len() as f64).sqrt()
    };
    let delay = (-20..60)
        .map(|milliseconds| f64::from(milliseconds) * 1e-3)
        .min_by(|a, b| rms(*a).total_cmp(&rms(*b)))
        .expect("80 of them");
    let mut distances: Vec<f64> = (counted.iter())
        .map(|index| error(*index, delay).abs())
        .collect();
    distances.sort_by(f64::total_cmp);
    Tracking {
        rms: rms(delay),
        most: distances[distances.len() * 99 / 100],
    }
}

/// Computes the figures of one run and prints them.
fn figures(name: &str, samples: &[Sample]) -> Tracking {
    let tracking = tracking(samples);
    println!(
        "{name}: {:.2} mrad RMS, {:.2} mrad in 99 %",
        tracking.rms * 1e3,
        tracking.most * 1e3
    );
    tracking
}

#[test]
fn feed_forward_torques_bring_the_joint_nearer_to_its_set_point() {
    unless_unchanged("feed-forward-joint", || {
        let [with, without] =
            [("flat", true), ("flat without", false)].map(|(name, feed_forward)| {
                let flat = scenario("flat", |description| {
                    description.feed_forward = feed_forward;
                });
                figures(name, &outcome(&flat, Board::Host).1)
            });
        // The belts' tension, which the feed-forward does not know, loads the joint more than the
        // front's weight.
        assert!(with.rms < 0.98 * without.rms, "{with:?} {without:?}");
    });
}

/// On the staircase, the ground carries the front most of the time, which the guard does not know.
#[test]
fn feed_forward_torques_do_no_harm_on_the_staircase() {
    unless_unchanged("feed-forward-climb", || {
        let without = scenario("staircase", |description| description.feed_forward = false);
        let without = figures("staircase without", &outcome(&without, Board::Host).1);
        let with = figures("staircase", &climb(Board::Host).1);
        assert!(with.rms < 1.1 * without.rms, "{with:?} {without:?}");
        assert!(with.most < 1.1 * without.most, "{with:?} {without:?}");
    });
}
