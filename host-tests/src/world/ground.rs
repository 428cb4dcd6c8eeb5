//! Ground of a run, built from fixed blocks. World axes: x forward, y left, z up; the robot starts
//! at the origin.

/// Ground of a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Ground {
    /// Level ground of unlimited extent.
    Flat,
    /// Flight of stairs up to a landing.
    Stairs(Stairs),
    /// One step up, `depth` long, then one step down.
    Curb {
        /// Height, m.
        height: f64,
        /// Distance of the front face from the origin, m.
        front_x: f64,
        /// Length along x, m.
        depth: f64,
    },
    /// Level ground, then a ramp up to a level plateau.
    Ramp {
        /// Rise of the ramp, rad.
        pitch: f64,
        /// Distance of the ramp's foot from the origin, m.
        foot_x: f64,
        /// Length of the ramp along its face, m.
        length: f64,
    },
    /// Plane through the origin, of unlimited extent; the robot starts on it, aligned with it.
    Incline {
        /// Rise along x, rad.
        pitch: f64,
        /// Rise to the left, rad.
        roll: f64,
    },
}

/// Straight flight of stairs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stairs {
    /// Height of a step, m.
    pub riser: f64,
    /// Distance from one nose (front edge of a step) to the next, m.
    pub run: f64,
    /// Number of risers.
    pub count: usize,
    /// Width, m; beyond it the ground is level.
    pub width: f64,
    /// Distance of the first nose from the origin, m.
    pub first_nose_x: f64,
    /// Length of the landing, m. It is behind the last nose, or in front of the first nose if the
    /// flight leads down.
    pub landing: f64,
    /// Whether the robot starts on the landing and the flight leads down from there.
    pub down: bool,
}

impl Stairs {
    /// The staircase of Paillat et al. (15 cm by 28 cm), with five risers, two metres wide, and its
    /// first nose 1.5 m ahead.
    pub const fn paper() -> Self {
        Self {
            riser: 0.15,
            run: 0.28,
            count: 5,
            width: 2.0,
            first_nose_x: 1.5,
            landing: 6.0,
            down: false,
        }
    }

    /// Distance of the last nose from the origin, m.
    pub fn last_nose_x(&self) -> f64 {
        self.first_nose_x + self.run * self.count.saturating_sub(1) as f64
    }

    /// Height of the landing, m.
    pub fn height(&self) -> f64 {
        self.riser * self.count as f64
    }
}

/// Fixed box. The robot drives on its top face.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Block {
    /// Centre, m.
    pub centre: [f64; 3],
    /// Half of each edge, m.
    pub half: [f64; 3],
    /// Rise along x, about the centre, rad.
    pub pitch: f64,
}

/// Half length of the ground, m.
const GROUND: f64 = 100.0;
/// Depth of the blocks below the ground, m. It keeps hidden edges away from the level at which the
/// robot drives.
const BELOW: f64 = 1.0;
/// Length of the plateau behind a ramp, m.
const PLATEAU: f64 = 20.0;

impl Ground {
    /// Returns the blocks, the ground first. Those of an incline are in the incline's own axes.
    pub fn blocks(&self) -> Vec<Block> {
        let level = match *self {
            Self::Stairs(stairs) if stairs.down => -stairs.height(),
            _ => 0.0,
        };
        let ground = Block {
            centre: [0.0, 0.0, level - BELOW],
            half: [GROUND, GROUND, BELOW],
            pitch: 0.0,
        };
        let step = |x0: f64, x1: f64, top: f64, width: f64| Block {
            centre: [0.5 * (x0 + x1), 0.0, 0.5 * (top + level - BELOW)],
            half: [0.5 * (x1 - x0), 0.5 * width, 0.5 * (top - level + BELOW)],
            pitch: 0.0,
        };
        let mut blocks = vec![ground];
        match *self {
            Self::Flat | Self::Incline { .. } => {}
            Self::Stairs(stairs) => blocks.extend((0..stairs.count).map(|i| {
                let nose = stairs.first_nose_x + stairs.run * i as f64;
                if stairs.down {
                    let begin = stairs.first_nose_x - stairs.landing;
                    step(begin, nose, -stairs.riser * i as f64, stairs.width)
                } else {
                    let end = stairs.last_nose_x() + stairs.landing;
                    step(nose, end, stairs.riser * (i + 1) as f64, stairs.width)
                }
            })),
            Self::Curb {
                height,
                front_x,
                depth,
            } => blocks.push(step(front_x, front_x + depth, height, GROUND)),
            Self::Ramp {
                pitch,
                foot_x,
                length,
            } => {
                let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
                let half = [0.5 * length, GROUND, 0.5 * BELOW];
                let (middle, top) = (half[0], length * sine);
                blocks.push(Block {
                    centre: [
                        foot_x + middle * cosine + half[2] * sine,
                        0.0,
                        middle * sine - half[2] * cosine,
                    ],
                    half,
                    pitch,
                });
                let edge = foot_x + length * cosine;
                blocks.push(step(edge, edge + PLATEAU, top, GROUND));
            }
        }
        blocks
    }

    /// Rise of the whole ground along x and to the left, rad; zero except for an incline.
    pub fn inclination(&self) -> [f64; 2] {
        match *self {
            Self::Incline { pitch, roll } => [pitch, roll],
            _ => [0.0; 2],
        }
    }

