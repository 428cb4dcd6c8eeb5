//! Tests of the crawler's nodes on its plant: compensation of slip, an arc that closes, and five
//! hazards.

use super::{ends_in_the_same_bits, outcome, scenario, tried, unless_unchanged};
use std::path::Path;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::results::report;
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::robots::Robot;

const ASKED_MPS: f64 = 0.15;

/// Speed over ground after the run has settled, relative to the commanded speed, minus one.
fn speed_error(summary: &Summary) -> f64 {
    summary.channels["speed_over_ground_mps"].settled / ASKED_MPS - 1.0
}

fn run(name: &str) -> Summary {
    let (summary, _) = outcome(&scenario(&format!("crawler/{name}"), |_| {}), Board::Host);
    assert!(summary.expectation_met, "{summary}");
    summary
}

#[test]
fn slip_is_made_up_for_on_the_paper_s_slope() {
    let error = speed_error(&run("slope"));
    assert!(error.abs() < 0.01, "{error}");
}

#[test]
fn without_compensation_the_robot_lacks_what_its_tracks_slip() {
    let summary = run("slope-uncompensated");
    let error = speed_error(&summary);
    let slip = summary.channels["left_slip_1"].settled;
    assert!(error < -0.08, "{error}");
    assert!((error + slip).abs() < 0.005, "{error} {slip}");
}

#[test]
fn the_receiver_s_speed_makes_up_for_soil_that_is_30_percent_off() {
    unless_unchanged("crawler-soil", Kind::Crawler, || {
        for name in tried(&["slope-weak-soil", "slope-strong-soil"]) {
            let error = speed_error(&run(name));
            assert!(error.abs() < 0.05, "{name}: {error}");
            // Error that remains with the model alone.
            let modelled = scenario(&format!("crawler/{name}"), |description| {
                if let Robot::Crawler(crawler) = &mut description.robot {
                    crawler.slip_compensation =
                        tautrack_host_tests::robots::crawler::section::SlipCompensation::Soil;
                }
            });
            let left = speed_error(&outcome(&modelled, Board::Host).0);
            assert!(error.abs() < 0.5 * left.abs(), "{name}: {error} {left}");
        }
    });
}

#[test]
fn a_circle_of_one_metre_closes() {
    let (summary, samples) = outcome(&scenario("crawler/arc", |_| {}), Board::Host);
    assert!(summary.expectation_met, "{summary}");
    let place = |cog: [f64; 3]| [cog[0], cog[1]];
    let start = place(samples[0].truth.cog);
    let mut turned = 0.0;
    let mut end = None;
    let mut farthest = 0.0;
    for pair in samples.windows(2) {
        let step = pair[1].truth.yaw - pair[0].truth.yaw;
        turned +=
            (step + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        let [x, y] = place(pair[1].truth.cog);
        // The circle begins at the robot and lies to its left.
        let radius = (x - start[0]).hypot(y - start[1] - 1.0);
        farthest = f64::max(farthest, (radius - 1.0_f64).abs());
        if turned >= std::f64::consts::TAU {
            end = Some([x, y]);
            break;
        }
    }
    let [x, y] = end.expect("it comes round");
    let closing = (x - start[0]).hypot(y - start[1]);
    println!(
        "closes within {:.0} mm, radius within {:.0} mm",
        1e3 * closing,
        1e3 * farthest
    );
    assert!(closing < 0.02 * std::f64::consts::TAU, "{closing}");
}

#[test]
fn emulated_nodes_and_those_in_this_process_end_in_the_same_bits() {
    unless_unchanged("crawler-bits", Kind::Crawler, || {
        ends_in_the_same_bits("crawler/slope");
    });
}

#[test]
fn the_guard_holds_what_turns_over_without_it() {
    unless_unchanged("crawler-hazards", Kind::Crawler, || {
        for name in tried(&[
            "hard-start-uphill",
            "onto-a-slope",
            "turning-uphill",
            "hard-stop-downhill",
            "quick-turn-across",
        ]) {
            let [with, without] = [true, false].map(|guard| {
                let changed = scenario(&format!("crawler/hazards/{name}"), |description| {
                    description.guard = guard;
                });
                outcome(&changed, Board::Host).0
            });
            assert!(without.toppled, "{name} is no hazard: {without}");
            assert!(
                !with.toppled && with.guard.interventions > 0,
                "{name}: {with}"
            );
        }
    });
}

#[test]
fn the_page_shows_the_crawler_and_nothing_of_b2p2() {
    let short = scenario("crawler/slope", |description| {
        description.duration_s = 2.0;
    });
    let (summary, samples) = outcome(&short, Board::Host);
    let page = report::html(&short, &summary, &samples).unwrap();
    if let Some(path) = std::env::var_os("TAUTRACK_SHOW_REPORT") {
        std::fs::write(Path::new(&path), &page).unwrap();
    }
    let begin = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(&page[begin..end]).unwrap();
    let titles: Vec<_> = data["sketch"]["plots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|plot| {
            (
                plot["title"].as_str().unwrap(),
                plot["unit"].as_str().unwrap(),
            )
        })
        .collect();
    for plot in [
        ("Sprocket", "rad/s"),
        ("Motor", "rad/s"),
        ("Skid", "m/s"),
        ("Slip", "1"),
        ("Speed over ground", "m/s"),
        ("Motor currents", "A"),
    ] {
        assert!(titles.contains(&plot), "{plot:?} is not in {titles:?}");
    }
    for column in ["tension", "theta", "zmpAlong"] {
        assert!(data["columns"].get(column).is_none(), "{column}");
    }
    assert_eq!(data["points"].as_array().unwrap().len(), samples.len());
    assert!(summary.tension_error_m.is_none() && summary.zero_moment_point.is_none());
}

#[test]
fn a_crawler_before_stairs_or_on_impossible_soil_is_refused() {
    let refusal = |change: fn(&mut tautrack_host_tests::scenario::Description)| {
        let mut description = scenario("crawler/slope", |_| {}).description();
        change(&mut description);
        description.check().unwrap_err().to_string()
    };
    let stairs = |d: &mut tautrack_host_tests::scenario::Description| {
        d.terrain = scenario("staircase", |_| {}).terrain;
    };
    assert!(refusal(stairs).starts_with("terrain is none of the crawler"));
    let loose = |d: &mut tautrack_host_tests::scenario::Description| {
        if let Robot::Crawler(crawler) = &mut d.robot {
            crawler.soil.k2 = 0.5;
        }
    };
    let text = "robot.crawler.soil.k2 is 0.5; it must be at least 1";
    assert_eq!(refusal(loose), text);
}
