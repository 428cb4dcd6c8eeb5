//! Tests B2P2's model against the reference vectors, against other ways to compute the same values,
//! and against physics.

use crate::counted::{Counted, operations};
use crate::random::Random;
use serde_json::Value;
use tautrack::math::Scalar;
use tautrack::math::vector::dot;
use tautrack::robots::b2p2::model::actuation::{Actuation, MotorTorques};
use tautrack::robots::b2p2::model::belt::TautBelt;
use tautrack::robots::b2p2::parameters::{LENGTHS, SEGMENTS};
use tautrack::robots::b2p2::{Model, Parameters, ParametersError, Posture};
use tautrack::settings::{Setting, Settings};
use tautrack::stability::tipover::angles;
use tautrack::units::Angle;

type Joints = [f64; 8];
type Matrix = [[f64; 8]; 8];

fn rates(random: &mut Random) -> Joints {
    random.joints([2.0; 8])
}

fn inertia(parameters: &Parameters<f64>, q: &Joints) -> Matrix {
    Posture::new(parameters, q).inertia_matrix()
}

fn times(matrix: &Matrix, vector: &Joints) -> Joints {
    matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

/// Lower triangle `L` of `A = L L^T`; `None` if `A` is not positive definite.
fn cholesky(matrix: &Matrix) -> Option<Matrix> {
    let mut lower = [[0.0; 8]; 8];
    for row in 0..8 {
        for column in 0..=row {
            let sum: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = matrix[row][column] - sum;
            lower[row][column] = if row == column {
                if !(rest > 0.0) {
                    return None;
                }
                rest.sqrt()
            } else {
                rest / lower[column][column]
            };
        }
    }
    Some(lower)
}

fn solve(matrix: &Matrix, right: &Joints) -> Joints {
    let lower = cholesky(matrix).expect("positive definite");
    let mut x = *right;
    for row in 0..8 {
        let sum: f64 = (0..row).map(|k| lower[row][k] * x[k]).sum();
        x[row] = (x[row] - sum) / lower[row][row];
    }
    for row in (0..8).rev() {
        let sum: f64 = (row + 1..8).map(|k| lower[k][row] * x[k]).sum();
        x[row] = (x[row] - sum) / lower[row][row];
    }
    x
}

/// Derivative `d D / d q_joint` by central differences.
fn slope(parameters: &Parameters<f64>, q: &Joints, joint: usize) -> Matrix {
    const STEP: f64 = 1e-5;
    let at = |offset: f64| {
        let mut moved = *q;
        moved[joint] += offset;
        inertia(parameters, &moved)
    };
    let (above, below) = (at(STEP), at(-STEP));
    std::array::from_fn(|i| std::array::from_fn(|j| (above[i][j] - below[i][j]) / (2.0 * STEP)))
}

fn near(got: f64, want: f64, allowed: f64, what: &str) {
    assert!((got - want).abs() <= allowed, "{what}: {got} {want}");
}

#[test]
fn both_routes_to_the_forces_meet_the_vectors() {
    let text = include_str!("../../../host-tests/vectors/b2p2_dynamics.json");
    let document: Value = serde_json::from_str(text).unwrap();
    let parameters = Parameters::paper();
    for case in document["functions"]["dynamics"].as_array().unwrap() {
        let read = |side: &str, name: &str| -> Joints {
            let list = case[side][name].as_array().unwrap();
            std::array::from_fn(|index| list[index].as_f64().unwrap())
        };
        let posture = Posture::new(&parameters, &read("in", "q"));
        let (qd, qdd) = (read("in", "qd"), read("in", "qdd"));
        let by_matrices = posture.lagrange(&qd, &qdd);
        let by_recursion = posture.newton_euler(&qd, &qdd).forces;
        for (index, want) in read("out", "T").into_iter().enumerate() {
            let allowed = 1e-10 * want.abs().max(1.0);
            near(by_matrices[index], want, allowed, "matrices");
            near(by_recursion[index], want, allowed, "recursion");
        }
    }
}

#[test]
fn inertia_matrix_is_the_sum_of_equation_7_and_positive_definite() {
    let mut random = Random(1);
    let parameters = Parameters::paper();
    let text = include_str!("../../../host-tests/vectors/b2p2_dynamics.json");
    let document: Value = serde_json::from_str(text).unwrap();
    // Inertias about the centres of mass as the reference computed them.
    let about_com = |segment: usize, row: usize, column: usize| {
        document["params"]["inertia_com"][segment][row][column]
            .as_f64()
            .unwrap()
    };
    for _ in 0..500 {
        let posture = Posture::new(&parameters, &random.q());
        let d = posture.inertia_matrix();
        let (jacobians, frames) = (posture.jacobians(), posture.frames());
        for (j, row_of_d) in d.iter().enumerate() {
            for (k, got) in row_of_d.iter().enumerate() {
                let mut sum = 0.0;
                for (segment, jacobian) in jacobians.iter().enumerate() {
                    let axes = frames[5 + segment].axes;
                    let (a, b) = (jacobian.angular[j], jacobian.angular[k]);
                    sum += SEGMENTS[segment].mass * dot(jacobian.linear[j], jacobian.linear[k]);
                    for row in 0..3 {
                        for column in 0..3 {
                            sum += dot(axes[row], a)
                                * about_com(segment, row, column)
                                * dot(axes[column], b);
                        }
                    }
                }
                near(*got, sum, 1e-12, "eq. 7");
                assert_eq!(*got, d[k][j], "symmetric");
            }
        }
        assert!(cholesky(&d).is_some(), "{d:?}");
    }
}

#[test]
fn inertia_matrix_is_positive_definite_in_single_precision() {
    let mut random = Random(2);
    let parameters = Parameters::<f32>::paper();
    for _ in 0..500 {
        let q = random.q().map(|value| value as f32);
        let d = Posture::new(&parameters, &q).inertia_matrix();
        assert!(
            cholesky(&d.map(|row| row.map(f64::from))).is_some(),
            "{d:?}"
        );
    }
}

#[test]
fn jacobians_are_the_derivatives_of_the_centres_of_mass() {
    const STEP: f64 = 1e-6;
    let mut random = Random(3);
    let parameters = Parameters::paper();
    for _ in 0..100 {
        let q = random.q();
        let jacobians = Posture::new(&parameters, &q).jacobians();
        for joint in 0..8 {
            let coms = |offset: f64| {
                let mut moved = q;
                moved[joint] += offset;
                Posture::new(&parameters, &moved).coms()
            };
            let (above, below) = (coms(STEP), coms(-STEP));
            for segment in 0..3 {
                for axis in 0..3 {
                    let slope = (above[segment][axis] - below[segment][axis]) / (2.0 * STEP);
                    near(
                        jacobians[segment].linear[joint][axis],
                        slope,
                        1e-9,
                        "linear",
                    );
                }
            }
        }
    }
}

#[test]
fn coriolis_matrix_has_the_christoffel_symbols_of_equation_12() {
    let mut random = Random(4);
    let parameters = Parameters::paper();
    for _ in 0..50 {
        let (q, qd) = (random.q(), rates(&mut random));
        let c = Posture::new(&parameters, &q).coriolis_matrix(&qd);
        let slopes: [Matrix; 8] = std::array::from_fn(|joint| slope(&parameters, &q, joint));
        for j in 0..8 {
            for m in 0..8 {
                let symbols: f64 = (0..8)
                    .map(|n| 0.5 * (slopes[n][j][m] + slopes[m][j][n] - slopes[j][n][m]) * qd[n])
                    .sum();
                near(c[j][m], symbols, 2e-8, "eq. 12");
            }
        }
        // From this follows that `D' - 2 C` is skew-symmetric, which conserves energy.
        for j in 0..8 {
            for k in 0..8 {
                let rate: f64 = (0..8).map(|n| slopes[n][j][k] * qd[n]).sum();
                near(rate, c[j][k] + c[k][j], 2e-8, "D' - 2 C");
            }
        }
    }
}

#[test]
fn recursion_and_matrices_agree() {
    let mut random = Random(5);
    let (double, single) = (Parameters::paper(), Parameters::<f32>::paper());
    let mut worst = [0.0f64; 2];
    for _ in 0..1000 {
        let (q, qd, qdd) = (random.q(), rates(&mut random), random.joints([5.0; 8]));
        let posture = Posture::new(&double, &q);
        let (matrices, recursion) = (
            posture.lagrange(&qd, &qdd),
            posture.newton_euler(&qd, &qdd).forces,
        );
        let narrow = |joints: Joints| joints.map(|value| value as f32);
        let in_single = Posture::new(&single, &narrow(q))
            .newton_euler(&narrow(qd), &narrow(qdd))
            .forces;
        for joint in 0..8 {
            worst[0] = worst[0].max((matrices[joint] - recursion[joint]).abs());
            worst[1] = worst[1].max((f64::from(in_single[joint]) - recursion[joint]).abs());
        }
    }
    println!("f64 {:.2e}, f32 {:.2e} N or N m", worst[0], worst[1]);
    assert!(worst[0] <= 1e-12 && worst[1] <= 3e-4, "{worst:?}");
}

#[test]
fn a_free_robot_keeps_its_energy_and_momentum() {
    let parameters = Parameters::paper();
    let energy = |q: &Joints, qd: &Joints| {
        let posture = Posture::new(&parameters, q);
        let kinetic = 0.5 * dot_joints(qd, &times(&posture.inertia_matrix(), qd));
        kinetic + parameters.mass() * parameters.gravity() * posture.cog()[2]
    };
    let acceleration = |q: &Joints, qd: &Joints| {
        let posture = Posture::new(&parameters, q);
        let bias = posture.newton_euler(qd, &[0.0; 8]).forces;
        solve(&posture.inertia_matrix(), &bias.map(|force| -force))
    };
    let step =
        |a: &Joints, b: &Joints, h: f64| -> Joints { std::array::from_fn(|i| a[i] + h * b[i]) };
    let mut q = [0.0, 0.0, 0.0, 0.3, 0.2, -0.1, 0.4, -0.05];
    let mut qd = [0.5, -0.3, 3.0, 0.6, -0.4, 0.5, 0.8, 0.1];
    let (before, h) = (energy(&q, &qd), 1e-3);
    // Runge-Kutta method of fourth order.
    for _ in 0..500 {
        let (v1, a1) = (qd, acceleration(&q, &qd));
        let v2 = step(&qd, &a1, h / 2.0);
        let a2 = acceleration(&step(&q, &v1, h / 2.0), &v2);
        let v3 = step(&qd, &a2, h / 2.0);
        let a3 = acceleration(&step(&q, &v2, h / 2.0), &v3);
        let v4 = step(&qd, &a3, h);
        let a4 = acceleration(&step(&q, &v3, h), &v4);
        for i in 0..8 {
            q[i] += h / 6.0 * (v1[i] + 2.0 * v2[i] + 2.0 * v3[i] + v4[i]);
            qd[i] += h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i]);
        }
        let posture = Posture::new(&parameters, &q);
        let reaction = posture.newton_euler(&qd, &acceleration(&q, &qd)).reaction;
        // The robot is free: the ground neither pushes nor turns it.
        for value in reaction.force.into_iter().chain(reaction.moment) {
            near(value, 0.0, 1e-11, "reaction");
        }
    }
    let after = energy(&q, &qd);
    println!(
        "energy {before} J, after 0.5 s {:.2e} J more",
        after - before
    );
    near(after, before, 1e-8 * before.abs(), "energy");
}

