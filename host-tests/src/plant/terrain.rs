//! What the robot drives on, made of blocks that do not move. World axes: x forward, y left, z up; the robot starts at the origin.

/// Ground of a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Terrain {
    /// Level ground without end.
    Flat,
    /// A flight of stairs up to a landing.
    Stairs(Stairs),
    /// One step up, `depth` long, then down again.
    Curb {
        /// Height, m.
        height: f64,
        /// Distance of its front face from the origin, m.
        front_x: f64,
        /// Length along x, m.
        depth: f64,
    },
    /// A plane through the origin, without end; the robot starts on it, aligned with it.
    Incline {
        /// Rise along x, rad.
        pitch: f64,
        /// Rise to the left, rad.
        roll: f64,
    },
}

/// A straight flight of stairs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stairs {
    /// Height of a step, m.
    pub riser: f64,
    /// Distance from nose to nose, m.
    pub run: f64,
    /// Number of risers.
    pub count: usize,
    /// Width, m; beyond it the ground is level.
    pub width: f64,
    /// Distance of the first nose from the origin, m.
    pub first_nose_x: f64,
    /// Length of the landing behind the last nose, m.
    pub landing: f64,
}

impl Stairs {
    /// The staircase of Paillat et al. (15 cm by 28 cm), five risers, two metres wide, its first nose 1.5 m ahead.
    pub const fn paper() -> Self {
        Self {
            riser: 0.15,
            run: 0.28,
            count: 5,
            width: 2.0,
            first_nose_x: 1.5,
            landing: 6.0,
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

/// A box that does not move: its top face is what matters.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Block {
    /// Centre, m.
    pub centre: [f64; 3],
    /// Half of each edge, m.
    pub half: [f64; 3],
}

/// Half length of the ground, m.
const GROUND: f64 = 100.0;
/// How far blocks reach below the ground, m: no hidden edge lies at the level where the robot drives.
const BELOW: f64 = 1.0;

impl Terrain {
    /// The blocks, the ground first. An incline's are given in its own axes.
    pub fn blocks(&self) -> Vec<Block> {
        let ground = Block {
            centre: [0.0, 0.0, -BELOW],
            half: [GROUND, GROUND, BELOW],
        };
        let step = |x0: f64, x1: f64, top: f64, width: f64| Block {
            centre: [0.5 * (x0 + x1), 0.0, 0.5 * (top - BELOW)],
            half: [0.5 * (x1 - x0), 0.5 * width, 0.5 * (top + BELOW)],
        };
        let mut blocks = vec![ground];
        match *self {
            Self::Flat | Self::Incline { .. } => {}
            Self::Stairs(stairs) => blocks.extend((0..stairs.count).map(|i| {
                let end = stairs.last_nose_x() + stairs.landing;
                let nose = stairs.first_nose_x + stairs.run * i as f64;
                step(nose, end, stairs.riser * (i + 1) as f64, stairs.width)
            })),
            Self::Curb {
                height,
                front_x,
                depth,
            } => blocks.push(step(front_x, front_x + depth, height, GROUND)),
        }
        blocks
    }

    /// Rise of the whole ground along x and to the left, rad; zero but on an incline.
    pub fn inclination(&self) -> [f64; 2] {
        match *self {
            Self::Incline { pitch, roll } => [pitch, roll],
            _ => [0.0; 2],
        }
    }

    /// Corners of the ground's section at y = 0 as (x, z) from `from_x` to `to_x`, for a drawing.
    pub fn section(&self, from_x: f64, to_x: f64) -> Vec<[f64; 2]> {
        let slope = libm::tan(self.inclination()[0]);
        let mut corners = vec![[from_x, from_x * slope]];
        let blocks = self.blocks();
        for block in &blocks[1..] {
            let nose = block.centre[0] - block.half[0];
            let below = corners.last().map_or(0.0, |corner| corner[1]);
            corners.extend([[nose, below], [nose, block.centre[2] + block.half[2]]]);
        }
        let top = corners.last().map_or(0.0, |corner| corner[1]);
        if let Some(end) = blocks[1..]
            .first()
            .map(|block| block.centre[0] + block.half[0])
            .filter(|end| *end < to_x)
        {
            corners.extend([[end, top], [end, 0.0], [to_x, 0.0]]);
        } else {
            corners.push([to_x, if slope == 0.0 { top } else { to_x * slope }]);
        }
        corners
    }
}
