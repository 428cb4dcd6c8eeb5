//! Counts B2P2's guard, margins and equations of motion.

use crate::cost::counter::Table;
use crate::cost::drives::joint;
use crate::cost::guards::{at, count_guard};
use crate::cost::inputs::{angle, geometry, settings};
use crate::cost::kernels::{CORNERS, near_corners};
use core::hint::black_box;
use tautrack::robots::b2p2::{B2p2, JOINTS, Joints, Model, Parameters, Posture};
use tautrack::stability::support::margins;
use tautrack::units::Angle;

pub fn count(table: &mut Table) -> Option<()> {
    count_margins(table)?;
    count_dynamics(table)?;
    let geometry = geometry(&settings(&[])?)?;
    // The joint (drive 2) moves, and the screw (drive 3) keeps the belts taut.
    count_guard::<B2p2>(table, "guard tick of B2P2", 4, 0.5, |drive, tick| {
        let joint = joint(tick);
        match drive {
            2 => joint,
            3 => at(geometry.length(Angle::from_bits(joint.position)).to_bits() >> 4),
            _ => at((tick as i32) << 8),
        }
    })
}

fn count_margins(table: &mut Table) -> Option<()> {
    let model = black_box(Model::new(&settings(&[])?));
    table.kernel(
        "CoG and four margins",
        &mut (model, CORNERS, (Angle::ZERO, 0.0), [0.0; 4]),
        |(_, support, shape, _), call, random| {
            // The first support has no area.
            *support = if call == 0 {
                [[0.1; 3]; 4]
            } else {
                near_corners(random)
            };
            *shape = (angle(call), 0.4 + random.within(0.2));
        },
        |(model, support, (theta, l3), result)| {
            *result = margins(support, model.shape(*theta, *l3).cog);
        },
    )
}

fn count_dynamics(table: &mut Table) -> Option<()> {
    const RANGES: Joints<f32> = [3.0, 3.0, 0.5, 3.0, 0.5, 0.8, 3.0, 0.2];
    // It starts from the joint values and includes their sines.
    table.kernel(
        "B2P2 inverse dynamics",
        &mut (black_box(Parameters::paper()), [[0.0; JOINTS]; 3], None),
        |(_, motion, _), _, random| {
            *motion = [
                RANGES.map(|bound| random.within(bound)),
                random.near([0.0; JOINTS], 2.0),
                random.near([0.0; JOINTS], 5.0),
            ];
        },
        |(parameters, [q, rates, accelerations], effort)| {
            *effort = Some(Posture::new(parameters, q).newton_euler(rates, accelerations));
        },
    )
}
