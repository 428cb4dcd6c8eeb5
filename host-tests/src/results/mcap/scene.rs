//! Draws the robot and its ground as `foxglove.SceneUpdate` and `foxglove.FrameTransforms`.
//!
//! Every body has its own coordinate frame. The body's shape is drawn in that frame once, and the
//! transforms move the frame.

use super::messages::timestamp;
use crate::simulator::record::Sample;
use crate::world::truth::{BodyPose, BodyShape, Part, Sketch};
use crate::world::{Plant, grid};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

/// The coordinate frame of the ground.
pub const WORLD: &str = "world";
/// Distance by which the drawn ground extends beyond the robot's path, m.
const AROUND: f64 = 1.5;
/// Minimum edge length of the ground's cells, m, and maximum number of cells along each axis.
const CELL: f64 = 0.1;
const MOST_CELLS: f64 = 100.0;

const EARTH: [f64; 4] = [0.72, 0.69, 0.62, 1.0];
const BODY: [f64; 4] = [0.45, 0.57, 0.66, 1.0];
const WHEEL: [f64; 4] = [0.17, 0.20, 0.22, 1.0];
const STRUT: [f64; 4] = [0.30, 0.34, 0.37, 1.0];

/// Shapes and lines through which the robot is drawn.
pub(super) struct Picture {
    pub shapes: Vec<BodyShape>,
    pub sketch: Sketch,
}

impl Picture {
    pub fn new(plant: &dyn Plant) -> Self {
        Self {
            shapes: plant.bodies(),
            sketch: plant.sketch(),
        }
    }
}

