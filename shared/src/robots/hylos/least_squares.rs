//! Computes the pseudo-inverse of the paper's `nL_p`: four equations, one for each wheel, in three
//! unknowns.

use crate::math::Scalar;
use crate::math::vector::{Symmetric, Vector, add, dot, scale};

/// Determinant of `A^T A` over the cube of its mean diagonal element, below which the solution is
/// damped. It is above 0.01 for a robot that stands on its wheels, and 0 for contacts in one line
/// or a platform on end.
const CLEAR: f64 = 1e-3;
/// Largest damping, over the mean diagonal element.
const DAMPING: f64 = 1e-2;
/// Added to the diagonal, so that an empty matrix does not cause a division by zero.
const LEAST: f64 = 1e-12;

/// Least squares with a fixed matrix `A`, by its normal equations.
///
/// Away from singularities this is the pseudo-inverse itself. Where the matrix comes close to
/// losing rank, a damping grows from zero (Nakamura and Hanafusa, Inverse kinematic solutions with
/// singularity robustness), so that the solution stays bounded.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct LeastSquares<S> {
    rows: [Vector<S>; 4],
    inverse: Symmetric<S>,
}

impl<S: Scalar> LeastSquares<S> {
    /// Prepares the solution for the matrix with these rows.
    pub fn new(rows: [Vector<S>; 4]) -> Self {
        let mut diagonal = [S::from_f64(LEAST); 3];
        let mut mixed = [S::ZERO; 3];
        for [x, y, z] in rows {
            diagonal = add(diagonal, [x * x, y * y, z * z]);
            mixed = add(mixed, [y * z, z * x, x * y]);
        }
        let (_, determinant) = cofactors(diagonal, mixed);
        let mean = (diagonal[0] + diagonal[1] + diagonal[2]) * S::from_f64(1.0 / 3.0);
        let clear = S::from_f64(CLEAR) * mean * mean * mean;
        if determinant < clear {
            let lack = S::ONE - determinant / clear;
            let damping = S::from_f64(DAMPING) * mean * lack * lack;
            diagonal = diagonal.map(|element| element + damping);
        }
        let (adjugate, determinant) = cofactors(diagonal, mixed);
        let factor = S::ONE / determinant;
        Self {
            rows,
            inverse: Symmetric {
                diagonal: scale(factor, adjugate.diagonal),
                mixed: scale(factor, adjugate.mixed),
            },
        }
    }

    /// Solution for the right-hand side `right`: `A^+ right`.
    pub fn solve(&self, right: [S; 4]) -> Vector<S> {
        let [a, b, c, d] = self.rows;
        let sum = add(
            add(scale(right[0], a), scale(right[1], b)),
            add(scale(right[2], c), scale(right[3], d)),
        );
        self.inverse.times(sum)
    }

    /// Product with the transposed pseudo-inverse: `(A^+)^T left`.
    pub fn solve_transposed(&self, left: Vector<S>) -> [S; 4] {
        self.times(self.inverse.times(left))
    }

    /// Product `A solution`.
    pub fn times(&self, solution: Vector<S>) -> [S; 4] {
        self.rows.map(|row| dot(row, solution))
    }

    /// Part of `right` that no solution meets: `(1 - A A^+) right`.
    pub fn residual(&self, right: [S; 4]) -> [S; 4] {
        let met = self.times(self.solve(right));
        core::array::from_fn(|row| right[row] - met[row])
    }
}

/// Adjugate and determinant of a symmetric matrix.
fn cofactors<S: Scalar>(diagonal: Vector<S>, mixed: Vector<S>) -> (Symmetric<S>, S) {
    let ([xx, yy, zz], [yz, zx, xy]) = (diagonal, mixed);
    let first = [yy * zz - yz * yz, xx * zz - zx * zx, xx * yy - xy * xy];
    let others = [zx * xy - xx * yz, xy * yz - yy * zx, yz * zx - zz * xy];
    let determinant = xx * first[0] + xy * others[2] + zx * others[1];
    (
        Symmetric {
            diagonal: first,
            mixed: others,
        },
        determinant,
    )
}
