//! Computes the margin of the centre of gravity over the wheels that stand.

use rapier3d_f64::math::Vector;

/// Minimum horizontal distance of `cog` from the edges of a support whose corners run
/// counter-clockwise, m; positive inside. Two corners support a line and one a point, so that
/// nothing is inside. Returns `None` without corners, because there is no support.
pub(super) fn margin(corners: &[Vector], cog: Vector) -> Option<f64> {
    let level = |vector: Vector| Vector::new(vector.x, vector.y, 0.0);
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let edges = pairs.map(|(from, to)| [level(*to - *from), level(cog - *from)]);
    match corners {
        [] => None,
        [point] => Some(-level(cog - *point).length()),
        [_, _] => edges
            .map(|[edge, offset]| {
                let share = offset.dot(edge) / edge.length_squared();
                -(offset - edge * share.clamp(0.0, 1.0)).length()
            })
            .reduce(f64::max),
        _ => edges
            .map(|[edge, offset]| (edge.x * offset.y - edge.y * offset.x) / edge.length())
            .reduce(f64::min),
    }
}
