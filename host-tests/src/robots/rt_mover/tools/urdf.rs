//! Links and joints of RT-Mover: body, seat, and two arms with two wheels each. The arms steer and
//! roll.

use crate::robots::rt_mover::plant::{RtMoverParameters, mass_properties};
use crate::tools::generate::urdf::{Description, Joint, Motion, inertia};
use std::collections::BTreeMap;

/// Bodies of the plant, in its order.
const BODIES: [&str; 10] = [
    "body",
    "seat",
    "front_yoke",
    "rear_yoke",
    "front_arm",
    "rear_arm",
    "front_left_wheel",
    "front_right_wheel",
    "rear_left_wheel",
    "rear_right_wheel",
];

pub fn links() -> Description {
    let p = RtMoverParameters::nominal();
    let l = &p.lengths;
    let joint = |name: String, [parent, child]: [String; 2], place, axis, range| Joint {
        name,
        parent,
        child,
        place,
        axis,
        motion: Motion::Turn(range),
    };
    let [body, seat] = ["body", "seat"].map(str::to_owned);
    let origin = [0.0; 3];
    let nose_up = [0.0, -1.0, 0.0];
    let pitch = "seat_pitch".to_owned();
    let mut joints = vec![joint(pitch, [body.clone(), seat], origin, nose_up, None)];
    for (end, forward) in [("front", 0.5), ("rear", -0.5)] {
        let part = |name: &str| format!("{end}_{name}");
        let limit = Some([-l.steering_limit, l.steering_limit]);
        let shaft = [forward * l.body, 0.0, 0.0];
        let [yoke, arm] = ["yoke", "arm"].map(part);
        let (name, links) = (part("steering"), [body.clone(), yoke.clone()]);
        joints.push(joint(name, links, shaft, [0.0, 0.0, 1.0], limit));
        let (name, links) = (part("roll"), [yoke, arm.clone()]);
        joints.push(joint(name, links, origin, [1.0, 0.0, 0.0], None));
        for (side, left) in [("left", l.half_arm), ("right", -l.half_arm)] {
            let wheel = part(&format!("{side}_wheel"));
            let links = [arm.clone(), wheel.clone()];
            let hub = [0.0, left, -l.arm_drop];
            joints.push(joint(wheel, links, hub, [0.0, 1.0, 0.0], None));
        }
    }
    let masses = mass_properties(&p).map(|mass| inertia(&mass));
    Description {
        root: body,
        joints,
        masses: BODIES.map(str::to_owned).into_iter().zip(masses).collect(),
        shapes: BTreeMap::new(),
    }
}
