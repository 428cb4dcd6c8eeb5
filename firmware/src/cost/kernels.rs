//! Counts single functions of the library, at random postures and motions.

use super::counter::Table;
use super::inputs::{Random, angle, geometry, settings};
use core::hint::black_box;
use tautrack::constants::CONTROL_PERIOD;
use tautrack::math;
use tautrack::screw::{Extension, Length, SlackLaw, Tension};
use tautrack::stability::tipover::Edges;
use tautrack::units::Angle;

/// Corners of a robot's support, about.
pub const CORNERS: [[f32; 3]; 4] = [
    [0.0, -0.16, 0.0],
    [0.77, -0.16, 0.0],
    [0.77, 0.16, 0.0],
    [0.0, 0.16, 0.0],
];

pub fn count(table: &mut Table) -> Option<()> {
    table.kernel(
        "sin_cos_q30",
        &mut (Angle::ZERO, (0, 0)),
        |(theta, _), call, _| *theta = angle(call),
        |(theta, result)| *result = math::sin_cos_q30(*theta),
    )?;
    table.kernel(
        "screw extension with derivative",
        &mut (black_box(geometry(&settings(&[])?)?), Angle::ZERO, None),
        |(_, theta, _), call, _| *theta = angle(call),
        |(geometry, theta, result)| *result = Some(geometry.extension(*theta)),
    )?;
    let geometry = geometry(&settings(&[])?)?;
    let law = SlackLaw::new(&geometry);
    table.kernel(
        "screw extension with slack",
        &mut (black_box((geometry, law)), (Angle::ZERO, 0.0), None),
        |(_, (theta, slack), _), call, random| {
            (*theta, *slack) = (angle(call), 0.06 + random.within(0.05));
        },
        |((geometry, law), (theta, slack), result)| {
            *result = Some(law.extension(geometry.extension(*theta), *slack));
        },
    )?;
    table.kernel(
        "tension of the belts",
        &mut (
            black_box((law, Extension::default(), Tension::default())),
            (0.0, 0.0),
            0.0,
        ),
        |((_, extension, _), (force, slack), _), _, random| {
            extension.length = Length::from_num(0.3 + random.within(0.05));
            (*force, *slack) = (random.within(400.0), 0.06 + random.within(0.05));
        },
        |((law, extension, tension), (force, slack), result)| {
            let per_force = law.tension_per_force(*extension, *slack);
            tension.add(*force * per_force, CONTROL_PERIOD);
            *result = tension.newtons();
        },
    )?;
    count_tip_over(table)
}

/// Returns corners near [`CORNERS`].
pub fn near_corners(random: &mut Random) -> [[f32; 3]; 4] {
    CORNERS.map(|corner| random.near(corner, 0.1))
}

fn count_tip_over(table: &mut Table) -> Option<()> {
    table.kernel(
        "minimum of four tip-over angles",
        &mut (Edges::new(&CORNERS)?, [[0.0; 3]; 3], 0.0),
        |(edges, inputs, _), _, random| {
            *edges = Edges::new(&near_corners(random)).unwrap_or(*edges);
            *inputs = [
                random.near([0.3, 0.0, 0.2], 0.2),
                random.near([0.0, 0.0, -81.0], 60.0),
                random.near([0.0; 3], 10.0),
            ];
        },
        |(edges, [cog, force, moment], result)| *result = edges.margin(*cog, *force, *moment),
    )
}
