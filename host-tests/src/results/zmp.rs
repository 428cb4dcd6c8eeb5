//! Computes centre of gravity and zero moment point along the robot's heading from the simulator's
//! ground truth, as in Fig. 8 of Paillat, Lucidarme and Hardouin (Variable Geometry Tracked
//! Unmanned Grounded Vehicle).
//!
//! The model is the one of the nodes, in double precision: [`Posture`], its Newton-Euler pass and
//! [`zero_moment_point`]. The ground truth has the joints q of each sample. q' and q'' are central
//! differences of the samples before and after it, so an acceleration is a mean over 20 ms.
//!
//! The paper computes accelerations from encoders and does not say how it filters them. It also
//! does not say to which length its percentage refers. Here it is the [whole length](length) of the
//! straight robot.

use crate::results::phases;
use crate::robots::b2p2::plant::B2p2Parameters;
use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};
use crate::world::ground::Ground;
use crate::world::load::Load;
use serde::Serialize;
use std::f64::consts::{PI, TAU};
use std::ops::Range;
use tautrack::math::vector::{Symmetric, add, dot, scale, sub};
use tautrack::robots::b2p2::parameters::{LENGTHS, Lengths, SEGMENTS};
use tautrack::robots::b2p2::{Joints, Parameters, Posture, Tabulated};
use tautrack::stability::zmp::{Plane, ZeroMomentPoint, zero_moment_point};

/// Mean difference that the paper reports for its climb, %.
pub const PAPER_PERCENT: f64 = 0.21;
/// Standard deviation of the Gaussian that smooths the difference, s.
pub const SMOOTHING_S: f64 = 0.15;
/// Minimum horizontal distance of two contacts that define the slope of the plane, m. Closer
/// contacts may lie above each other.
const LEAST_SPAN: f64 = 0.10;

/// Centre of gravity and zero moment point over a run.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    /// One moment for each sample; `None` for the first and the last one.
    pub moments: Vec<Option<Moment>>,
    /// The areas of the figure, as ranges of samples. A1 lasts from the start of the climb until
    /// the centre of gravity is past the first nose. A2 lasts until it is past the last nose but
    /// one. A3 lasts until the landing. An area that the run never reached is empty.
    pub areas: [Range<usize>; 3],
    /// Figures over the three areas; `None` if the robot never climbed.
    pub figures: Option<Figures>,
}

/// Positions at one sample: coordinates along z5, the level heading, from axle 1, m.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Axles 1 to 3: the paper's P1, P2 and P3.
    pub axles: [f64; 3],
    /// Centre of gravity.
    pub cog: f64,
    /// Zero moment point; absent in free flight.
    pub zmp: Option<f64>,
    /// Zero moment point minus centre of gravity, smoothed over [`SMOOTHING_S`].
    pub smoothed: Option<f64>,
}

impl Moment {
    /// Zero moment point minus centre of gravity, m.
    pub fn difference(&self) -> Option<f64> {
        self.zmp.map(|zmp| zmp - self.cog)
    }
}

/// `|ZMP - CoG|` in percent of the robot's length.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// As computed at each sample, without smoothing.
    pub raw: MeanAndPeak,
    /// Smoothed over [`SMOOTHING_S`].
    pub smoothed: MeanAndPeak,
}

/// Mean and peak of one series, %.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MeanAndPeak {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub peak: f64,
}

/// Length of the straight robot, pulleys included, m.
pub fn length(parameters: &B2p2Parameters) -> f64 {
    parameters.l1 + parameters.taut_length(0.0) + 2.0 * parameters.pulley_radius
}

impl Balance {
    /// Computes the balance over the samples of a run; empty for another robot than B2P2.
    pub fn new(scenario: &Scenario, samples: &[Sample]) -> Self {
        let Some(robot) = scenario.robot.b2p2() else {
            return Self::default();
        };
        let parameters = robot.parameters(scenario.friction);
        let loaded_from = parameters
            .payload
            .map_or(f64::INFINITY, |load| load.from_time_s);
        let models = [None, parameters.payload].map(|payload| model(&parameters, payload));
        let joints: Vec<_> = samples.iter().map(joints).collect();
        let mut moments = vec![None; samples.len()];
        for (index, around) in joints.windows(3).enumerate() {
            let sample = &samples[index + 1];
            let model = &models[usize::from(sample.time_s >= loaded_from)];
            moments[index + 1] = model.as_ref().map(|model| moment(model, sample, around));
        }
        smooth(samples, &mut moments);
        let climb = climb(scenario, samples);
        let Some(areas) = areas(scenario, samples, &climb) else {
            return Self {
                moments,
                ..Self::default()
            };
        };
        let unit = 100.0 / length(&parameters);
        Self {
            figures: figures(&moments[climb], unit),
            moments,
            areas,
        }
    }
}