fn dot_joints(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn points_along_the_heading_are_those_of_figure_8() {
    let mut random = Random(6);
    let parameters = Parameters::paper();
    for _ in 0..100 {
        let q = random.q();
        let ([p1, p2, p3], _) = Posture::new(&parameters, &q).along_heading();
        let r = LENGTHS.l2 + q[7] + LENGTHS.axle_3;
        near(p1, 0.0, 0.0, "P1");
        near(p2, 0.32 * q[5].cos(), 1e-15, "P2");
        near(p3, 0.32 * q[5].cos() + r * (q[5] + q[6]).cos(), 1e-15, "P3");
    }
}

#[test]
fn the_guards_shape_is_the_models() {
    let mut settings = Settings::default();
    let height = Setting::BodyHeight.description().key;
    settings.set(height, 34_997).unwrap();
    let model = Model::new(&settings);
    let parameters = Parameters::paper();
    for step in -20..=20 {
        let (theta, l3) = (f64::from(step) * 0.1, 0.226 + 0.004 * f64::from(step));
        let shape = model.shape(Angle::from_radians(theta as f32), l3 as f32);
        let q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, theta, l3 - LENGTHS.axle_3];
        let posture = Posture::new(&parameters, &q);
        let axles = posture.axles();
        for (got, [right, forward, up]) in [
            (shape.cog, posture.cog()),
            (shape.axle_2, axles[1]),
            (shape.axle_3, axles[2]),
        ] {
            for (got, want) in got.into_iter().zip([forward, -right, up]) {
                near(f64::from(got), want, 3e-7, "guard");
            }
        }
    }
}

