//! Signed distances of the centre of gravity to the edges of a support polygon.

use crate::math::root_of_sum;

/// A shorter edge has no direction, m.
const MIN_LENGTH: f32 = 1e-3;

/// Edges of a support of four points, in the order of their margins.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Edge {
    /// Behind the robot.
    Back = 0,
    /// In front of it.
    Front = 1,
    /// On its left.
    Left = 2,
    /// On its right.
    Right = 3,
}

/// All edges, in order.
pub const EDGES: [Edge; 4] = [Edge::Back, Edge::Front, Edge::Left, Edge::Right];

/// Horizontal distance of `cog` to each edge of `support`, m, positive inside; indexed by [`Edge`].
///
/// Points are in level axes, counter-clockwise from above: rear right, front right, front left, rear left. An edge
/// shorter than a millimetre has no direction; the margin is then minus the distance to it, never "inside".
#[inline]
pub fn margins(support: &[[f32; 3]; 4], cog: [f32; 3]) -> [f32; 4] {
    let [rear_right, front_right, front_left, rear_left] = *support;
    [
        margin(rear_left, rear_right, cog),
        margin(front_right, front_left, cog),
        margin(front_left, rear_left, cog),
        margin(rear_right, front_right, cog),
    ]
}

#[inline]
fn margin(from: [f32; 3], to: [f32; 3], cog: [f32; 3]) -> f32 {
    let edge = [to[0] - from[0], to[1] - from[1]];
    let offset = [cog[0] - from[0], cog[1] - from[1]];
    let square = |vector: [f32; 2]| vector[0] * vector[0] + vector[1] * vector[1];
    let length = square(edge);
    // Cross product over length, or minus the square of the distance over the distance: one root and one quotient either way.
    let (across, length) = if length < MIN_LENGTH * MIN_LENGTH {
        let distance = square(offset);
        (-distance, distance + f32::MIN_POSITIVE)
    } else {
        (edge[0] * offset[1] - edge[1] * offset[0], length)
    };
    across / root_of_sum(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [
        [0.0, -0.2, 0.0],
        [0.8, -0.2, 0.0],
        [0.8, 0.2, 0.1],
        [0.0, 0.2, 0.0],
    ];

    #[test]
    fn margins_are_distances_to_back_front_left_and_right() {
        let found = margins(&SQUARE, [0.3, 0.05, 0.4]);
        for (edge, expected) in EDGES.into_iter().zip([0.3, 0.5, 0.15, 0.25]) {
            assert!(
                (found[edge as usize] - expected).abs() < 1e-6,
                "{edge:?} {found:?}"
            );
        }
        assert!((margins(&SQUARE, [-0.1, 0.0, 0.0])[0] + 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_support_without_extent_is_never_inside() {
        let point = [[0.1, 0.1, 0.0]; 4];
        assert!(
            margins(&point, [0.1, 0.2, 0.0])
                .iter()
                .all(|margin| *margin < 0.0)
        );
    }
}
