//! Tests what the bodies of all robots share: widths, and commands that are scaled.

use tautrack::math::Scalar;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::rt_mover::support::static_margin;
use tautrack::robots::{Allowed, Body, Command};
use tautrack::settings::{Setting, Settings};
use tautrack::stability::limits::MotionLimits;

#[test]
fn tracks_are_half_of_their_gauge_from_the_middle() {
    let mut settings = Settings::default();
    let key = Setting::TrackGauge.description().key;
    settings.set(key, 430_000).expect("a gauge");
    assert!((B2p2::half_width(&settings) - 0.215).abs() < 1e-6);
    assert!((Crawler::half_width(&settings) - 0.215).abs() < 1e-6);
}

/// On the spot the scale counts; on a curve the speed that is reached.
#[test]
fn a_yaw_rate_keeps_the_curve_and_never_exceeds_the_command() {
    let allowed = Allowed {
        speed_scale: 0.5,
        stop: None,
        brakes: false,
        posture: true,
        limits: MotionLimits::default(),
    };
    for (forward, yaw_rate, speed, expected) in [
        (0.0, 0.8, 0.0, 0.4),
        (0.0, -0.8, 0.3, -0.4),
        (1.0, 0.5, 0.4, 0.2),
        (-1.0, 0.5, -0.4, 0.2),
        (1.0, -0.5, 3.0, -0.5),
    ] {
        let asked = Command {
            forward,
            yaw_rate,
            posture: (),
        };
        let got: f32 = allowed.yaw_rate_on_the_curve(&asked, speed);
        assert!((got - expected).abs() < 1e-6, "{asked:?} {speed}: {got}");
    }
}

#[test]
fn supports_in_one_point_are_as_far_away_as_the_point() {
    fn margin<S: Scalar>() -> S {
        let place = |x, y| [S::from_f64(x), S::from_f64(y)];
        static_margin(&[place(1.0, 2.0); 3], place(1.3, 2.4))
    }
    assert!((margin::<f64>() + 0.5).abs() < 1e-9);
    assert!((margin::<f32>() + 0.5).abs() < 1e-6);
}
