//! Measures how long the computations of the control core take on the host.
//!
//! Each is compared with a plain implementation in double precision, without tables and prepared
//! sums. Only the ratios of times measured on one computer are meaningful. `cargo cost` counts the
//! instructions on the target.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tautrack::math::sin_cos;
use tautrack::robots::b2p2::shape::AXLE_3_FROM_BODY_3;
use tautrack::robots::b2p2::{Masses, Model, Parameters, Posture};
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::{self, Potential};
use tautrack::screw::Geometry;
use tautrack::settings::Settings;
use tautrack::stability::support::margins;
use tautrack::stability::tipover::{Edges, angles};
use tautrack::stability::zmp::{Plane, zero_moment_point};
use tautrack::units::Angle;

const SUPPORT: [[f64; 2]; 4] = [[0.0, -0.16], [0.77, -0.16], [0.77, 0.16], [0.0, 0.16]];

/// Computes the centre of gravity of B2P2 body by body, without prepared sums.
fn centre_of_gravity(masses: &Masses, theta: f64, l3: f64) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    let front = |body: [f32; 3], slid: f64| {
        let [along, left, up] = body.map(f64::from);
        [
            0.32 + (along + slid) * cos - up * sin,
            left,
            (along + slid) * sin + up * cos,
        ]
    };
    let slid = 0.23 + l3 - f64::from(AXLE_3_FROM_BODY_3);
    let Masses {
        body_1,
        body_2,
        body_3,
        ..
    } = masses;
    let bodies = [
        (body_1.mass, body_1.place.map(f64::from)),
        (body_2.mass, front(body_2.place, 0.0)),
        (body_3.mass, front(body_3.place, slid)),
    ];
    let total: f64 = bodies.iter().map(|(mass, _)| f64::from(*mass)).sum();
    [0, 1, 2].map(|axis| {
        bodies
            .iter()
            .map(|(mass, place)| f64::from(*mass) * place[axis])
            .sum::<f64>()
            / total
    })
}

fn extension(theta: f64) -> (f64, f64) {
    let (l1, l2, k) = black_box((0.32, 0.23, 1.232));
    let (sin, cos) = theta.sin_cos();
    let r = (k * k - l1 * l1) / (2.0 * (k + l1 * cos));
    (r - l2, r * l1 * sin / (k + l1 * cos))
}

fn double_margins(support: &[[f64; 2]; 4], cog: [f64; 2]) -> [f64; 4] {
    [0, 1, 2, 3].map(|corner| {
        let (from, to) = (support[corner], support[(corner + 1) % 4]);
        let edge = [to[0] - from[0], to[1] - from[1]];
        let offset = [cog[0] - from[0], cog[1] - from[1]];
        (edge[0] * offset[1] - edge[1] * offset[0]) / edge[0].hypot(edge[1])
    })
}

fn model(criterion: &mut Criterion) {
    let masses = Masses::new(&Settings::default());
    let (angle, radians) = (Angle::from_radians(0.7), 0.7_f64);
    let mut group = criterion.benchmark_group("sine and cosine");
    group.bench_function("table, f32", |bench| {
        bench.iter(|| sin_cos(black_box(angle)));
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| black_box(radians).sin_cos());
    });
    group.finish();

    let geometry =
        Geometry::from_micrometres(320_000, 230_000, 1_232_000).expect("the nominal geometry");
    let mut group = criterion.benchmark_group("screw extension with derivative");
    group.bench_function("table, fixed point", |bench| {
        bench.iter(|| geometry.extension(black_box(angle)));
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| extension(black_box(radians)));
    });
    group.finish();

    let b2p2 = Model::new(&Settings::default());
    let mut group = criterion.benchmark_group("CoG of B2P2");
    group.bench_function("prepared, f32", |bench| {
        bench.iter(|| b2p2.shape(black_box(angle), black_box(0.3)).cog);
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| centre_of_gravity(&masses, black_box(radians), black_box(0.3)));
    });
    group.finish();

    let support = SUPPORT.map(|[x, y]| [x as f32, y as f32, 0.0]);
    let mut group = criterion.benchmark_group("four margins");
    group.bench_function("f32", |bench| {
        bench.iter(|| margins(black_box(&support), black_box([0.3, 0.05, 0.1])));
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| double_margins(black_box(&SUPPORT), black_box([0.3, 0.05])));
    });
    group.finish();
}

/// Computes frames and inertia matrix of the same robot without using its structure: products of 4
/// x 4 matrices down the table of links, full Jacobians, sums over all segments.
mod naive {
    use tautrack::robots::b2p2::parameters::{LENGTHS, SEGMENTS};

    pub type Matrix4 = [[f64; 4]; 4];
    type Vector = [f64; 3];

