//! Computes the signed distances of the centre of gravity to the edges of a support polygon.

use crate::math::{max, root_of_sum};

/// Minimum length of an edge, m; a shorter one has no direction.
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

/// Stance of a robot: its centre of gravity and the edges of its support, in level axes (x along
/// its heading, y left, z up), m.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Stance {
    /// Centre of gravity.
    pub cog: [f32; 3],
    /// Start and end of each edge. The next wheel on the ground replaces a wheel in the air.
    begins: [[f32; 3]; 4],
    ends: [[f32; 3]; 4],
    standing: [bool; 4],
}

/// Margin to an edge that does not exist, m.
pub const NO_EDGE: f32 = 10.0;

/// Edge that starts at each contact.
const FROM_CONTACT: [Edge; 4] = [Edge::Right, Edge::Front, Edge::Left, Edge::Back];

impl Stance {
    /// Stance on all four contacts, counter-clockwise seen from above: rear right, front right,
    /// front left, rear left.
    #[inline]
    pub fn on(contacts: [[f32; 3]; 4], cog: [f32; 3]) -> Self {
        let [rear_right, front_right, front_left, rear_left] = contacts;
        Self {
            cog,
            begins: contacts,
            ends: [front_right, front_left, rear_left, rear_right],
            standing: [true; 4],
        }
    }

    /// Moves the front ends of the right and the left edge to these places, for a front that
    /// supports the robot lengthwise but not sideways.
    #[must_use]
    pub fn with_sides(mut self, [right, left]: [[f32; 3]; 2]) -> Self {
        (self.ends[0], self.begins[2]) = (right, left);
        self
    }

    /// Moves the rear edge forward by `distance`, m. The other edges stay.
    #[must_use]
    pub fn with_back_moved(mut self, distance: f32) -> Self {
        self.begins[3][0] += distance;
        self.ends[3][0] += distance;
        self
    }

    /// Stance on some of the four contacts, in the order of [`Stance::on`]; `None` is a wheel in
    /// the air.
    pub fn on_some(contacts: [Option<[f32; 3]>; 4], cog: [f32; 3]) -> Self {
        let next = |start: usize| {
            let found = (0..4).find_map(|step| contacts[(start + step) & 3]);
            found.unwrap_or_default()
        };
        Self {
            cog,
            begins: [0, 1, 2, 3].map(next),
            ends: [1, 2, 3, 4].map(next),
            standing: contacts.map(|contact| contact.is_some()),
        }
    }

    /// Which of the four contacts are on the ground.
    pub fn standing(&self) -> [bool; 4] {
        self.standing
    }

    /// Ends of all edges that exist. These are the contacts on the ground, and the ends of edges
    /// that stop short of the next contact.
    pub fn contacts(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        self.edges()
            .filter(|(_, there, _)| *there)
            .flat_map(|(_, _, ends)| ends.map(|end| *end))
    }

    /// Height of the centre of gravity above the lowest end of an edge, m; 0 if it is below, or
    /// without any edge.
    pub fn height(&self) -> f32 {
        self.contacts()
            .fold(0.0, |most, [_, _, up]| max(most, self.cog[2] - up))
    }

    /// Horizontal distance of the centre of gravity to each edge, m, positive inside; indexed by
    /// [`Edge`].
    ///
    /// The edge that starts at a missing contact does not exist; its margin is [`NO_EDGE`]. The
    /// edge before it runs to the next contact on the ground. An edge shorter than a millimetre has
    /// no direction: its margin is minus the distance to it, so the centre of gravity is never
    /// "inside". Without any contact all margins are `-NO_EDGE`.
    #[inline]
    pub fn margins(&self) -> [f32; 4] {
        let mut found = [self.missing(); 4];
        for (edge, there, [from, to]) in self.edges() {
            if there {
                found[edge as usize] = margin(*from, *to, self.cog);
            }
        }
        found
    }

    /// Direction along the plane of the support: cosine and sine of its rise along the heading,
    /// from the mean of the right and the left edge. Level if these have no length.
    #[inline]
    pub fn along(&self) -> [f32; 2] {
        let ends = |axis: usize| {
            (self.ends[0][axis] - self.begins[0][axis])
                + (self.begins[2][axis] - self.ends[2][axis])
        };
        let (ahead, up) = (ends(0), ends(2));
        let square = ahead * ahead + up * up;
        // The comparison is false for NaN, and the result is then NaN.
        if square < 4.0 * MIN_LENGTH * MIN_LENGTH {
            return [1.0, 0.0];
        }
        let over = 1.0 / root_of_sum(square);
        [ahead * over, up * over]
    }

