//! Links and joints of Hylos: a platform, and four legs with a steered wheel each.
//!
//! Thigh and shank have no mass, as in the plant. Parallelograms keep the steering axes parallel to
//! the platform's z axis; here, two joints do it that turn back by the angles of knee and hip.

use crate::robots::hylos::plant::{HylosParameters, mass_properties};
use crate::tools::generate::urdf::{Description, Joint, Motion, inertia};
use crate::world::truth::Part;
use std::collections::BTreeMap;
use tautrack::robots::hylos::parameters::{HIP_RANGE, KNEE_RANGE, STEERING_RANGE};

/// Legs with the directions in which they are from the middle, forward and left.
const LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("front_right", [1.0, -1.0]),
    ("rear_left", [-1.0, 1.0]),
    ("rear_right", [-1.0, -1.0]),
];
/// Thickness of thigh and shank in pictures, m. The paper does not give it.
const THICKNESS: f64 = 0.03;

pub fn links() -> Description {
    let p = HylosParameters::nominal([0.0; 3]);
    let [platform, carrier, wheel] = mass_properties(&p).map(|mass| inertia(&mass));
    let root = "platform".to_owned();
    let mut joints = Vec::new();
    let mut masses = BTreeMap::from([(root.clone(), platform)]);
    let mut shapes = BTreeMap::new();
    let m = &p.measures;
    for (leg, [forward, left]) in LEGS {
        let part = |name: &str| format!("{leg}_{name}");
        let along = |length: f64| [forward * length, 0.0, 0.0];
        let hip = [forward * m.hip[0], left * (m.hip[1] + m.wheel_offset), 0.0];
        let down = [0.0, forward, 0.0];
        let up = [0.0, 0.0, 1.0];
        let roll = [0.0, 1.0, 0.0];
        let back = |name: &str| Motion::Compensate(part(name));
        let turn = |range| Motion::Turn(Some(range));
        let mut parent = root.clone();
        for (name, child, place, axis, motion) in [
            ("hip", "thigh", hip, down, turn(HIP_RANGE)),
            ("knee", "shank", along(m.leg[0]), down, turn(KNEE_RANGE)),
            ("ankle", "ankle", along(m.leg[1]), down, back("knee")),
            ("fork", "fork", [0.0; 3], down, back("hip")),
            ("steering", "carrier", [0.0; 3], up, turn(STEERING_RANGE)),
            ("wheel", "wheel", [0.0; 3], roll, Motion::Turn(None)),
        ] {
            let child = part(child);
            joints.push(Joint {
                name: part(name),
                parent,
                child: child.clone(),
                place,
                axis,
                motion,
            });
            parent = child;
        }
        masses.extend([(part("carrier"), carrier), (part("wheel"), wheel)]);
        for (link, length) in ["thigh", "shank"].into_iter().zip(m.leg) {
            let bar = Part::Box {
                centre: along(0.5 * length),
                size: [length, THICKNESS, THICKNESS],
            };
            shapes.insert(part(link), bar);
        }
    }
    Description {
        root,
        joints,
        masses,
        shapes,
    }
}
