//! Defines masses, inertias and lengths of B2P2: the paper's tables, checked and converted to the
//! form that the dynamics need.

use crate::constants::GRAVITY_F64;
use crate::math::Scalar;
use crate::math::vector::{Symmetric, Vector, sub};

/// Segment as the paper's appendix tabulates it, in the axes of its Denavit-Hartenberg frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tabulated {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the frame, m.
    pub centre_of_mass: [f64; 3],
    /// Inertia matrix about the ORIGIN of the frame, kg m^2.
    ///
    /// The paper's eq. 4 needs it about the centre of mass, and the paper says no more than
    /// "defined in the frame". But about the centre of mass the matrices would be impossible:
    /// body 3 would have a gyration radius of 0.167 m at a length of 0.226 m. And their mixed
    /// elements agree with `-m x y` of the tabulated centres within a few per cent. So they are
    /// about the origins.
    pub inertia_about_origin: [[f64; 3]; 3],
}

/// Segments 1 to 3, in the frames R6, R7 and R8 (Paillat et al., appendix, mechanical constants).
pub const SEGMENTS: [Tabulated; 3] = [
    Tabulated {
        mass: 6.356_067,
        centre_of_mass: [0.160_894, 0.034_997, -0.002_784],
        inertia_about_origin: [
            [0.128_728, -0.033_872, 0.002_259],
            [-0.033_872, 0.363_749, 0.001_158],
            [0.002_259, 0.001_158, 0.283_586],
        ],
    },
    Tabulated {
        mass: 0.897_066,
        centre_of_mass: [-0.000_723, -0.104_083, 0.014_127],
        inertia_about_origin: [
            [0.016_485, -0.000_107, 0.000_002],
            [-0.000_107, 0.003_941, 0.001_773],
            [0.000_002, 0.001_773, 0.012_863],
        ],
    },
    Tabulated {
        mass: 1.062_15,
        centre_of_mass: [0.000_09, -0.000_01, 0.152_68],
        inertia_about_origin: [
            [0.052_29, 0.0, -0.000_02],
            [0.0, 0.029_64, 0.0],
            [-0.000_02, 0.0, 0.025_23],
        ],
    },
];

/// Lengths, m, and gravity, m/s^2.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Lengths {
    /// Distance `L1` of axles 1 and 2.
    pub l1: f64,
    /// Fixed part `L2` of the front.
    pub l2: f64,
    /// Distance of axle 3 from the origin of R8, along z8. Assumed.
    ///
    /// The paper's eq. 2 has `r = L2 + L3`, its table `r8 = L2 + q8`. With `q8 = L3` the centre of
    /// mass of body 3 would lie 0.153 m in front of axle 3. So R8 is taken to be at the rear end of
    /// body 3, and the axle at the tabulated length of the body: `q8 = L3 - axle_3`.
    pub axle_3: f64,
    /// Gravity, along -z0.
    pub gravity: f64,
}

/// The paper's lengths; axle 3 as assumed.
pub const LENGTHS: Lengths = Lengths {
    l1: 0.32,
    l2: 0.23,
    axle_3: 0.226,
    gravity: GRAVITY_F64,
};

/// Why values do not describe a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ParametersError {
    /// A length or gravity is not finite.
    NotFinite {
        /// Name of the value.
        name: &'static str,
        /// Value that was given.
        got: f64,
    },
    /// A mass is not above zero, or not finite.
    Mass {
        /// Segment, 1 to 3.
        segment: usize,
        /// Value that was given, kg.
        got: f64,
    },
    /// An inertia matrix is not symmetric.
    InertiaNotSymmetric {
        /// Segment, 1 to 3.
        segment: usize,
    },
    /// No body has this mass, centre of mass and inertia: about the centre of mass, one moment
    /// exceeds the sum of the other two.
    InertiaImpossible {
        /// Segment, 1 to 3.
        segment: usize,
    },
}

/// Segment in the form that the dynamics need.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Segment<S> {
    pub mass: S,
    pub com: Vector<S>,
    /// Inertia about the centre of mass.
    pub inertia: Symmetric<S>,
    pub inertia_about_origin: Symmetric<S>,
}

/// Constants of the model, checked once at creation, so that no other code has to check them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters<S> {
    pub(super) l1: S,
    pub(super) l2: S,
    pub(super) axle_3: S,
    pub(super) gravity: S,
    pub(super) mass: S,
    /// Segment 1 along R6, segment 2 along R7. Segment 3 has the origin of R8 but lies along R7 as
    /// well, so that the front needs one rotation.
    pub(super) segments: [Segment<S>; 3],
}

