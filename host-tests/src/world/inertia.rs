//! Mass, centre of mass and inertia of a rigid body, and their conversion for the physics engine.
//!
//! The engine wants an inertia as principal moments and axes. Its own conversion calls the
//! platform's `acos` and `cos`, whose last bits differ between platforms. The conversion here takes
//! only sums, products, quotients and square roots, which IEEE 754 rounds the same everywhere.

use super::load::Load;
use rapier3d_f64::dynamics::MassProperties;
use rapier3d_f64::math::{Matrix, Rotation, Vector};

/// Number of sweeps of Jacobi's method. It converges quadratically: five sweeps reach rounding.
const SWEEPS: usize = 8;

/// Mass, centre of mass and inertia of a rigid body, in the body's axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Inertia {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: Vector,
    /// Inertia about the centre of mass, kg m^2; symmetric.
    pub about_centre: Matrix,
}

impl Inertia {
    /// Returns the inertia of this body with `load` on it.
    #[must_use]
    pub fn with_load(&self, load: &Load) -> Self {
        let place = Vector::from_array(load.place);
        let mass = self.mass + load.mass;
        let centre = (self.centre * self.mass + place * load.mass) / mass;
        Self {
            mass,
            centre,
            about_centre: self.about_centre
                + of_point(self.mass, self.centre - centre)
                + Matrix::from_diagonal(Vector::splat(load.own_inertia()))
                + of_point(load.mass, place - centre),
        }
    }

    /// Converts to the physics engine's form; bit-identical on every machine.
    pub fn properties(&self) -> MassProperties {
        let (moments, axes) = principal(self.about_centre);
        MassProperties::with_principal_inertia_frame(self.centre, self.mass, moments, axes)
    }
}

/// Inertia of a point mass (kg) at `place` (m) about the origin, kg m^2.
pub fn of_point(mass: f64, place: Vector) -> Matrix {
    let outer = Matrix::from_cols(place * place.x, place * place.y, place * place.z);
    (Matrix::from_diagonal(Vector::splat(place.dot(place))) - outer) * mass
}

/// Principal moments of a symmetric matrix, in no particular order, and the rotation from the
/// principal axes to the matrix's axes.
///
/// Jacobi's method (Golub and Van Loan, *Matrix Computations*, 8.5): each step turns one pair of
/// axes so that their product of inertia vanishes.
fn principal(inertia: Matrix) -> (Vector, Rotation) {
    let mut matrix = inertia;
    let mut axes = Matrix::IDENTITY;
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(SWEEPS) {
        let product = matrix.col(q)[p];
        if product == 0.0 {
            continue;
        }
        let cotangent = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * product);
        let tangent =
            cotangent.signum() / (cotangent.abs() + libm::sqrt(1.0 + cotangent * cotangent));
        let cosine = 1.0 / libm::sqrt(1.0 + tangent * tangent);
        let sine = tangent * cosine;
        let mut turn = Matrix::IDENTITY;
        (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (cosine, cosine);
        (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (sine, -sine);
        matrix = turn.transpose() * matrix * turn;
        axes *= turn;
    }
    let moments = Vector::new(matrix.col(0)[0], matrix.col(1)[1], matrix.col(2)[2]);
    (moments, Rotation::from_mat3(&axes).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest absolute element.
    fn largest(matrix: Matrix) -> f64 {
        let elements = matrix.to_cols_array().map(f64::abs);
        elements.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn principal_axes_give_back_the_inertia() {
        let general = [[4.0, 0.7, -0.3], [0.7, 3.0, 1.1], [-0.3, 1.1, 2.5]];
        let equal_moments = [[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]];
        let diagonal = [[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
        let tiny_product = [[1.0, 1e-300, 0.0], [1e-300, 2.0, 0.0], [0.0, 0.0, 3.0]];
        for rows in [general, equal_moments, diagonal, tiny_product] {
            let inertia = Matrix::from_cols_array_2d(&rows);
            let properties = Inertia {
                mass: 2.0,
                centre: Vector::ZERO,
                about_centre: inertia,
            }
            .properties();
            let error = properties.reconstruct_inertia_matrix() - inertia;
            assert!(largest(error) < 4e-15, "{rows:?}: {error}");
        }
    }

    #[test]
    fn a_load_adds_what_the_engine_adds() {
        let load = Load {
            mass: 1.5,
            place: [0.1, -0.05, 0.25],
            from_time_s: 0.0,
        };
        let bare = Inertia {
            mass: 6.0,
            centre: Vector::new(0.2, 0.01, -0.03),
            about_centre: Matrix::from_diagonal(Vector::new(0.05, 0.2, 0.22)),
        };
        let expected = bare.properties()
            + MassProperties::new(
                Vector::from_array(load.place),
                load.mass,
                Vector::splat(load.own_inertia()),
            );
        let loaded = bare.with_load(&load).properties();
        let error = loaded.reconstruct_inertia_matrix() - expected.reconstruct_inertia_matrix();
        assert!(largest(error) < 1e-14, "{error}");
        assert!((loaded.local_com - expected.local_com).length() < 1e-15);
        assert!((loaded.mass() - 7.5).abs() < 1e-14);
    }
}
