//! Fits an ellipse to the horizontal readings of a magnetometer that turns once: its centre is the
//! hard iron, its shape the soft iron.

use crate::math::{max, sqrt};

/// Unit in which the fit computes, uT: near the radius of the ellipse, so that no sum loses digits.
const UNIT: f32 = 30.0;
/// Smallest pivot, as a fraction of the largest coefficient.
const SINGULAR: f32 = 1e-6;
/// Number of coefficients of a conic.
const COUNT: usize = 5;

/// Least squares fit of a conic `x^2 + y^2 = p (x^2 - y^2) + q 2 x y + r x + s y + t`. Unlike a
/// conic whose constant is 1, it may pass through the origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct EllipseFit {
    normal: [[f32; COUNT]; COUNT],
    right: [f32; COUNT],
    count: u32,
    /// Origin of the sums, which keeps them well conditioned, uT.
    origin: [f32; 2],
}

/// Ellipse of the readings.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ellipse {
    /// Centre, uT.
    pub centre: [f32; 2],
    /// Geometric mean of its half axes, uT.
    pub radius: f32,
    /// Symmetric matrix that makes a circle of it, with determinant 1: xx, yy, xy.
    pub correction: [f32; 3],
}

impl EllipseFit {
    /// Fit that computes relative to this point, uT, which should be near the ellipse.
    pub fn around(origin: [f32; 2]) -> Self {
        Self {
            origin,
            ..Self::default()
        }
    }

    /// Number of readings so far.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Adds a reading, uT.
    pub fn add(&mut self, [x, y]: [f32; 2]) {
        let (x, y) = ((x - self.origin[0]) / UNIT, (y - self.origin[1]) / UNIT);
        let row = [x * x - y * y, 2.0 * x * y, x, y, 1.0];
        let square = x * x + y * y;
        for (first, left) in row.into_iter().enumerate() {
            for (second, right) in row.into_iter().enumerate() {
                self.normal[first][second] += left * right;
            }
            self.right[first] += left * square;
        }
        self.count += 1;
    }

    /// Returns the ellipse; `None` if the readings determine none.
    pub fn solve(&self) -> Option<Ellipse> {
        let [p, q, r, s, t] = solved(self.normal, self.right)?;
        // The same conic as `a x^2 + b x y + c y^2 + d x + e y = t`.
        let [a, b, c, d, e] = [1.0 - p, -2.0 * q, 1.0 + p, -r, -s];
        let determinant = 4.0 * a * c - b * b;
        if !(determinant > 1e-6 * (a + c) * (a + c)) {
            return None;
        }
        let centre = [
            (b * e - 2.0 * c * d) / determinant,
            (b * d - 2.0 * a * e) / determinant,
        ];
        let [x, y] = centre;
        let level = t + a * x * x + b * x * y + c * y * y;
        let [xx, yy, xy] = [a / level, c / level, 0.5 * b / level];
        let square = xx * yy - xy * xy;
        if !(square > 0.0 && xx > 0.0) {
            return None;
        }
        // The square root of a symmetric matrix M of order two is (M + r) / s, with r the root of
        // its determinant and s the root of its trace plus 2 r. The root of r makes its determinant
        // 1.
        let root = sqrt(square);
        let scale = 1.0 / (sqrt(xx + yy + 2.0 * root) * sqrt(root));
        Some(Ellipse {
            centre: [self.origin[0] + x * UNIT, self.origin[1] + y * UNIT],
            radius: UNIT / sqrt(root),
            correction: [(xx + root) * scale, (yy + root) * scale, xy * scale],
        })
    }
}

/// Solves the linear equations by elimination with pivots; `None` if they are singular.
fn solved(mut rows: [[f32; COUNT]; COUNT], mut right: [f32; COUNT]) -> Option<[f32; COUNT]> {
    let largest = rows
        .iter()
        .flatten()
        .fold(0.0, |most, value| max(most, value.abs()));
    for column in 0..COUNT {
        let mut pivot = column;
        for row in column..COUNT {
            if rows[row][column].abs() > rows[pivot][column].abs() {
                pivot = row;
            }
        }
        rows.swap(column, pivot);
        right.swap(column, pivot);
        let lead = rows[column];
        if !(lead[column].abs() > SINGULAR * largest) {
            return None;
        }
        for row in column + 1..COUNT {
            let factor = rows[row][column] / lead[column];
            for place in column..COUNT {
                rows[row][place] -= factor * lead[place];
            }
            right[row] -= factor * right[column];
        }
    }
    for column in (0..COUNT).rev() {
        right[column] /= rows[column][column];
        for row in 0..column {
            right[row] -= rows[row][column] * right[column];
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ellipse with half axes of 24 uT and 18 uT, turned by 0.5 rad.
    #[test]
    fn centre_and_shape_of_an_ellipse_are_found_and_its_correction_makes_a_circle() {
        let point = |angle: f64| {
            let (x, y) = (24.0 * libm::cos(angle), 18.0 * libm::sin(angle));
            let (sine, cosine) = (libm::sin(0.5), libm::cos(0.5));
            [
                (31.0 + x * cosine - y * sine) as f32,
                (-14.0 + x * sine + y * cosine) as f32,
            ]
        };
        let mut fit = EllipseFit::around([40.0, -10.0]);
        assert_eq!(fit.solve(), None);
        for step in 0..100 {
            fit.add(point(f64::from(step) * 0.0628));
        }
        let ellipse = fit.solve().expect("an ellipse");
        let [x, y] = ellipse.centre;
        assert!(
            (x - 31.0).abs() < 0.05 && (y + 14.0).abs() < 0.05,
            "{ellipse:?}"
        );
        let radius = libm::sqrt(24.0 * 18.0) as f32;
        let [xx, yy, xy] = ellipse.correction;
        for step in 0..60 {
            let [u, v] = point(f64::from(step) * 0.1);
            let (u, v) = (u - x, v - y);
            let distance = sqrt((xx * u + xy * v).powi(2) + (xy * u + yy * v).powi(2));
            assert!((distance - radius).abs() < 0.05, "{distance}");
        }
    }

    #[test]
    fn a_line_is_no_ellipse() {
        let mut fit = EllipseFit::around([0.0; 2]);
        for step in 0..50 {
            fit.add([step as f32, 2.0 * step as f32]);
        }
        assert_eq!(fit.solve(), None);
    }
}
