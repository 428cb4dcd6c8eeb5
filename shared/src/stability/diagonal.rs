//! Computes what a fall over a diagonal of the support leaves of the rear margin.
//!
//! A robot that stands on the nose of a step with some roll can have one rear pulley in the air. It
//! then stands on the other rear pulley and on the nose, and it falls over the diagonal between
//! this pulley and the far end of the nose's contact. During the fall it pitches up, until the rear
//! pulley in the air meets the ground.
//!
//! The guard does not know where the nose is. So it assumes the worst place: the diagonal is right
//! below the centre of gravity. The closer the centre of gravity is to the rear, the further the
//! robot pitches up.

use super::support::{Edge, Stance};
use crate::math::{clamp, max, min, root_of_sum};

/// Smallest distance of the centre of gravity to the rear edge, m. It keeps divisions away from
/// zero.
const SHORTEST: f32 = 1e-3;

/// Distance by which the margin of the rear edge is narrower after a fall over a diagonal, m. Zero
/// if both ends of the rear edge are at the same height; NaN for NaN.
///
/// In the side view through the centre of gravity, the rear edge sinks to the height of its lower
/// end, and the robot turns about the point of the support below its centre of gravity. The centre
/// of gravity is `n` above this point. The rear edge is `b` from it along the support, which rises
/// by the angle `s`; a support whose front is lower counts as level. If the rear edge sinks by `f`,
/// the robot turns by `d` with `sin(s + d) = sin s + f / b`, and the margin falls from `b cos s` to
/// `b cos(s + d) - n sin d`.
///
/// The test compares with the rotation about the diagonal in space. There the error is below 3 mm
/// up to a roll of 5 degrees, and below 9 mm up to 10 degrees.
pub fn loss(stance: &Stance) -> f32 {
    let [begin, end] = stance.ends(Edge::Back);
    let across = (stance.cog[1] - begin[1]) / (end[1] - begin[1]);
    let rear = begin[2] + clamp(across, 0.0, 1.0) * (end[2] - begin[2]);
    let falls = rear - min(begin[2], end[2]);
    let [rear_x, _] = stance.rear();
    let ahead = max(stance.cog[0] - rear_x, SHORTEST);
    let [cosine, sine] = stance.rising();
    let above = max(stance.cog[2] - rear - ahead * sine / cosine, 0.0);
    let base = ahead / cosine;
    let steep = min(sine + falls / base, 1.0);
    let flat = root_of_sum(max(1.0 - steep * steep, 0.0));
    base * (cosine - flat) + above * (steep * cosine - flat * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF_GAUGE: f64 = 0.16;

    /// Rotates `point` about the line from the origin along `axis` by `angle`, rad.
    fn rotated(point: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
        let length = libm::sqrt(axis.iter().map(|value| value * value).sum());
        let axis = axis.map(|value| value / length);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let along: f64 = (0..3).map(|index| axis[index] * point[index]).sum();
        core::array::from_fn(|index| {
            let (next, last) = ((index + 1) % 3, (index + 2) % 3);
            let across = axis[next] * point[last] - axis[last] * point[next];
            point[index] * cosine + across * sine + axis[index] * along * (1.0 - cosine)
        })
    }

    /// Robot on a support that rises by the angle `slope` and sinks to its left by `roll`, rad. The
    /// origin is the lower rear pulley, on its left. The centre of gravity is `ahead` of the rear
    /// edge and `up` above it, m.
    struct Robot {
        rear_right: [f64; 3],
        cog: [f64; 3],
        slope: f64,
    }

    impl Robot {
        fn new(slope: f64, roll: f64, ahead: f64, up: f64) -> Self {
            let rear_right = [
                0.0,
                -2.0 * HALF_GAUGE * libm::cos(roll),
                2.0 * HALF_GAUGE * libm::sin(roll),
            ];
            let left = -HALF_GAUGE * libm::cos(roll) + up * libm::sin(roll);
            let rear = rear_right[2] * left / rear_right[1];
            Self {
                rear_right,
                cog: [ahead, left, rear + up],
                slope,
            }
        }

        fn stance(&self) -> Stance {
            let single = |place: [f64; 3]| place.map(|value| value as f32);
            let [x, up] = [0.6 * libm::cos(self.slope), 0.6 * libm::sin(self.slope)];
            let front = |[_, y, z]: [f64; 3]| single([x, y, z + up]);
            let contacts = [
                single(self.rear_right),
                front(self.rear_right),
                front([0.0; 3]),
                [0.0; 3],
            ];
            Stance::on(contacts, single(self.cog))
        }

        /// Margin to the line through both rear pulleys after the right one has fallen to the
        /// height of the left one, by the rotation in space. The nose is on the right side of the
        /// support, where the diagonal is below the centre of gravity.
        fn after_the_fall(&self) -> f64 {
            let x = self.cog[0] * self.rear_right[1] / self.cog[1];
            let [_, y, z] = self.rear_right;
            let nose = [x, y, z + x * libm::tan(self.slope)];
            let fallen = |angle: f64| rotated(self.rear_right, nose, angle);
            let sense = if fallen(1e-3)[2] < z { 1.0 } else { -1.0 };
            let angle = (0..10_000)
                .map(|step| sense * f64::from(step) * 1e-4)
                .find(|angle| fallen(*angle)[2] <= 0.0)
                .expect("the pulley meets the ground");
            let [x, y, _] = fallen(angle);
            let cog = rotated(self.cog, nose, angle);
            (cog[1] * x - cog[0] * y) / libm::hypot(x, y)
        }
    }

    #[test]
    fn the_loss_is_that_of_the_rotation_about_the_diagonal() {
        let mut most = 0.0_f64;
        for slope in [0.35, 0.6, 0.85] {
            for (degrees, error) in [(1.0_f64, 1e-3), (3.0, 1e-3), (5.0, 3e-3), (10.0, 9e-3)] {
                for ahead in [0.06, 0.08, 0.1, 0.14] {
                    for up in [0.2, 0.3] {
                        let robot = Robot::new(slope, degrees.to_radians(), ahead, up);
                        let left = robot.after_the_fall();
                        if left < -0.01 {
                            continue;
                        }
                        let found = ahead - f64::from(loss(&robot.stance()));
                        let case = (slope, degrees, ahead, up);
                        assert!((found - left).abs() < error, "{case:?}: {found} {left}");
                        most = most.max(ahead - left);
                    }
                }
            }
        }
        assert!(most > 0.07, "{most}");
    }

    #[test]
    fn both_rear_pulleys_at_one_height_lose_nothing_and_nan_is_nan() {
        for ahead in [-0.05, 0.0, 0.05, 0.3] {
            let level = Robot::new(0.6, 0.0, ahead, 0.3).stance();
            assert!(loss(&level).abs() < 1e-6);
            for index in 0..3 {
                let mut bad = level;
                bad.cog[index] = f32::NAN;
                assert!(loss(&bad).is_nan());
            }
        }
    }

    /// The margin of a robot with its centre of gravity at the rear edge, or behind it, stays
    /// finite and is never widened.
    #[test]
    fn the_loss_is_finite_and_never_negative() {
        for millimetres in -100..300 {
            for degrees in [0.1_f64, 5.0, 30.0, 80.0] {
                let ahead = f64::from(millimetres) * 1e-3;
                let stance = Robot::new(0.6, degrees.to_radians(), ahead, 0.3).stance();
                let found = loss(&stance);
                assert!((-1e-6..1.0).contains(&found), "{ahead} {degrees}: {found}");
            }
        }
    }
}