    /// Height of the ground at a place (x and y), m; `up` is the normal of the whole ground.
    pub fn height(&self, [x, y]: [f64; 2], up: [f64; 3]) -> f64 {
        if matches!(self, Self::Incline { .. }) {
            return -(up[0] * x + up[1] * y) / up[2];
        }
        let tops = self.blocks().into_iter().filter_map(|block| {
            let (sine, cosine) = (libm::sin(block.pitch), libm::cos(block.pitch));
            let along = (x - block.centre[0] + block.half[2] * sine) / cosine;
            let inside =
                along.abs() <= block.half[0] && (y - block.centre[1]).abs() <= block.half[1];
            inside.then(|| block.centre[2] + block.half[2] * cosine + along * sine)
        });
        tops.fold(
            f64::NEG_INFINITY,
            |top, next| if next > top { next } else { top },
        )
    }

    /// Distances along a line at which it crosses the side faces of blocks, m.
    pub fn edges(&self, from: [f64; 2], direction: [f64; 2]) -> Vec<f64> {
        let mut edges = Vec::new();
        for block in self.blocks().iter().skip(1) {
            let (sine, cosine) = (libm::sin(block.pitch), libm::cos(block.pitch));
            let middle = [block.centre[0] - block.half[2] * sine, block.centre[1]];
            let half = [block.half[0] * cosine, block.half[1]];
            for axis in [0, 1] {
                if direction[axis].abs() > 1e-9 {
                    edges.extend([-1.0, 1.0].map(|side| {
                        (middle[axis] + side * half[axis] - from[axis]) / direction[axis]
                    }));
                }
            }
        }
        edges
    }

    /// Corners (x, z) of the ground's section at y = 0 from `from_x` to `to_x`, for drawings.
    pub fn section(&self, from_x: f64, to_x: f64) -> Vec<[f64; 2]> {
        let mut corners = Vec::new();
        let mut end = f64::INFINITY;
        match *self {
            Self::Flat => {}
            Self::Incline { pitch, .. } => {
                let slope = libm::tan(pitch);
                return [from_x, to_x].map(|x| [x, x * slope]).to_vec();
            }
            Self::Stairs(stairs) => {
                let sign = if stairs.down { -1.0 } else { 1.0 };
                for i in 0..stairs.count {
                    let nose = stairs.first_nose_x + stairs.run * i as f64;
                    let floor = |step: usize| sign * stairs.riser * step as f64;
                    corners.extend([[nose, floor(i)], [nose, floor(i + 1)]]);
                }
                if !stairs.down {
                    end = stairs.last_nose_x() + stairs.landing;
                }
            }
            Self::Curb {
                height,
                front_x,
                depth,
            } => {
                corners.extend([[front_x, 0.0], [front_x, height]]);
                end = front_x + depth;
            }
            Self::Ramp {
                pitch,
                foot_x,
                length,
            } => {
                let edge = foot_x + length * libm::cos(pitch);
                corners.extend([[foot_x, 0.0], [edge, length * libm::sin(pitch)]]);
                end = edge + PLATEAU;
            }
        }
        let top = corners.last().map_or(0.0, |corner| corner[1]);
        corners.insert(0, [from_x, 0.0]);
        if end < to_x {
            corners.extend([[end, top], [end, 0.0], [to_x, 0.0]]);
        } else {
            corners.push([to_x, top]);
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_of_the_stairs_goes_from_nose_to_nose_and_ends_on_the_ground() {
        let stairs = Stairs::paper();
        let section = Ground::Stairs(stairs).section(-1.0, 20.0);
        for (i, corners) in section[1..11].chunks(2).enumerate() {
            let x = 1.5 + 0.28 * i as f64;
            for (corner, z) in corners.iter().zip([0.15 * i as f64, 0.15 * (i + 1) as f64]) {
                assert!(
                    (corner[0] - x).abs() < 1e-12 && (corner[1] - z).abs() < 1e-12,
                    "{section:?}"
                );
            }
        }
        assert_eq!(section.last(), Some(&[20.0, 0.0]));
        assert!(
            (stairs.height() - 0.75).abs() < 1e-12 && (stairs.last_nose_x() - 2.62).abs() < 1e-12
        );
    }

    /// Height of the highest block at `x`, computed from the blocks alone.
    fn height(terrain: &Ground, x: f64) -> f64 {
        let tops = terrain.blocks().into_iter().filter_map(|block| {
            let (sine, cosine) = (libm::sin(block.pitch), libm::cos(block.pitch));
            let offset = x - block.centre[0] + block.half[2] * sine;
            let along = offset / cosine;
            (along.abs() <= block.half[0])
                .then(|| block.centre[2] + block.half[2] * cosine + along * sine)
        });
        tops.fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn sections_are_the_tops_of_the_blocks() {
        let down = Stairs {
            down: true,
            ..Stairs::paper()
        };
        let ramp = Ground::Ramp {
            pitch: 0.9,
            foot_x: 1.0,
            length: 1.5,
        };
        let curb = Ground::Curb {
            height: 0.2,
            front_x: 1.2,
            depth: 0.7,
        };
        let stairs = [Stairs::paper(), down].map(Ground::Stairs);
        for terrain in [Ground::Flat, ramp, curb].iter().chain(&stairs) {
            let section = terrain.section(-0.5, 4.0);
            for pair in section.windows(2).filter(|pair| pair[1][0] > pair[0][0]) {
                for share in [0.01, 0.3, 0.99] {
                    let [x, z] = [0, 1].map(|i| pair[0][i] + share * (pair[1][i] - pair[0][i]));
                    assert!((height(terrain, x) - z).abs() < 1e-9, "{terrain:?} at {x}");
                }
            }
        }
        assert!((height(&stairs[1], 5.0) + 0.75).abs() < 1e-12);
    }
}
