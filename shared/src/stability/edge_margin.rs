//! Computes the margins to one edge of the support, with and without the measured force.

use super::parameters::Parameters;
use crate::math::vector::{Vector, dot, sub};
use crate::math::{max, root_of_sum};

/// Minimum length of an edge, m; a shorter one has no direction.
const MIN_LENGTH: f32 = 1e-3;

/// Margins to one edge.
pub(super) struct Weighed {
    /// Margins, m, before the caller subtracts the uncertainty of the masses.
    pub gravity: f32,
    pub with_force: f32,
    pub lever: [f32; 2],
    /// Distance by which the measured force shifts the margin, m.
    pub shift: f32,
    /// Square of the height of the centre of gravity over the edge, m^2.
    pub height: f32,
}

/// Computes the margins to one edge. Not inlined, because four copies would not fit into the
/// registers.
#[inline(never)]
pub(super) fn weigh(
    ends: [&Vector<f32>; 2],
    cog: Vector<f32>,
    force: Vector<f32>,
    tilt: [f32; 2],
    uncertain: f32,
    parameters: &Parameters,
) -> Weighed {
    let (margin, lever) = straight_down(ends, cog);
    let across = lever[0] * tilt[0] + lever[1] * tilt[1];
    let height = lever[0] * lever[0] + lever[1] * lever[1];
    let distance = root_of_sum(height + margin * margin);
    // A height that is not finite makes the margin NaN.
    let margin = if distance.is_finite() {
        margin
    } else {
        f32::NAN
    };
    let along = margin + across - uncertain;
    let by_angle = parameters.stop + arm(ends, force, along, distance * parameters.stop_sine);
    let narrow = if along < margin { along } else { margin };
    let narrow = if by_angle < narrow { by_angle } else { narrow };
    // The sum is not finite if any of the three is not finite.
    let known = (margin + along + by_angle).is_finite();
    Weighed {
        gravity: margin,
        with_force: if known { narrow } else { f32::NAN },
        lever,
        shift: across.abs(),
        height,
    }
}

/// Signed horizontal distance of `cog` to an edge, m, and the change of this distance per `g` of
/// acceleration forward and to the left, m. The latter is a vector across the edge, as long as the
/// height over the edge.
///
/// Both follow from the moment of the specific force `s` about the edge over its upward part,
/// `((cog - from) x s) . e / (s_z |e|)`, which is linear in `s_x / s_z` and `s_y / s_z`. An edge
/// shorter than a millimetre has no direction; the result is then minus the distance to it.
#[inline]
fn straight_down([from, to]: [&Vector<f32>; 2], cog: Vector<f32>) -> (f32, [f32; 2]) {
    let (edge, offset) = (sub(*to, *from), sub(cog, *from));
    let square = |v: Vector<f32>| v[0] * v[0] + v[1] * v[1];
    let length = square(edge);
    let (across, length) = if length < MIN_LENGTH * MIN_LENGTH {
        let distance = square(offset);
        (-distance, distance + f32::MIN_POSITIVE)
    } else {
        (edge[0] * offset[1] - edge[1] * offset[0], length)
    };
    let over = 1.0 / root_of_sum(length);
    let lever = [
        (offset[2] * edge[1] - offset[1] * edge[2]) * over,
        (offset[0] * edge[2] - offset[2] * edge[0]) * over,
    ];
    (across * over, lever)
}

/// Excess of the arm `|l| sin(nu)` of the force about an edge over the minimum arm that the
/// force-angle requires, m.
///
/// `along` is the margin along the force, m. `least` is `|l| sin(nu_stop)` on a level edge, m. On a
/// sloping edge, `|l|` is shorter by the cosine of the slope, and only the component `f*` of the
/// force across the edge turns about it.
#[inline]
fn arm([from, to]: [&Vector<f32>; 2], force: Vector<f32>, along: f32, least: f32) -> f32 {
    let edge = sub(*to, *from);
    let square = dot(edge, edge);
    let level = square - edge[2] * edge[2];
    let slope = root_of_sum(max(level, 0.0) / square);
    let lengthwise = dot(force, edge);
    let across = max(dot(force, force) - lengthwise * lengthwise / square, 0.0);
    (along * force[2] / root_of_sum(across) - least) * slope
}