/// Figures over the moments of a climb. `unit` converts a difference in m to percent.
fn figures(climb: &[Option<Moment>], unit: f64) -> Option<Figures> {
    let of = |difference: fn(&Moment) -> Option<f64>| {
        let values = || climb.iter().flatten().filter_map(difference).map(f64::abs);
        let count = values().count();
        (count > 0).then(|| MeanAndPeak {
            mean: unit * values().sum::<f64>() / count as f64,
            peak: unit * values().fold(0.0, f64::max),
        })
    };
    Some(Figures {
        raw: of(Moment::difference)?,
        smoothed: of(|moment| moment.smoothed)?,
    })
}

/// The samples from the start of the climb to the landing, or until the robot toppled.
fn climb(scenario: &Scenario, samples: &[Sample]) -> Range<usize> {
    let climb = phases::climb(scenario, samples);
    let toppled = samples.iter().position(|sample| sample.truth.toppled);
    let end = toppled.map_or(climb.end, |toppled| climb.end.min(toppled));
    climb.start.min(end)..end
}

/// The nodes' model with the plant's masses; `None` if the parameters are no valid robot.
fn model(plant: &B2p2Parameters, payload: Option<Load>) -> Option<Parameters<f64>> {
    let mut segments = SEGMENTS;
    let body = &mut segments[0];
    let [forward, _, right] = body.centre_of_mass;
    // The plant's height of the centre of mass replaces the tabulated one. The inertia about the
    // centre of mass stays the same.
    let place = [forward, plant.body_1_com_height, right];
    let mut inertia = add_point(
        add_point(body.inertia_about_origin, -body.mass, body.centre_of_mass),
        body.mass,
        place,
    );
    let mut moment = scale(body.mass, place);
    if let Some(load) = payload {
        let [forward, left, up] = load.place;
        let place = [forward, up, -left];
        inertia = add_point(inertia, load.mass, place);
        for (axis, row) in inertia.iter_mut().enumerate() {
            row[axis] += load.own_inertia();
        }
        moment = add(moment, scale(load.mass, place));
        body.mass += load.mass;
    }
    *body = Tabulated {
        mass: body.mass,
        centre_of_mass: scale(1.0 / body.mass, moment),
        inertia_about_origin: inertia,
    };
    let lengths = Lengths {
        l1: plant.l1,
        l2: plant.l2,
        axle_3: plant.axle_3_from_r8,
        ..LENGTHS
    };
    Parameters::new(&lengths, &segments).ok()
}

/// Adds the inertia of a point mass to an inertia, both about the origin, kg m^2.
fn add_point(inertia: [[f64; 3]; 3], mass: f64, place: [f64; 3]) -> [[f64; 3]; 3] {
    let Symmetric {
        diagonal: [xx, yy, zz],
        mixed: [yz, zx, xy],
    } = Symmetric::point_mass(mass, place);
    let point = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    [0, 1, 2].map(|row| add(inertia[row], point[row]))
}

/// Converts a point or direction from world axes (x forward, y left, z up) to R0 (x right, y
/// forward, z up).
fn in_r0([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-y, x, z]
}

fn joints(sample: &Sample) -> Joints<f64> {
    let truth = &sample.truth;
    let [right, forward, up] = in_r0(truth.axle_1);
    let screw = truth.extension - LENGTHS.axle_3;
    [
        forward,
        right,
        up,
        truth.yaw,
        truth.roll,
        truth.pitch,
        truth.theta,
        screw,
    ]
}

