//! Points, directions, frames and symmetric matrices in three dimensions, for any [`Scalar`].

use super::scalar::Scalar;

/// Three coordinates.
pub type Vector<S> = [S; 3];

/// Returns the zero vector.
#[inline]
pub fn zero<S: Scalar>() -> Vector<S> {
    [S::ZERO; 3]
}

/// Returns `a + b`.
#[inline]
pub fn add<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns `a - b`.
#[inline]
pub fn sub<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns `factor` times `a`.
#[inline]
pub fn scale<S: Scalar>(factor: S, a: Vector<S>) -> Vector<S> {
    [factor * a[0], factor * a[1], factor * a[2]]
}

/// Returns the scalar product.
#[inline]
pub fn dot<S: Scalar>(a: Vector<S>, b: Vector<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the vector product `a x b`.
#[inline]
pub fn cross<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Returns `z x a`: the rate at which `a` changes when it turns about z with unit rate.
#[inline]
pub fn about_z<S: Scalar>(a: Vector<S>) -> Vector<S> {
    [-a[1], a[0], S::ZERO]
}

/// Returns `a x (length x)`: the velocity of a point on the x axis, at distance `length`, that
/// turns with the rate `a`.
#[inline]
pub fn to_point_on_x<S: Scalar>(a: Vector<S>, length: S) -> Vector<S> {
    [S::ZERO, a[2] * length, -(a[1] * length)]
}

/// A coordinate frame: its axes and its origin in the coordinates of an outer frame. A C program
/// finds them in memory in this order.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CoordinateFrame<S> {
    /// x, y and z axis: the columns of the rotation matrix.
    pub axes: [Vector<S>; 3],
    /// Origin of the frame.
    pub origin: Vector<S>,
}

impl<S: Scalar> CoordinateFrame<S> {
    /// Converts a direction from the frame's axes to the outer frame.
    #[inline]
    pub fn direction(&self, local: Vector<S>) -> Vector<S> {
        let [x, y, z] = self.axes;
        add(
            add(scale(local[0], x), scale(local[1], y)),
            scale(local[2], z),
        )
    }

    /// Converts a point from the frame to the outer frame.
    #[inline]
    pub fn place(&self, local: Vector<S>) -> Vector<S> {
        add(self.origin, self.direction(local))
    }

    /// Converts a direction from the outer frame to the frame's axes: the inverse of
    /// [`Self::direction`].
    #[inline]
    pub fn along_axes(&self, direction: Vector<S>) -> Vector<S> {
        self.axes.map(|axis| dot(axis, direction))
    }

    /// Returns the transform `[R | p]`, row by row.
    pub fn rows(&self) -> [[S; 4]; 3] {
        let [x, y, z] = self.axes;
        [0, 1, 2].map(|row| [x[row], y[row], z[row], self.origin[row]])
    }
}

/// A symmetric matrix, for example an inertia.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Symmetric<S> {
    /// Elements xx, yy, zz.
    pub diagonal: Vector<S>,
    /// Elements yz, zx, xy. Each stands at the index of the axis that it does not contain.
    pub mixed: Vector<S>,
}

impl<S: Scalar> Symmetric<S> {
    /// Returns the inertia about the origin of a point mass `mass` at `place`: `m (r.r 1 - r r^T)`.
    #[inline]
    pub fn point_mass(mass: S, place: Vector<S>) -> Self {
        let [x, y, z] = place;
        let [mx, my, mz] = scale(mass, place);
        let (xx, yy, zz) = (mx * x, my * y, mz * z);
        Self {
            diagonal: [yy + zz, xx + zz, xx + yy],
            mixed: [-(my * z), -(mz * x), -(mx * y)],
        }
    }

    /// Returns the sum.
    #[inline]
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            diagonal: add(self.diagonal, other.diagonal),
            mixed: add(self.mixed, other.mixed),
        }
    }

    /// Returns the product with a vector.
    #[inline]
    pub fn times(&self, v: Vector<S>) -> Vector<S> {
        let ([xx, yy, zz], [yz, zx, xy]) = (self.diagonal, self.mixed);
        [
            xx * v[0] + xy * v[1] + zx * v[2],
            xy * v[0] + yy * v[1] + yz * v[2],
            zx * v[0] + yz * v[1] + zz * v[2],
        ]
    }

    /// Returns the matrix for axes that are turned back about z by an angle: `R A R^T`. The angle
    /// is given by its sine and cosine.
    #[inline]
    #[must_use]
    pub fn turned_about_z(&self, sine: S, cosine: S) -> Self {
        let ([xx, yy, zz], [yz, zx, xy]) = (self.diagonal, self.mixed);
        let (ss, cc, sc) = (sine * sine, cosine * cosine, sine * cosine);
        let twist = (sc + sc) * xy;
        Self {
            diagonal: [cc * xx + ss * yy - twist, ss * xx + cc * yy + twist, zz],
            mixed: [
                cosine * yz + sine * zx,
                cosine * zx - sine * yz,
                sc * (xx - yy) + (cc - ss) * xy,
            ],
        }
    }

    /// Returns half the trace times the unit matrix, minus the matrix itself. For an inertia this
    /// is the second moment of mass, `integral r r^T dm`.
    #[inline]
    #[must_use]
    pub fn complement(&self) -> Self {
        let [xx, yy, zz] = self.diagonal;
        let half = S::from_f64(0.5) * (xx + yy + zz);
        Self {
            diagonal: [half - xx, half - yy, half - zz],
            mixed: self.mixed.map(|element| -element),
        }
    }
}
