//! Tests of how much of a change of shape passes.

use super::bench::{Bench, verdict};
use tautrack::settings::Setting;
use tautrack::stability::filter::Verdict;
use tautrack::stability::support::Edge;

#[test]
fn a_chassis_motion_that_would_tip_the_robot_is_refused() {
    let mut bench = Bench::armed();
    // The robot stands on its rear pulleys at 75 degrees. Folding the front up would move the
    // centre of gravity behind them.
    bench.tilt(1.31);
    bench.command.as_mut().expect("an operator").posture = 16_384;
    let outputs = bench.run(2_000);
    assert!(
        matches!(verdict(&outputs), Some(Verdict::PostureRefused(_))),
        "{outputs:?}"
    );
    assert!(outputs.passed.passed_posture < 8_192, "{outputs:?}");
}

/// On level ground a front that is folded down by 60 degrees lifts the body by 36 degrees. From
/// there the robot bears a fall off a step of 100 mm, but not off one of 150 mm.
#[test]
fn a_step_that_may_be_behind_limits_backing_and_how_far_the_front_is_folded_down() {
    let fold = |step: i32| {
        let mut bench = Bench::with(&[(Setting::StepBehind, step)]);
        bench.tilt(0.63);
        // -60 degrees.
        bench.command.as_mut().expect("an operator").posture = -10_923;
        let folded = bench.run(5_000);
        bench.ask(-300);
        let backed = bench.run(3_000);
        // Driving forward and unfolding are not limited.
        bench.ask(100);
        bench.command.as_mut().expect("an operator").posture = 0;
        let freed = bench.run(5_000);
        assert_eq!(freed.passed.passed_posture, 0, "{freed:?}");
        assert_eq!(freed.passed.passed_speed, 100, "{freed:?}");
        (folded, backed)
    };
    for step in [0, 100_000] {
        let (folded, backed) = fold(step);
        assert_eq!(folded.passed.passed_posture, -10_923, "{folded:?}");
        assert_eq!(backed.passed.passed_speed, -300, "{backed:?}");
    }
    let (folded, backed) = fold(150_000);
    assert_eq!(verdict(&folded), Some(Verdict::PostureRefused(Edge::Back)));
    let reached = f64::from(folded.passed.passed_posture) * 360.0 / 65_536.0;
    assert!((-58.0..-35.0).contains(&reached), "{reached}");
    assert!(backed.passed.passed_speed > -100, "{backed:?}");
    let held_back = [Verdict::Scaled(Edge::Back), Verdict::Refused(Edge::Back)];
    assert!(verdict(&backed).is_some_and(|verdict| held_back.contains(&verdict)));
}

/// The robot leans on a nose at 59 degrees with 3.06 kg, and 60 mm are left of its rear margin. If
/// the pitch stayed constant, folding the front down would widen the margin. But the belt lies on
/// the nose, and the fold turns the body up.
#[test]
fn a_robot_that_leans_on_a_nose_does_not_fold_its_front_down() {
    let mut bench = Bench::with(&[
        (Setting::PayloadMass, 3_058),
        (Setting::PayloadForward, 172_000),
        (Setting::PayloadUp, 288_000),
    ]);
    bench.tilt(1.03);
    // -31.6 degrees.
    bench.command.as_mut().expect("an operator").posture = -5_761;
    let outputs = bench.run(2_000);
    assert!((40..80).contains(&outputs.margins.back), "{outputs:?}");
    let refused = Some(Verdict::PostureRefused(Edge::Back));
    assert_eq!(verdict(&outputs), refused, "{outputs:?}");
    assert!(outputs.passed.passed_posture > -200, "{outputs:?}");
}

/// The joint reaches a small step within one SYNC period. Its set-point has no velocity after that.
#[test]
fn small_steps_fold_the_front_no_farther_than_a_large_one() {
    let fold = |step: i16| {
        let changes = [
            (Setting::StepBehind, 150_000),
            (Setting::SyncPeriod, 20_000),
        ];
        let mut bench = Bench::with(&changes);
        bench.tilt(0.63);
        let mut outputs = bench.run(20);
        for _ in 0..1_000 {
            let command = bench.command.as_mut().expect("an operator");
            command.posture = (command.posture - step).max(-10_923);
            outputs = bench.run(20);
        }
        outputs.passed.passed_posture
    };
    let at_once = fold(10_923);
    assert!(at_once > -10_500, "{at_once}");
    let in_steps = fold(12);
    // 300 units are 1.6 degrees.
    assert!((in_steps - at_once).abs() < 300, "{in_steps} {at_once}");
}

/// The caution band holds the motion back from where the predicted margin enters it. The chassis
/// turns at 0.5 rad/s, so that 300 ms more of the horizon are 0.15 rad, 1565 units of 2^-16 turn.
#[test]
fn the_motion_of_the_chassis_is_predicted_as_far_ahead_as_the_settings_say() {
    let held_back = |horizon: i32| {
        let mut bench = Bench::with(&[(Setting::PredictionHorizon, horizon)]);
        bench.tilt(0.9);
        bench.command.as_mut().expect("an operator").posture = 16_384;
        let mut outputs = bench.run(4);
        while verdict(&outputs) == Some(Verdict::Passed) {
            outputs = bench.run(4);
        }
        assert_eq!(verdict(&outputs), Some(Verdict::PostureScaled(Edge::Back)));
        outputs.passed.passed_posture
    };
    let (near, far) = (held_back(100), held_back(400));
    assert!((near - far - 1_565).abs() < 100, "{near} {far}");
}

/// Lowering the front is the way out of a posture in which backing is refused.
#[test]
fn a_raised_front_is_lowered_to_straight_whatever_may_be_behind() {
    let mut bench = Bench::with(&[(Setting::StepBehind, 500_000)]);
    bench.command.as_mut().expect("an operator").posture = 8_000;
    bench.run(4_000);
    bench.ask(-100);
    let raised = bench.run(1_000).passed;
    assert_eq!((raised.passed_speed, raised.passed_posture), (0, 8_000));
    bench.command.as_mut().expect("an operator").posture = 0;
    assert_eq!(bench.run(4_000).passed.passed_posture, 0);
}

#[test]
fn the_chassis_turns_no_faster_than_its_limit() {
    let mut bench = Bench::armed();
    bench.command.as_mut().expect("an operator").posture = 3_000;
    let mut before = 0;
    for _ in 0..500 {
        let now = bench.run(4).passed.passed_posture;
        // 0.5 rad/s over 4 ms is 20.9 units of 2^-16 turn.
        assert!((now - before).abs() <= 21, "{before} to {now}");
        before = now;
    }
    assert_eq!(before, 3_000);
}