    fn product(a: &Matrix4, b: &Matrix4) -> Matrix4 {
        let mut c = [[0.0; 4]; 4];
        for (row, out) in c.iter_mut().enumerate() {
            for (column, value) in out.iter_mut().enumerate() {
                *value = (0..4).map(|k| a[row][k] * b[k][column]).sum();
            }
        }
        c
    }

    /// Transformation from one link to the next:
    /// `Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)`.
    fn link(alpha: f64, d: f64, theta: f64, r: f64) -> Matrix4 {
        let ((sa, ca), (st, ct)) = (alpha.sin_cos(), theta.sin_cos());
        [
            [ct, -st, 0.0, d],
            [ca * st, ca * ct, -sa, -r * sa],
            [sa * st, sa * ct, ca, r * ca],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// Frames R1 to R8, computed from the paper's table.
    pub fn frames(q: &[f64; 8]) -> [Matrix4; 8] {
        use std::f64::consts::FRAC_PI_2 as QUARTER;
        let table = [
            (-QUARTER, 0.0, QUARTER, q[0]),
            (QUARTER, 0.0, QUARTER, q[1]),
            (-QUARTER, 0.0, -QUARTER, q[2]),
            (0.0, 0.0, q[3], 0.0),
            (-QUARTER, 0.0, q[4] - QUARTER, 0.0),
            (-QUARTER, 0.0, q[5] - QUARTER, 0.0),
            (0.0, LENGTHS.l1, q[6] + QUARTER, 0.0),
            (QUARTER, 0.0, 0.0, LENGTHS.l2 + q[7]),
        ];
        let mut frame = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        table.map(|(alpha, d, theta, r)| {
            frame = product(&frame, &link(alpha, d, theta, r));
            frame
        })
    }

    fn cross(a: Vector, b: Vector) -> Vector {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    }

    /// Inertia matrix, eq. 7 as printed: `sum m Jv^T Jv + Jw^T R I R^T Jw`.
    pub fn inertia_matrix(q: &[f64; 8]) -> [[f64; 8]; 8] {
        let frames = frames(q);
        let mut d = [[0.0; 8]; 8];
        for (segment, tabulated) in SEGMENTS.iter().enumerate() {
            let frame = &frames[5 + segment];
            let com = tabulated.centre_of_mass;
            let place: Vector = std::array::from_fn(|row| {
                frame[row][3] + (0..3).map(|k| frame[row][k] * com[k]).sum::<f64>()
            });
            let square: f64 = com.iter().map(|x| x * x).sum();
            let inertia: [Vector; 3] = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let shift = if i == j { square } else { 0.0 } - com[i] * com[j];
                    tabulated.inertia_about_origin[i][j] - tabulated.mass * shift
                })
            });
            let (mut linear, mut angular) = ([[0.0; 3]; 8], [[0.0; 3]; 8]);
            for joint in 0..=5 + segment {
                let axis: Vector = std::array::from_fn(|row| frames[joint][row][2]);
                let slides = joint < 3 || joint == 7;
                if slides {
                    linear[joint] = axis;
                } else {
                    let arm = std::array::from_fn(|row| place[row] - frames[joint][row][3]);
                    linear[joint] = cross(axis, arm);
                    // In the segment's own frame, because its inertia is given there.
                    angular[joint] = std::array::from_fn(|column| {
                        (0..3).map(|row| frame[row][column] * axis[row]).sum()
                    });
                }
            }
            for i in 0..8 {
                for j in 0..8 {
                    for k in 0..3 {
                        d[i][j] += tabulated.mass * linear[i][k] * linear[j][k];
                        for l in 0..3 {
                            d[i][j] += angular[i][k] * inertia[k][l] * angular[j][l];
                        }
                    }
                }
            }
        }
        d
    }
}

/// Number of postures and motions over which the dynamic model is measured.
const MOTIONS: usize = 1024;

