//! Links and joints of B2P2: three segments, the chassis joint and the screw. The belts are no
//! links; their motors move no joint.

use crate::robots::b2p2::plant::{B2p2Parameters, mass_properties};
use crate::tools::generate::urdf::{Description, Joint, Motion, inertia};
use std::collections::BTreeMap;

pub fn links() -> Description {
    let p = B2p2Parameters::nominal();
    let body = |number: usize| format!("body_{number}");
    let mass = |index| (body(index + 1), inertia(&mass_properties(&p, index, None)));
    Description {
        root: body(1),
        joints: vec![
            Joint {
                name: "chassis_joint".to_owned(),
                parent: body(1),
                child: body(2),
                place: [p.l1, 0.0, 0.0],
                axis: [0.0, -1.0, 0.0],
                motion: Motion::Turn(Some(p.joint_travel)),
            },
            Joint {
                name: "screw".to_owned(),
                parent: body(2),
                child: body(3),
                place: [p.l2, 0.0, 0.0],
                axis: [1.0, 0.0, 0.0],
                motion: Motion::Slide {
                    limits: p.screw_travel,
                    lead: p.screw_lead,
                },
            },
        ],
        masses: [0, 1, 2].map(mass).into(),
        shapes: BTreeMap::new(),
    }
}
