//! Tests what B2P2 makes of the operator's command while it clears obstacles by itself.

use tautrack::estimate::attitude::Attitude;
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::{Autonomy, Body, Command};
use tautrack::settings::Settings;

const PERIOD: f32 = 4e-3;

/// The operator's chassis angle and slack count only when he takes over.
#[test]
fn a_stop_keeps_the_posture_until_the_operator_takes_over() {
    let mut robot = B2p2::new(&Settings::default()).expect("a robot");
    let attitude = Attitude::default();
    let asked = Command {
        forward: 0.1,
        yaw_rate: 0.0,
        // 45 degrees, belts released.
        posture: robot.commanded_posture(1 << 13, true),
    };
    assert!(asked.posture.slack > 0.0);
    let present = robot.posture();
    for autonomy in [Autonomy::On, Autonomy::Stopped, Autonomy::On] {
        let command = robot.clear(asked, autonomy, &attitude, PERIOD);
        assert_eq!(command.posture, present, "{autonomy:?}");
    }
    // It is held, until the operator has taken over.
    let held = robot.clear(asked, Autonomy::On, &attitude, PERIOD);
    assert_eq!((held.forward, held.posture), (0.0, present));
    let command = robot.clear(asked, Autonomy::Off, &attitude, PERIOD);
    assert_eq!(command, asked);
}