/// Random joint positions (m, rad), rates and accelerations: far beyond what the robot reaches. A
/// processor that has learnt one posture would compute it faster.
fn motions() -> Vec<[[f64; 8]; 3]> {
    let mut state = 1_u64;
    let mut random = || {
        // Constants of Knuth's 64-bit generator.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let range = [2.0, 2.0, 2.0, 3.1, 1.5, 1.5, 2.5, 0.3];
    (0..MOTIONS)
        .map(|_| [range, [2.0; 8], [5.0; 8]].map(|range| range.map(|most| most * random())))
        .collect()
}

/// Measures the dynamic model in one precision, over random motions.
macro_rules! dynamics {
    ($criterion:expr, $scalar:ty, $name:literal) => {{
        let parameters = Parameters::<$scalar>::paper();
        let motions: Vec<[[$scalar; 8]; 3]> = motions()
            .into_iter()
            .map(|motion| motion.map(|joints| joints.map(|value| value as $scalar)))
            .collect();
        let mut motions = motions.iter().cycle();
        let mut motion = || black_box(motions.next().expect("there are motions"));
        let contacts: [[$scalar; 3]; 4] = SUPPORT.map(|[x, y]| [x as $scalar, y as $scalar, -0.05]);
        let plane = Plane::<$scalar> {
            point: [0.0, 0.0, -0.05],
            normal: [0.0, 0.0, 1.0],
        };
        let edges = Edges::new(&contacts).expect("the support has edges");
        let posture = |q: &[$scalar; 8]| Posture::new(&parameters, q);
        let cog: [$scalar; 3] = [0.3, 0.05, 0.1];
        let force: [$scalar; 3] = [3.0, 1.0, -81.0];
        let mut group = $criterion.benchmark_group("dynamics of B2P2");
        group.bench_function(concat!("frames, ", $name), |bench| {
            bench.iter(|| posture(&motion()[0]).frames());
        });
        group.bench_function(concat!("CoG, ", $name), |bench| {
            bench.iter(|| posture(&motion()[0]).cog());
        });
        group.bench_function(concat!("D, ", $name), |bench| {
            bench.iter(|| posture(&motion()[0]).inertia_matrix());
        });
        group.bench_function(concat!("C, ", $name), |bench| {
            bench.iter(|| {
                let [q, rates, _] = motion();
                posture(q).coriolis_matrix(rates)
            });
        });
        group.bench_function(concat!("inverse dynamics, ", $name), |bench| {
            bench.iter(|| {
                let [q, rates, accelerations] = motion();
                posture(q).newton_euler(rates, accelerations).forces
            });
        });
        group.bench_function(
            concat!("inverse dynamics by the matrices, ", $name),
            |bench| {
                bench.iter(|| {
                    let [q, rates, accelerations] = motion();
                    posture(q).lagrange(rates, accelerations)
                });
            },
        );
        group.bench_function(concat!("ZMP from q, v and a, ", $name), |bench| {
            bench.iter(|| {
                let [q, rates, accelerations] = motion();
                let effort = posture(q).newton_euler(rates, accelerations);
                zero_moment_point(&effort.reaction, &plane)
            });
        });
        group.bench_function(concat!("four tip-over angles, ", $name), |bench| {
            bench.iter(|| angles(black_box(&contacts), cog, black_box(force), [0.0; 3]));
        });
        group.bench_function(concat!("minimum tip-over angle, ", $name), |bench| {
            bench.iter(|| black_box(&edges).margin(cog, black_box(force), [0.0; 3]));
        });
        group.finish();
    }};
}

fn dynamics(criterion: &mut Criterion) {
    let parameters = Parameters::<f64>::paper();
    let motions = motions();
    // Both implementations must compute the same matrix.
    for [q, ..] in &motions {
        let structured = Posture::new(&parameters, q).inertia_matrix();
        let plain = naive::inertia_matrix(q);
        for (row, other) in structured.iter().zip(&plain) {
            for (value, other) in row.iter().zip(other) {
                assert!((value - other).abs() < 1e-12, "{structured:?} {plain:?}");
            }
        }
    }
    let mut motions = motions.iter().cycle();
    let mut posture = || black_box(&motions.next().expect("there are motions")[0]);
    let mut group = criterion.benchmark_group("dynamics of B2P2, naive");
    group.bench_function("frames, f64", |bench| {
        bench.iter(|| naive::frames(posture()));
    });
    group.bench_function("D, f64", |bench| {
        bench.iter(|| naive::inertia_matrix(posture()));
    });
    group.finish();
    dynamics!(criterion, f64, "f64");
    dynamics!(criterion, f32, "f32");
}

/// Measures one step of Hylos' body controller on a slope.
macro_rules! hylos_control {
    ($criterion:expr, $scalar:ty, $name:literal) => {{
        let parameters = hylos::Parameters::<$scalar>::nominal();
        let (sine, cosine) = (0.4 as $scalar).sin_cos();
        let sensed = hylos::Sensed::<$scalar> {
            legs: [stance(&parameters, 0.29); 4],
            torques: [[10.0, -5.0]; 4],
            steering: [0.1, -0.1, 0.2, -0.2],
            up: [0.0, sine, cosine],
            acceleration: [0.0; 3],
        };
        let desired = hylos::Desired {
            forward: 0.2,
            yaw_rate: 0.1,
            clearance: Some(0.29),
        };
        let potential = Potential::new(0.004, 0.35, 0.02).expect("the nominal potential");
        let mut controller = hylos::Controller::new(parameters, potential, &sensed);
        $criterion.bench_function(concat!("step of Hylos' controller, ", $name), |bench| {
            bench.iter(|| controller.step(black_box(&sensed), &desired, 0.008));
        });
    }};
}

fn control(criterion: &mut Criterion) {
    hylos_control!(criterion, f64, "f64");
    hylos_control!(criterion, f32, "f32");
}

criterion_group!(benches, model, dynamics, control);
criterion_main!(benches);
