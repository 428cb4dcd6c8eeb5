//! Tests what the bodies of all robots share: widths, and commands that are scaled.

use tautrack::bus::scale::Scale;
use tautrack::estimate::attitude::Attitude;
use tautrack::math::Scalar;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::rt_mover::support::static_margin;
use tautrack::robots::{Allowed, Body, Command, DriveState as DriveOnBus};
use tautrack::sensors::BodySensors;
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

/// B2P2 after it has climbed `height` m on a ramp of 0.5 rad and drives level, with its front at
/// `theta` rad.
fn climbed(height: f64, theta: f64) -> f32 {
    let mut body = B2p2::new(&Settings::default()).expect("a geometry");
    let tilted = |pitch: f32| {
        let mut attitude = Attitude::default();
        let reading = BodySensors {
            inclination: [pitch, 0.0],
            ..BodySensors::default()
        };
        assert!(attitude.update(&reading, 1e-3));
        attitude
    };
    let drive = |bits: u32, turns: f64| DriveOnBus {
        position: Scale::Turning { bits }
            .units()
            .position((turns * 2.0_f64.powi(bits as i32)) as i64 as i32),
        homed: true,
        ..DriveOnBus::default()
    };
    let mut observe = |travel: f64, attitude: &Attitude| {
        let belt = drive(16, travel / (std::f64::consts::TAU * 0.05));
        let screw = DriveOnBus {
            position: Scale::linear(1)
                .units()
                .position((0.226 * 16_777_216.0) as i32),
            ..belt
        };
        let joint = drive(32, theta / std::f64::consts::TAU);
        body.observe(&[belt, belt, joint, screw], attitude, 4e-3);
    };
    for step in 0..=100 {
        let travel = height / libm::sin(0.5) * f64::from(step) / 100.0;
        observe(travel, &tilted(0.5));
    }
    body.forward_scale(&tilted(0.0))
}

/// The angle of the edge by the arc sine of the height over the distance of axles 1 and 2.
#[test]
fn after_a_climb_a_front_that_is_raised_too_far_ends_driving_forward() {
    for (height, degrees) in [
        (0.0, 99.0),
        (0.04, 99.0),
        (0.1, 50.0),
        (0.15, 50.0),
        (0.3, 50.0),
    ] {
        let scale = climbed(height, f64::to_radians(degrees));
        assert!((scale - 1.0).abs() < 1e-3, "{height} {degrees}: {scale}");
    }
    for (height, degrees) in [(0.1, 75.0), (0.15, 64.0), (0.3, 70.0), (0.3, 99.0)] {
        assert_eq!(
            climbed(height, f64::to_radians(degrees)),
            0.0,
            "{height} {degrees}"
        );
    }
    for (height, degrees) in [(0.1, 66.0), (0.12, 63.0), (0.15, 57.0), (0.15, 60.0)] {
        let edge = libm::asin(height / 0.32).to_degrees();
        let expected = (90.0 - degrees - edge) / 10.0;
        let scale = f64::from(climbed(height, f64::to_radians(degrees)));
        assert!(
            (scale - expected).abs() < 0.05,
            "{height} {degrees}: {scale} {expected}"
        );
    }
}