/// Computes the moment of `sample`. `around` has the joints before, at and after it.
fn moment(model: &Parameters<f64>, sample: &Sample, around: &[Joints<f64>]) -> Moment {
    let step = 1.0 / f64::from(SAMPLE_HZ);
    let [before, now, after] = [around[0], around[1], around[2]];
    // A heading may jump by a full turn.
    let turned = |joint: usize, angle: f64| match joint {
        3 => (angle + PI).rem_euclid(TAU) - PI,
        _ => angle,
    };
    let path = |from: &Joints<f64>, to: &Joints<f64>| {
        core::array::from_fn::<_, 8, _>(|joint| turned(joint, to[joint] - from[joint]))
    };
    let (gone, coming) = (path(&before, &now), path(&now, &after));
    let rates = core::array::from_fn(|joint| (gone[joint] + coming[joint]) / (2.0 * step));
    let accelerations = core::array::from_fn(|joint| (coming[joint] - gone[joint]) / (step * step));

    let posture = Posture::new(model, &now);
    let (axles, cog) = posture.along_heading();
    let reaction = posture.newton_euler(&rates, &accelerations).reaction;
    let origin = in_r0(sample.truth.axle_1);
    let heading = in_r0([
        libm::cos(sample.truth.yaw),
        libm::sin(sample.truth.yaw),
        0.0,
    ]);
    let zmp =
        ground(sample, heading).and_then(|plane| match zero_moment_point(&reaction, &plane) {
            ZeroMomentPoint::At(point) => Some(dot(heading, sub(point, origin))),
            ZeroMomentPoint::None => None,
        });
    Moment {
        axles,
        cog,
        zmp,
        smoothed: None,
    }
}

/// The plane on which the robot stands: it contains the rearmost and the foremost contact and does
/// not tilt sideways. At rest the zero moment point is below the centre of gravity on any plane.
/// The plane matters only for how far a motion moves the zero moment point.
fn ground(sample: &Sample, heading: [f64; 3]) -> Option<Plane<f64>> {
    let along = |point: &[f64; 3]| dot(heading, *point);
    let contacts = || sample.truth.contacts.iter().map(|point| in_r0(*point));
    let rear = contacts().min_by(|a, b| along(a).total_cmp(&along(b)))?;
    let front = contacts().max_by(|a, b| along(a).total_cmp(&along(b)))?;
    let span = along(&front) - along(&rear);
    let rise = if span < LEAST_SPAN {
        0.0
    } else {
        (front[2] - rear[2]) / span
    };
    Some(Plane {
        point: rear,
        normal: sub([0.0, 0.0, 1.0], scale(rise, heading)),
    })
}

/// Computes the smoothed differences: a Gaussian mean of the differences within three standard
/// deviations.
fn smooth(samples: &[Sample], moments: &mut [Option<Moment>]) {
    let differences: Vec<_> = moments
        .iter()
        .map(|moment| moment.as_ref().and_then(Moment::difference))
        .collect();
    let reach = (3.0 * SMOOTHING_S * f64::from(SAMPLE_HZ)) as usize;
    for (index, moment) in moments.iter_mut().enumerate() {
        let Some(moment) = moment else { continue };
        let (mut sum, mut weights) = (0.0, 0.0);
        let window = index.saturating_sub(reach)..(index + reach + 1).min(samples.len());
        for other in window {
            if let Some(difference) = differences[other] {
                let distance = (samples[other].time_s - samples[index].time_s) / SMOOTHING_S;
                let weight = libm::exp(-0.5 * distance * distance);
                sum += weight * difference;
                weights += weight;
            }
        }
        moment.smoothed = (weights > 0.0).then(|| sum / weights);
    }
}

/// Splits the climb into the three areas; `None` on ground without a nose.
fn areas(
    scenario: &Scenario,
    samples: &[Sample],
    climb: &Range<usize>,
) -> Option<[Range<usize>; 3]> {
    let (first, last_but_one) = match scenario.terrain.ground() {
        Ground::Stairs(stairs) => {
            let first = stairs.first_nose_x;
            (first, f64::max(first, stairs.last_nose_x() - stairs.run))
        }
        Ground::Curb { front_x, .. } => (front_x, front_x),
        Ground::Flat | Ground::Ramp { .. } | Ground::Incline { .. } => return None,
    };
    let past = |nose: f64| {
        samples[climb.clone()]
            .iter()
            .position(|sample| sample.truth.cog[0] > nose)
            .map_or(climb.end, |index| climb.start + index)
    };
    let (first, last) = (past(first), past(last_but_one));
    Some([climb.start..first, first..last, last..climb.end])
}