#[test]
fn motors_do_the_work_that_the_generalized_forces_do() {
    let mut random = Random(7);
    let (radius, gauge, lead) = (0.05, 0.32, 0.005);
    let actuation = Actuation::<f64>::new(radius, gauge, lead).unwrap();
    for _ in 0..100 {
        let (q, qd) = (random.q(), rates(&mut random));
        let [left, right, chassis, screw] = [(); 4].map(|()| 20.0 * random.next());
        let torques = MotorTorques {
            left,
            right,
            chassis,
            screw,
        };
        let forces = actuation.generalized_forces(q[3], &torques);
        // Speed along the heading, which yaws counter-clockwise from y0.
        let speed = -q[3].sin() * qd[1] + q[3].cos() * qd[0];
        let power = left * (speed - 0.5 * gauge * qd[3]) / radius
            + right * (speed + 0.5 * gauge * qd[3]) / radius
            + chassis * qd[6]
            + screw * qd[7] / lead * std::f64::consts::TAU;
        near(
            dot_joints(&forces, &qd),
            power,
            1e-10 * power.abs().max(1.0),
            "power",
        );
    }
    assert_eq!(
        Actuation::<f32>::new(0.05, 0.0, 0.005).unwrap_err().name,
        "gauge"
    );
}

#[test]
fn a_taut_belt_closes_its_triangle() {
    let belt = TautBelt::<f64>::new(1.232, 0.32, 0.23).unwrap();
    for step in -300..=300 {
        let theta = f64::from(step) * 0.01;
        let extension = belt.extension(theta);
        let r = extension.reach;
        let diagonal = (0.32 + r * theta.cos()).hypot(r * theta.sin());
        near(diagonal + r, 1.232, 1e-15, "eq. 1");
        let (above, below) = (belt.extension(theta + 1e-5), belt.extension(theta - 1e-5));
        near(
            extension.derivative,
            (above.length - below.length) / 2e-5,
            1e-10,
            "first",
        );
        let second = (above.derivative - below.derivative) / 2e-5;
        near(extension.second_derivative, second, 1e-9, "second");
    }
    assert!(TautBelt::<f32>::new(0.32, 0.32, 0.23).is_err());
    assert!(TautBelt::<f32>::new(f64::NAN, 0.32, 0.23).is_err());
}