fn color([r, g, b, a]: [f64; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}

/// Rounds to 0.01 mm, which is enough for a picture.
fn rounded(value: f64) -> f64 {
    (value * 1e5).round() * 1e-5
}

fn vector(value: [f64; 3]) -> Value {
    let [x, y, z] = value.map(rounded);
    json!({ "x": x, "y": y, "z": z })
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Value {
    json!({ "x": x, "y": y, "z": z, "w": w })
}

fn pose(place: [f64; 3], rotation: [f64; 4]) -> Value {
    json!({ "position": vector(place), "orientation": quaternion(rotation) })
}

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// Rotation from the z axis, along which Foxglove draws cylinders, to the y axis.
const LYING: [f64; 4] = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];

/// An entity of the scene that draws nothing yet.
fn entity(time_s: f64, frame: &str, id: &str) -> Value {
    json!({
        "timestamp": timestamp(time_s), "frame_id": frame, "id": id,
        "lifetime": { "sec": 0, "nsec": 0 }, "frame_locked": true, "metadata": [],
        "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [],
        "triangles": [], "texts": [], "models": [],
    })
}

fn update(entities: &[Value]) -> Value {
    json!({ "deletions": [], "entities": entities })
}

fn body(time_s: f64, shape: &BodyShape) -> Value {
    let mut entity = entity(time_s, shape.name, shape.name);
    let (mut cubes, mut cylinders) = (Vec::new(), Vec::new());
    for part in &shape.parts {
        match *part {
            Part::Box { centre, size } => cubes.push(json!({
                "pose": pose(centre, UPRIGHT), "size": vector(size), "color": color(BODY),
            })),
            Part::Wheel {
                centre,
                radius,
                width,
            } => cylinders.push(json!({
                "pose": pose(centre, LYING),
                "size": vector([2.0 * radius, 2.0 * radius, width]),
                "bottom_scale": 1.0, "top_scale": 1.0, "color": color(WHEEL),
            })),
        }
    }
    entity["cubes"] = cubes.into();
    entity["cylinders"] = cylinders.into();
    entity
}

/// Extent of a robot's path, m.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extent([[f64; 2]; 2]);

impl Extent {
    /// Extends it to a place.
    pub fn include(&mut self, place: [f64; 3]) {
        for ([from, to], place) in self.0.iter_mut().zip(place) {
            *from = f64::min(*from, place);
            *to = f64::max(*to, place);
        }
    }
}

/// Ground and bodies, which are drawn once.
pub fn still(plant: &dyn Plant, extent: &Extent) -> Value {
    let shapes = plant.bodies();
    let bodies = shapes.iter().map(|shape| body(0.0, shape));
    let ground = std::iter::once(ground(plant, extent));
    update(&ground.chain(bodies).collect::<Vec<_>>())
}

/// Lines between moving points: legs and arms.
pub fn struts(sketch: &Sketch, sample: &Sample) -> Value {
    let mut entity = entity(sample.time_s, WORLD, "struts");
    let points = &sample.truth.points;
    let lines = sketch.lines.iter().map(|line| {
        let places = line.iter().filter_map(|index| points.get(*index));
        json!({
            "type": 0, "pose": pose([0.0; 3], UPRIGHT), "thickness": 0.012, "scale_invariant": false,
            "points": places.map(|place| vector(*place)).collect::<Vec<_>>(),
            "color": color(STRUT), "colors": [], "indices": [],
        })
    });
    entity["lines"] = lines.collect::<Vec<_>>().into();
    update(&[entity])
}

/// Poses of all bodies.
pub fn transforms(shapes: &[BodyShape], sample: &Sample) -> Value {
    let transform = |(shape, pose): (&BodyShape, &BodyPose)| {
        json!({
            "timestamp": timestamp(sample.time_s),
            "parent_frame_id": WORLD, "child_frame_id": shape.name,
            "translation": vector(pose.place),
            "rotation": quaternion(pose.rotation.map(|part| (part * 1e7).round() * 1e-7)),
        })
    };
    let transforms = shapes.iter().zip(&sample.bodies).map(transform);
    json!({ "transforms": transforms.collect::<Vec<_>>() })
}

/// The ground around the robot's path, as triangles.
fn ground(plant: &dyn Plant, extent: &Extent) -> Value {
    let area = extent.0.map(|[from, to]| [from - AROUND, to + AROUND]);
    let [xs, ys] = &grid::lines(plant, area, CELL, MOST_CELLS);
    let mut points = Vec::new();
    let mut indices = Vec::new();
    for (i, x) in xs.iter().enumerate() {
        for (j, y) in ys.iter().enumerate() {
            points.push(vector([*x, *y, plant.ground_height([*x, *y])]));
            if i + 1 < xs.len() && j + 1 < ys.len() {
                let corner = i * ys.len() + j;
                let next = corner + ys.len();
                indices.extend([corner, next, next + 1, corner, next + 1, corner + 1]);
            }
        }
    }
    let mut entity = entity(0.0, WORLD, "ground");
    entity["triangles"] = json!([{
        "pose": pose([0.0; 3], UPRIGHT), "points": points, "color": color(EARTH),
        "colors": [], "indices": indices,
    }]);
    entity
}

/// A scene that contains each kind of primitive once, from which its schema is derived.
pub fn example() -> Value {
    let wheel = Part::Wheel {
        centre: [0.5; 3],
        radius: 0.5,
        width: 0.5,
    };
    let cube = Part::Box {
        centre: [0.5; 3],
        size: [0.5; 3],
    };
    let mut full = body(
        0.0,
        &BodyShape {
            name: WORLD,
            parts: vec![wheel, cube],
        },
    );
    let sketch = Sketch {
        circles: Vec::new(),
        lines: vec![vec![0]],
    };
    let mut sample = Sample::default();
    sample.truth.points = vec![[0.5; 3]];
    full["lines"] = struts(&sketch, &sample)["entities"][0]["lines"].clone();
    full["triangles"] = json!([{
        "pose": pose([0.5; 3], UPRIGHT), "points": [vector([0.5; 3])], "color": color(EARTH),
        "colors": [color(EARTH)], "indices": [0],
    }]);
    update(&[full])
}

/// A transform from which the schema of transforms is derived.
pub fn transforms_example() -> Value {
    let shape = BodyShape {
        name: WORLD,
        parts: Vec::new(),
    };
    let sample = Sample {
        bodies: vec![BodyPose {
            place: [0.5; 3],
            rotation: [0.5; 4],
        }],
        ..Sample::default()
    };
    transforms(&[shape], &sample)
}
