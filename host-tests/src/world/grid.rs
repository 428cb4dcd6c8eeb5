//! A grid of lines over the ground, from which it is drawn.

use super::Plant;

/// Half the distance between the two lines at a vertical face, m.
const FACE: f64 = 1e-6;

/// Returns the lines of x and of y over an area, in world axes, m, in order: the ends of each axis
/// of the area, lines between them at most `cell` apart, but no more than `most` cells, and two
/// lines at each vertical face of the ground.
pub fn lines(plant: &dyn Plant, area: [[f64; 2]; 2], cell: f64, most: f64) -> [Vec<f64>; 2] {
    [0, 1].map(|axis: usize| {
        let [from, to] = area[axis];
        let cells = ((to - from) / cell).ceil().clamp(1.0, most) as u32;
        let mut lines: Vec<f64> = (0..=cells)
            .map(|index| from + (to - from) * f64::from(index) / f64::from(cells))
            .collect();
        let direction = [1.0 - axis as f64, axis as f64];
        let edges = plant.ground_edges([0.0; 2], direction).into_iter();
        let inside = edges.filter(|edge| (from..to).contains(edge));
        lines.extend(inside.flat_map(|edge| [edge - FACE, edge + FACE]));
        lines.sort_by(f64::total_cmp);
        lines
    })
}
