//! Finds the corners inside the loop of a belt that it does not feel.
//!
//! An edge of the ground ends at the side of its block. If this end comes in under a free span from
//! the side, it is deep inside the loop from the first step on. In reality it slips along the flank
//! of the belt, and the guide plates stop it. A belt that pressed on it would throw the robot up
//! with energy that no motor supplies.

use super::path::{Corner, Path, Pulleys};

/// Growth of a path in one step from which a new corner came in from the side, m. A corner that a
/// belt meets in its plane at 3 m/s, in the middle of a span of 0.3 m, lengthens the path by
/// 0.06 mm.
const FROM_THE_SIDE: f64 = 1e-3;

/// Corners inside the loop of a belt that it does not feel.
#[derive(Clone, Debug, Default)]
pub struct Inside {
    /// Edges that the belt bent around in the last step; `None` before the first one.
    bent: Option<Vec<usize>>,
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
        let bends = |path: &Path| path.corners().map(|corner| corner.edge).collect::<Vec<_>>();
        let mut path = without(&[]);
        let pressed = bends(&path);
        self.inside.retain(|edge| pressed.contains(edge));
        // A corner that is left out may have hidden another one.
        loop {
            path = if self.inside.is_empty() {
                path
            } else {
                without(&self.inside)
            };
            let new = bends(&path).into_iter().find(|edge| {
                let known = |bent: &Vec<usize>| bent.contains(edge);
                let left_out: Vec<usize> = self.inside.iter().chain([edge]).copied().collect();
                let grown =
                    || path.length(pulleys.radius) - without(&left_out).length(pulleys.radius);
                !self.bent.as_ref().is_none_or(known) && grown() > FROM_THE_SIDE
            });
            let Some(edge) = new else { break };
            self.inside.push(edge);
        }
        self.bent = Some(bends(&path));
        path
    }
}