    /// [`Self::along`] for a support that rises along the heading; level for one that falls.
    #[inline]
    pub fn rising(&self) -> [f32; 2] {
        let [cosine, sine] = self.along();
        if sine < 0.0 {
            [1.0, 0.0]
        } else {
            [cosine, sine]
        }
    }

    /// Start and end of an edge.
    #[inline]
    pub fn ends(&self, edge: Edge) -> [[f32; 3]; 2] {
        let start = FROM_CONTACT
            .iter()
            .position(|other| *other == edge)
            .unwrap_or(0);
        [self.begins[start], self.ends[start]]
    }

    /// Middle of the rear ends of the right and the left edge: forward and up, m. These stay where
    /// they are if the rear edge is moved.
    #[inline]
    pub fn rear(&self) -> [f32; 2] {
        [0, 2].map(|axis| 0.5 * (self.begins[0][axis] + self.ends[2][axis]))
    }

    /// Margin to an edge that does not exist: [`NO_EDGE`], or `-NO_EDGE` if no contact is on the
    /// ground.
    #[inline]
    pub fn missing(&self) -> f32 {
        if self.standing == [false; 4] {
            -NO_EDGE
        } else {
            NO_EDGE
        }
    }

    /// The four edges counter-clockwise: the edge, whether it exists, and its ends.
    #[inline]
    pub fn edges(&self) -> impl Iterator<Item = (Edge, bool, [&[f32; 3]; 2])> + '_ {
        (0..4).map(|start| {
            let ends = [&self.begins[start], &self.ends[start]];
            (FROM_CONTACT[start], self.standing[start], ends)
        })
    }
}

/// Returns the edge with the narrowest margin; NaN is narrower than any number.
pub fn narrowest(margins: &[f32; 4]) -> Edge {
    let mut edge = Edge::Back;
    for other in EDGES {
        let (margin, least) = (margins[other as usize], margins[edge as usize]);
        if margin < least || (margin.is_nan() && !least.is_nan()) {
            edge = other;
        }
    }
    edge
}

/// Margins of four contacts that are all on the ground, as by [`Stance::margins`].
#[inline]
pub fn margins(contacts: &[[f32; 3]; 4], cog: [f32; 3]) -> [f32; 4] {
    let [rear_right, front_right, front_left, rear_left] = *contacts;
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
    // Cross product over length, or minus the square of the distance over the distance. Either case
    // takes one root and one division.
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
        let found = Stance::on(SQUARE, [0.3, 0.05, 0.4]).margins();
        for (edge, expected) in EDGES.into_iter().zip([0.3, 0.5, 0.15, 0.25]) {
            assert!(
                (found[edge as usize] - expected).abs() < 1e-6,
                "{edge:?} {found:?}"
            );
        }
        let behind = Stance::on(SQUARE, [-0.1, 0.0, 0.0]).margins();
        assert!((behind[0] + 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_support_without_extent_is_never_inside() {
        let point = [[0.1, 0.1, 0.0]; 4];
        assert!(
            Stance::on(point, [0.1, 0.2, 0.0])
                .margins()
                .iter()
                .all(|margin| *margin < 0.0)
        );
    }

    #[test]
    fn a_wheel_in_the_air_leaves_the_edge_across_it() {
        let mut contacts = SQUARE.map(Some);
        contacts[2] = None; // front left
        let stance = Stance::on_some(contacts, [0.3, -0.1, 0.4]);
        let [back, front, left, right] = stance.margins();
        assert!((back - 0.3).abs() < 1e-6 && (right - 0.1).abs() < 1e-6);
        assert_eq!(left, NO_EDGE);
        // The edge from (0.8, -0.2) to (0, 0.2) is the line x + 2 y = 0.4. The distance to it is
        // (0.4 - x - 2 y) / sqrt 5.
        assert!((front - 0.3 / 5.0_f32.sqrt()).abs() < 1e-6, "{front}");
        assert_eq!(Stance::default().margins(), [-NO_EDGE; 4]);
    }
}
