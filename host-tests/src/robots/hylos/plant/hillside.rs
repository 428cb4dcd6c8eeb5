//! Uneven ground as a mesh of triangles: level ground that passes into a hillside, with waves on
//! all of it.

use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::*;

/// Edge length of the mesh's cells, m.
const CELL: f64 = 0.08;
/// Length over which the level ground passes into the slope, m.
const FOOT: f64 = 0.6;

/// Hill that rises along y.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Hillside {
    /// Angle of the slope, rad.
    pub slope: f64,
    /// Place where the slope begins: the middle of its foot, m.
    pub foot_y: f64,
    /// Half the height between crest and trough of the waves, m.
    pub wave_height: f64,
    /// Distance from crest to crest along x and along y, m.
    pub wave_length: [f64; 2],
    /// Area of the mesh: minimum and maximum of x, then of y, m.
    pub extent: [[f64; 2]; 2],
}

impl Hillside {
    /// Height of the ground at a place (x and y, m), m.
    pub fn height(&self, [x, y]: [f64; 2]) -> f64 {
        let from = y - self.foot_y;
        let risen = 0.5 * (from + libm::sqrt(from * from + FOOT * FOOT));
        let [phase_x, phase_y] = [x / self.wave_length[0], y / self.wave_length[1]]
            .map(|turns| libm::sin(core::f64::consts::TAU * turns));
        libm::tan(self.slope) * risen + self.wave_height * phase_x * phase_y
    }

    /// Upward unit normal of the ground at a place, computed by central differences.
    pub fn normal(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let step = 1e-4;
        let along_x = (self.height([x + step, y]) - self.height([x - step, y])) / (2.0 * step);
        let along_y = (self.height([x, y + step]) - self.height([x, y - step])) / (2.0 * step);
        let length = libm::sqrt(1.0 + along_x * along_x + along_y * along_y);
        [-along_x / length, -along_y / length, 1.0 / length]
    }

    /// Creates the collider: the mesh, with this coefficient of friction.
    ///
    /// # Panics
    /// If `extent` is empty.
    pub fn collider(&self, friction: f64) -> ColliderBuilder {
        let [counts_x, counts_y] = self
            .extent
            .map(|[least, greatest]| libm::ceil((greatest - least) / CELL) as u32);
        let row = counts_y + 1;
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..=counts_x {
            for j in 0..=counts_y {
                let place = [
                    self.extent[0][0] + CELL * f64::from(i),
                    self.extent[1][0] + CELL * f64::from(j),
                ];
                points.push(Vector::new(place[0], place[1], self.height(place)));
                if i < counts_x && j < counts_y {
                    let corner = i * row + j;
                    triangles.push([corner, corner + row, corner + row + 1]);
                    triangles.push([corner, corner + row + 1, corner + 1]);
                }
            }
        }
        // Without this flag, a wheel would collide with the edges between the triangles.
        ColliderBuilder::trimesh_with_flags(points, triangles, TriMeshFlags::FIX_INTERNAL_EDGES)
            .expect("a grid has cells")
            .friction(friction)
    }
}
