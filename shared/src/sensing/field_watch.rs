//! Finds a magnetometer whose readings repeat although the robot turns.
//!
//! Equal readings alone are no fault: a magnetometer that is coarser than its noise repeats them
//! while the robot stands. So the monitor compares them with the gyroscope.

/// Rotation from which a reading must differ, rad: 10 degrees. Even where the horizontal field is
/// 8 uT, the rotation changes it by 1.4 uT, which is ten digits.
const ROTATION: f32 = 0.175;
/// Largest angular rate that may be the constant error of a gyroscope, rad/s.
const RATE_ERROR: f32 = super::rest::RATE_BOUND;

/// Monitor of repeated readings of a magnetometer.
#[derive(Clone, Debug, Default)]
pub struct FieldWatch {
    bits: [u32; 3],
    /// Rotation about each axis since the readings changed last, rad.
    turned: [f32; 3],
}

impl FieldWatch {
    /// Takes an angular rate that lasts for `period` s. A rate below 6 degrees/s does not count.
    #[inline]
    pub fn turn(&mut self, rate: &[f32; 3], period: f32) {
        for (turned, rate) in self.turned.iter_mut().zip(rate) {
            if rate.abs() > RATE_ERROR {
                *turned += rate * period;
            }
        }
    }

    /// Takes a reading of the magnetometer. Returns whether it repeats, bit by bit, although the
    /// robot has turned by more than 10 degrees.
    pub fn repeats(&mut self, field: &[f32]) -> bool {
        let mut changed = false;
        for (bits, value) in self.bits.iter_mut().zip(field) {
            changed |= *bits != value.to_bits();
            *bits = value.to_bits();
        }
        if changed {
            self.turned = [0.0; 3];
        }
        let [x, y, z] = self.turned;
        x * x + y * y + z * z > ROTATION * ROTATION
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns by `degrees` within a second, about one axis after the other, with a magnetometer that
    /// measures ten times. Returns how many of its readings are faulty.
    fn faulty(degrees: f32, field: impl Fn(u32) -> [f32; 3]) -> [u32; 3] {
        core::array::from_fn(|axis| {
            let mut watch = FieldWatch::default();
            watch.repeats(&field(0));
            let mut rate = [0.0; 3];
            rate[axis] = degrees.to_radians();
            let mut faulty = 0;
            for step in 1..=1_000 {
                watch.turn(&rate, 1e-3);
                if step % 100 == 0 {
                    faulty += u32::from(watch.repeats(&field(step / 100)));
                }
            }
            faulty
        })
    }

    #[test]
    fn repeated_readings_are_a_fault_after_a_rotation_of_ten_degrees() {
        // 5 degrees between two readings: the third one is beyond 10 degrees.
        assert_eq!(faulty(50.0, |_| [20.0, 5.0, -40.0]), [8; 3]);
        assert_eq!(faulty(-50.0, |_| [20.0, 5.0, -40.0]), [8; 3]);
        assert_eq!(faulty(9.5, |_| [20.0, 5.0, -40.0]), [0; 3]);
    }

    #[test]
    fn one_axis_that_changes_is_enough() {
        let field = |reading: u32| [20.0, 5.0, -40.0 + 0.15 * reading as f32];
        assert_eq!(faulty(400.0, field), [0; 3]);
    }

    #[test]
    fn at_rest_and_with_the_constant_error_of_a_gyroscope_equal_readings_are_no_fault() {
        let mut watch = FieldWatch::default();
        for _ in 0..600_000 {
            watch.turn(&[0.1, -0.1, 0.1], 1e-3);
            assert!(!watch.repeats(&[20.0, 5.0, -40.0]));
        }
    }
}
