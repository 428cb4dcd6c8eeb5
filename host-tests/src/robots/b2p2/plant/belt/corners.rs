//! Finds the corners of the ground in the plane of a belt, and those that its free span does not
//! feel.

use super::path::{Corner, Path, Pulleys};
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

/// Growth of a path in one step from which a new corner came in from the side, m. A corner that a
/// belt meets in its plane at 3 m/s, in the middle of a span of 0.3 m, lengthens the path by
/// 0.06 mm.
const FROM_THE_SIDE: f64 = 1e-3;

/// Corners inside the loop of a belt that it does not feel.
///
/// An edge of the ground ends at the side of its block. If this end comes in under a free span
/// from the side, it is deep inside the loop from the first step on. In reality it slips along the
/// flank of the belt, and the guide plates stop it. A belt that pressed on it would throw the robot
/// up with energy that nothing gave it.
#[derive(Clone, Debug, Default)]
pub struct Inside {
    /// Edges that the belt bent around in the last step.
    bent: Vec<usize>,
    inside: Vec<usize>,
}

impl Inside {
    /// Returns the path over the corners that the belt feels. A corner inside is felt again after
    /// it has left the loop.
    pub fn path(&mut self, pulleys: &Pulleys, corners: &[Corner], guided: bool) -> Path {
        let without = |left_out: &[usize]| {
            let felt = |corner: &&Corner| !left_out.contains(&corner.edge);
            let felt: Vec<Corner> = corners.iter().filter(felt).copied().collect();
            Path::around(pulleys, &felt, guided)
        };
        let all = Path::around(pulleys, corners, guided);
        let bends: Vec<usize> = all.corners().map(|corner| corner.edge).collect();
        self.inside.retain(|edge| bends.contains(edge));
        for edge in bends {
            let known = self.bent.contains(&edge) || self.inside.contains(&edge);
            let grown = || length(&all, pulleys) - length(&without(&[edge]), pulleys);
            if !known && grown() > FROM_THE_SIDE {
                self.inside.push(edge);
            }
        }
        let path = if self.inside.is_empty() {
            all
        } else {
            without(&self.inside)
        };
        self.bent = path.corners().map(|corner| corner.edge).collect();
        path
    }
}

fn length(path: &Path, pulleys: &Pulleys) -> f64 {
    let sections = path.sections();
    sections
        .iter()
        .map(|section| section.length(pulleys.radius))
        .sum()
}

fn edges(block: &Block) -> [[Vector; 2]; 2] {
    let pose = Pose::from_parts(
        Vector::from_array(block.centre),
        turn(Vector::NEG_Y, block.pitch),
    );
    let [x, y, z] = block.half;
    [-x, x].map(|x| [-y, y].map(|y| pose.transform_point(Vector::new(x, y, z))))
}