#[test]
fn impossible_robots_are_refused() {
    use ParametersError as E;
    let changed = |change: fn(&mut [tautrack::robots::b2p2::Tabulated; 3])| {
        let mut segments = SEGMENTS;
        change(&mut segments);
        Parameters::<f32>::new(&LENGTHS, &segments).unwrap_err()
    };
    assert!(Parameters::<f32>::new(&LENGTHS, &SEGMENTS).unwrap() == Parameters::paper());
    assert!(matches!(changed(|s| s[1].mass = -1.0), E::Mass { segment: 2, got } if got == -1.0));
    assert!(matches!(
        changed(|s| s[0].inertia_about_origin[0][1] = 0.0),
        E::InertiaNotSymmetric { segment: 1 }
    ));
    assert!(matches!(
        changed(|s| s[2].centre_of_mass[2] = 0.2),
        E::InertiaImpossible { segment: 3 }
    ));
    assert!(matches!(
        changed(|s| s[2].inertia_about_origin[0][0] = f64::NAN),
        E::InertiaImpossible { segment: 3 }
    ));
    let mut lengths = LENGTHS;
    lengths.l2 = f64::INFINITY;
    let error = Parameters::<f32>::new(&lengths, &SEGMENTS).unwrap_err();
    assert!(matches!(error, E::NotFinite { name: "l2", .. }));
}

/// The functions' documentation states these costs.
#[test]
fn functions_cost_what_they_are_said_to() {
    let parameters = Parameters::<Counted>::paper();
    let joints = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8].map(Counted::from_f64);
    let posture = Posture::new(&parameters, &joints);
    let vector = [1.0, 2.0, 3.0].map(Counted::from_f64);
    let square = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let contacts = square.map(|contact: [f64; 3]| contact.map(Counted::from_f64));
    let found = [
        (
            "Posture::new",
            operations(|| Posture::new(&parameters, &joints)),
        ),
        ("inertia_matrix", operations(|| posture.inertia_matrix())),
        (
            "coriolis_matrix",
            operations(|| posture.coriolis_matrix(&joints)),
        ),
        ("gravity_forces", operations(|| posture.gravity_forces())),
        (
            "lagrange",
            operations(|| posture.lagrange(&joints, &joints)),
        ),
        (
            "newton_euler",
            operations(|| posture.newton_euler(&joints, &joints)),
        ),
        (
            "angles of three edges",
            operations(|| angles(&contacts, vector, vector, vector)),
        ),
    ];
    for (name, count) in found {
        println!("{name}: {count}");
    }
    assert_eq!(
        found.map(|(_, count)| count),
        [25, 279, 1752, 81, 2368, 438, 3 * 51]
    );
}