impl<S: Scalar> Parameters<S> {
    /// The paper's robot: [`SEGMENTS`] and [`LENGTHS`].
    pub fn paper() -> Self {
        Self::prepare(&LENGTHS, &SEGMENTS)
    }

    /// Creates a robot of this kind with other values. Cost: about 300 operations in double
    /// precision; for start-up.
    ///
    /// # Errors
    /// The first value that no robot can have.
    pub fn new(lengths: &Lengths, segments: &[Tabulated; 3]) -> Result<Self, ParametersError> {
        for (name, got) in [
            ("l1", lengths.l1),
            ("l2", lengths.l2),
            ("axle_3", lengths.axle_3),
            ("gravity", lengths.gravity),
        ] {
            if !got.is_finite() {
                return Err(ParametersError::NotFinite { name, got });
            }
        }
        for (index, tabulated) in segments.iter().enumerate() {
            let segment = index + 1;
            if !(tabulated.mass > 0.0 && tabulated.mass.is_finite()) {
                let got = tabulated.mass;
                return Err(ParametersError::Mass { segment, got });
            }
            let [[_, xy, xz], [yx, _, yz], [zx, zy, _]] = tabulated.inertia_about_origin;
            if !(xy == yx && xz == zx && yz == zy) {
                return Err(ParametersError::InertiaNotSymmetric { segment });
            }
            if !is_positive_definite(&about_com(tabulated).complement()) {
                return Err(ParametersError::InertiaImpossible { segment });
            }
        }
        Ok(Self::prepare(lengths, segments))
    }

    /// Mass of the whole robot, kg.
    pub fn mass(&self) -> S {
        self.mass
    }

    /// Gravity, m/s^2.
    pub fn gravity(&self) -> S {
        self.gravity
    }

    fn prepare(lengths: &Lengths, segments: &[Tabulated; 3]) -> Self {
        let [first, second, third] = segments;
        Self {
            l1: S::from_f64(lengths.l1),
            l2: S::from_f64(lengths.l2),
            axle_3: S::from_f64(lengths.axle_3),
            gravity: S::from_f64(lengths.gravity),
            mass: S::from_f64(first.mass + second.mass + third.mass),
            segments: [first, second, &along_r7(third)].map(|tabulated| Segment {
                mass: S::from_f64(tabulated.mass),
                com: tabulated.centre_of_mass.map(S::from_f64),
                inertia: convert(&about_com(tabulated)),
                inertia_about_origin: convert(&about_origin(tabulated)),
            }),
        }
    }
}

fn about_origin(segment: &Tabulated) -> Symmetric<f64> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = segment.inertia_about_origin;
    Symmetric {
        diagonal: [xx, yy, zz],
        mixed: [yz, xz, xy],
    }
}

/// Inertia about the centre of mass, by parallel axes: `I_c = I_o - m (c.c 1 - c c^T)`.
fn about_com(segment: &Tabulated) -> Symmetric<f64> {
    let shift = Symmetric::point_mass(segment.mass, segment.centre_of_mass);
    let origin = about_origin(segment);
    Symmetric {
        diagonal: sub(origin.diagonal, shift.diagonal),
        mixed: sub(origin.mixed, shift.mixed),
    }
}

/// Transforms a segment from the axes of R8 to those of R7: `x7 = x8`, `y7 = -z8`, `z7 = y8` (row 8
/// of the table, without the translation).
fn along_r7(segment: &Tabulated) -> Tabulated {
    let [x, y, z] = segment.centre_of_mass;
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = segment.inertia_about_origin;
    Tabulated {
        mass: segment.mass,
        centre_of_mass: [x, -z, y],
        inertia_about_origin: [[xx, -xz, xy], [-xz, zz, -yz], [xy, -yz, yy]],
    }
}

/// Whether the matrix is positive definite, by its leading minors; false if any element is NaN.
fn is_positive_definite(matrix: &Symmetric<f64>) -> bool {
    let ([xx, yy, zz], [yz, zx, xy]) = (matrix.diagonal, matrix.mixed);
    let second = xx * yy - xy * xy;
    let third = zz * second + xy * yz * zx * 2.0 - xx * yz * yz - yy * zx * zx;
    xx > 0.0 && second > 0.0 && third > 0.0
}

fn convert<S: Scalar>(matrix: &Symmetric<f64>) -> Symmetric<S> {
    Symmetric {
        diagonal: matrix.diagonal.map(S::from_f64),
        mixed: matrix.mixed.map(S::from_f64),
    }
}
