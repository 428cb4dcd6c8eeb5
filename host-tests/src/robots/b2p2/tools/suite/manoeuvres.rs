//! Families of hazards other than driving up an obstacle: driving backward, standing nose down,
//! turning, and a restart of the guard or a reset in the middle of a climb.

use super::family::{load, near, stairs, straighten_to, when};
use crate::robots::NodeName;
use crate::robots::payload::Payload;
use crate::scenario::{Description, Event, Fault, FaultKind, OperatorRequest};
use crate::tools::suite::draw::generator::Random;
use crate::world::terrain::Terrain;

/// Backs down a slope with the front raised, and stops, which topples the robot over its rear.
pub(super) fn backward(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let angle = if loaded {
        random.between(52.0, 56.0)
    } else {
        random.between(59.0, 62.5)
    };
    drawn.robot.b2p2_mut().payload = loaded.then(|| load(random, 1.0, 2.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Slope {
        angle_deg: angle,
        side_deg: 0.0,
    };
    drawn.operator.speed_mps = 0.0;
    let chassis = random.between(65.0, 85.0);
    drawn.operator.chassis_deg = chassis;
    let speed = random.between(-0.5, -0.3);
    drawn.operator.events = vec![
        Event {
            when: when(|when| when.after_s = Some(4.0)),
            speed_mps: Some(speed),
            ..Event::default()
        },
        Event {
            when: when(|when| when.after_s = Some(2.0)),
            speed_mps: Some(0.0),
            ..Event::default()
        },
    ];
    drawn.about =
        format!("{speed} m/s down {angle} degrees, loaded {loaded}, front at {chassis} degrees");
}

/// Raises the front on a slope on which the robot stands nose down.
pub(super) fn nose_down(random: &mut Random, drawn: &mut Description) {
    let angle = random.between(46.0, 52.0);
    let mut payload = load(random, 3.0, 4.5);
    payload.place_m[2] = random.between(0.22, 0.27);
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Slope {
        angle_deg: -angle,
        side_deg: 0.0,
    };
    drawn.operator.speed_mps = 0.0;
    drawn.operator.chassis_deg = 0.0;
    let chassis = random.between(60.0, 99.0);
    drawn.operator.events = vec![Event {
        when: when(|when| when.after_s = Some(1.0)),
        chassis_deg: Some(chassis),
        ..Event::default()
    }];
    drawn.about = format!(
        "{angle} degrees, {} kg, to {chassis} degrees",
        payload.mass_kg
    );
    drawn.robot.b2p2_mut().payload = Some(payload);
}

/// Folds the front down while the robot climbs, so that it lifts itself.
pub(super) fn folded_on_stairs(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.13, 0.15);
    drawn.terrain = Terrain::Stairs {
        riser_m: riser,
        run_m: random.between(0.28, 0.335),
        count: 5,
        width_m: 3.0,
        first_nose_m: near(random) + 0.03,
        landing_m: 6.0,
        down: false,
    };
    drawn.robot.b2p2_mut().k_m = random.between(1.232, 1.29);
    drawn.robot.b2p2_mut().payload = Some(Payload {
        mass_kg: random.between(1.2, 2.2),
        place_m: [
            random.between(0.1, 0.15),
            random.between(-0.08, 0.08),
            random.between(0.2, 0.24),
        ],
        from_s: 0.0,
        declared: true,
    });
    let chassis = random.between(-52.0, -42.0);
    drawn.operator.speed_mps = random.between(0.2, 0.3);
    drawn.operator.events = vec![
        straighten_to(0.0),
        Event {
            when: when(|when| {
                when.after_m = Some(random.between(0.3, 0.7));
                when.pitch_above_deg = Some(18.0);
            }),
            chassis_deg: Some(chassis),
            ..Event::default()
        },
    ];
    drawn.about = format!(
        "to {chassis} degrees, riser {riser} m, {} m/s",
        drawn.operator.speed_mps
    );
}

/// Turns on the spot with the front raised, on a slope on which the robot stands safely nose up,
/// but not across.
pub(super) fn spinning(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let angle = if loaded {
        random.between(45.0, 49.0)
    } else {
        random.between(52.0, 55.0)
    };
    drawn.robot.b2p2_mut().payload = loaded.then(|| load(random, 1.0, 2.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Slope {
        angle_deg: angle,
        side_deg: 0.0,
    };
    drawn.operator.speed_mps = 0.0;
    drawn.operator.heading_gain_per_s = 0.0;
    // With the front raised, the track's contact is short, so the robot can turn.
    let chassis = random.between(65.0, 85.0);
    drawn.operator.chassis_deg = chassis;
    let fast = random.coin();
    let rate = if fast {
        random.between(300.0, 1_800.0)
    } else {
        random.between(60.0, 90.0)
    };
    let yaw_rate = random.sign() * rate;
    drawn.operator.events = vec![Event {
        when: when(|when| when.after_s = Some(4.0)),
        yaw_rate_deg_s: Some(yaw_rate),
        ..Event::default()
    }];
    drawn.about = format!(
        "{yaw_rate} degrees/s on {angle} degrees, loaded {loaded}, front at {chassis} degrees"
    );
}

/// Draws a climb, and returns a time at which the robot is on the stairs, s.
fn climb(random: &mut Random, drawn: &mut Description) -> f64 {
    let riser = random.between(0.13, 0.16);
    drawn.terrain = stairs(random, riser, 5, false);
    drawn.operator.speed_mps = random.between(0.14, 0.2);
    drawn.operator.events = vec![straighten_to(0.0)];
    let time_s = random.between(9.0, 13.0);
    drawn.duration_s = time_s + 5.0;
    drawn.about = format!(
        "at {time_s} s, riser {riser} m, {} m/s",
        drawn.operator.speed_mps
    );
    time_s
}

/// The guard restarts at once, or after a short time without power. The operator's request stays
/// "arm".
pub(super) fn guard_restart(random: &mut Random, drawn: &mut Description) {
    let at_s = climb(random, drawn);
    let off_s = random.between(0.05, 0.5);
    drawn.faults = vec![Fault {
        what: FaultKind::Restart(NodeName::GUARD),
        at_s,
        until_s: random.coin().then_some(at_s + off_s),
        notice_within_ms: None,
    }];
}

/// A track's node is cut from the bus for a short time, the guard holds the robot, and the operator
/// requests a reset.
pub(super) fn reset_on_stairs(random: &mut Random, drawn: &mut Description) {
    let at_s = climb(random, drawn);
    let left = random.coin();
    let node = if left {
        NodeName::LEFT_TRACK
    } else {
        NodeName::RIGHT_TRACK
    };
    drawn.faults = vec![Fault {
        what: FaultKind::BusCut(node),
        at_s,
        until_s: Some(at_s + 0.3),
        notice_within_ms: None,
    }];
    drawn.operator.events.push(Event {
        when: when(|when| when.time_s = Some(at_s + 1.5)),
        request: Some(OperatorRequest::Reset),
        ..Event::default()
    });
}
