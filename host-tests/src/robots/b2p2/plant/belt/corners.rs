//! Finds the corners of the ground in the plane of a belt.

use super::path::Corner;
use crate::world::ground::{Block, Ground};
use crate::world::physics::turn;
use rapier3d_f64::glamx::DVec2;
use rapier3d_f64::math::{Pose, Vector};

/// Convex edges of the ground that lie across the direction of travel: the front and rear edges of
/// the blocks' top faces, each from right to left, m.
#[derive(Clone, Debug, Default)]
pub struct Edges(Vec<[Vector; 2]>);

impl Edges {
    /// Returns the edges of `ground`. The ground itself has none, because it has no end.
    pub fn of(ground: &Ground) -> Self {
        Self(ground.blocks().iter().skip(1).flat_map(edges).collect())
    }

    /// Returns where the edges pass through the plane of a belt. The plane is parallel to the x and
    /// z axes of `body`, at `lateral` m to the left of its origin. The corners are in these axes.
    /// `corners` is overwritten.
    pub fn cut(&self, body: &Pose, lateral: f64, corners: &mut Vec<Corner>) {
        corners.clear();
        for (edge, ends) in self.0.iter().enumerate() {
            let [right, left] = ends.map(|end| body.inverse_transform_point(end));
            let part = (lateral - right.y) / (left.y - right.y);
            if (0.0..=1.0).contains(&part) {
                let place = right + (left - right) * part;
                let place = DVec2::new(place.x, place.z);
                corners.push(Corner { edge, place });
            }
        }
    }
}

fn edges(block: &Block) -> [[Vector; 2]; 2] {
    let pose = Pose::from_parts(
        Vector::from_array(block.centre),
        turn(Vector::NEG_Y, block.pitch),
    );
    let [x, y, z] = block.half;
    [-x, x].map(|x| [-y, y].map(|y| pose.transform_point(Vector::new(x, y, z))))
}
