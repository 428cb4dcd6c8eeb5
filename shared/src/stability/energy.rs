//! Computes margins that contain momentum: how much energy a robot has left before it tips over an
//! edge of its support.
//!
//! A robot at rest tips over an edge if its centre of gravity is lifted above the edge, by `l - h`
//! (the energy stability margin of Messuri and Klein, per weight). `l` is the distance of the
//! centre of gravity to the edge and `h` its height over the edge. A robot that already turns about
//! the edge with the rate `w` has less left: `e = l - h - (l^2 + k^2) w^2 / 2 g`, with the radius
//! of gyration `k`. [`Tipping::margin`] expresses `e` as a margin: that of a robot at rest with as
//! much energy left, `sqrt(e (e + 2 h))`. So one set of levels, in metres, applies to robots at
//! rest and in motion.
//!
//! An instant stop from the speed `v` adds the angular momentum `v a` about the edge ahead, per
//! mass. `a` is the distance of the centre of gravity to the line on which the edge moves. The stop
//! takes `(2 v a w + (v a)^2 / l^2) / 2 g` of the energy. The second term is that of a point mass,
//! the smallest inertia that a body can have.

use super::evaluation::Evaluation;
use super::support::{Edge, Stance};
use crate::constants::GRAVITY;
use crate::math::vector::{Vector, dot, sub};
use crate::math::{max, root_of_sum};

/// Lengths, m, and squares of lengths below this are zero; it keeps divisions away from zero.
const SMALLEST: f32 = 1e-9;
/// Minimum length of an edge, squared, m^2.
const SHORTEST: f32 = 1e-6;

/// Time constant of the low-pass of the rotation about the edges, s. An impact lasts some
/// milliseconds.
const IMPACT_TIME: f32 = 0.04;

/// Speed from which an instant stop can tip a robot over an edge on level ground, m/s:
/// `v^2 = 2 g (l - h) l^2 / h^2`.
///
/// `margin` is the distance of the centre of gravity to the edge, `height` its height over the
/// edge, m. Infinite for a height of zero or less, NaN for NaN.
#[inline]
pub fn stopping_speed(margin: f32, height: f32) -> f32 {
    if height <= 0.0 {
        return f32::INFINITY;
    }
    let square = margin * margin + height * height;
    // `l - h` without cancellation.
    let rise = margin * margin / (root_of_sum(square) + height);
    root_of_sum(2.0 * GRAVITY * rise * square) / height
}

/// How a robot turns about one edge.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Tipping {
    /// Height of the centre of gravity over the edge, m.
    pub height: f32,
    /// Distance of the centre of gravity to the line on which the edge moves when the robot drives,
    /// m; 0 for an edge beside the robot.
    pub arm: f32,
    /// Measured rotation toward the edge, rad/s.
    pub rate: f32,
    /// Square of the robot's radius of gyration, m^2.
    pub gyration: f32,
}

impl Tipping {
    /// Returns the margin of a robot at rest that has as much energy left, m. Negative if the
    /// rotation tips the robot over the edge.
    ///
    /// `margin` is that of the centre of gravity, m; `stopped` is the speed toward the edge that an
    /// instant stop ends, m/s. A rotation away from the edge does not count. NaN for NaN.
    #[inline(never)]
    pub fn margin(&self, margin: f32, stopped: f32) -> f32 {
        let height = max(self.height, 0.0);
        let square = margin * margin + height * height;
        let rise = margin * margin.abs() / (root_of_sum(square) + height + SMALLEST);
        let (rate, stop) = (max(self.rate, 0.0), max(stopped * self.arm, 0.0));
        let turning = (square + self.gyration) * rate * rate;
        let stopping = stop * (2.0 * rate + stop / (square + SMALLEST));
        let energy = rise - (turning + stopping) / (2.0 * GRAVITY);
        let size = root_of_sum(energy.abs() * (energy.abs() + 2.0 * height));
        if energy < 0.0 { -size } else { size }
    }
}

/// Rotation of a robot about the edges of its support.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rotation {
    rates: [f32; 4],
}

impl Rotation {
    /// Updates the rotation with the angular rate in level axes, rad/s, `period` s after the
    /// previous update. A rate that is not finite counts as rest.
    pub fn update(&mut self, stance: &Stance, rate: Vector<f32>, period: f32) {
        let share = period / (IMPACT_TIME + period);
        for (edge, there, [from, to]) in stance.edges() {
            let kept = &mut self.rates[edge as usize];
            let along = sub(*to, *from);
            let length = root_of_sum(max(dot(along, along), SHORTEST));
            let measured = if there {
                dot(along, rate) / length
            } else {
                0.0
            };
            let next = *kept + (measured - *kept) * share;
            *kept = if next.is_finite() { next } else { 0.0 };
        }
    }

    /// Returns how the robot turns about each edge, indexed by [`Edge`]. `found` has the margins
    /// and the levers of `stance`; `deduction` is the uncertainty of the masses, m; `gyration` the
    /// square of the radius of gyration, m^2.
    pub fn tipping(
        &self,
        stance: &Stance,
        found: &Evaluation,
        deduction: f32,
        gyration: f32,
    ) -> [Tipping; 4] {
        let [cosine, sine] = stance.along();
        core::array::from_fn(|index| {
            let [ahead, aside] = found.levers[index];
            let arm = cosine * ahead + sine * found.gravity[index];
            let arm = match index {
                index if index == Edge::Back as usize => deduction - arm,
                index if index == Edge::Front as usize => deduction + arm,
                _ => 0.0,
            };
            Tipping {
                height: root_of_sum(ahead * ahead + aside * aside) + deduction,
                arm,
                rate: self.rates[index],
                gyration,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::criterion::Criterion;
    use super::super::parameters::Parameters;
    use super::*;
    use crate::settings::Settings;

    const GYRATION: f64 = 0.053;

    /// Whether a body tips over an edge. Its centre of gravity is at `place` (forward and up from
    /// the edge, m), its radius of gyration squared `gyration`, m^2, and it turns with `rate`,
    /// rad/s, in the direction in which a mass at the top moves along `direction`. Integrates the
    /// rigid rotation about the edge with steps of 50 us.
    fn tips(place: [f64; 2], rate: f64, direction: f64, gyration: f64) -> bool {
        const STEP: f64 = 5e-5;
        let [x, z] = place;
        let square = x * x + z * z;
        // Angle of the mass from the vertical over the edge, positive behind the edge.
        let mut angle = libm::atan2(-direction * x, z);
        let mut rate = -rate;
        let moment = 9.81 * libm::sqrt(square) / (square + gyration);
        let mut least = angle;
        for _ in 0..200_000 {
            rate += moment * libm::sin(angle) * STEP;
            angle += rate * STEP;
            if angle < 0.0 {
                return true;
            }
            least = least.min(angle);
            if angle > least + 1e-6 {
                return false;
            }
        }
        false
    }

    #[test]
    fn a_rotating_body_tips_if_its_margin_is_below_zero() {
        let mut counts = [0; 2];
        for margin in [0.02, 0.05, 0.1, 0.2, 0.4] {
            for height in [0.05, 0.1, 0.2, 0.35] {
                for rate in [-2.0, 0.3, 0.6, 1.0, 1.7, 2.5, 4.0] {
                    for gyration in [0.0, GYRATION] {
                        let tipping = Tipping {
                            height: height as f32,
                            arm: 0.0,
                            rate: rate as f32,
                            gyration: gyration as f32,
                        };
                        let left = tipping.margin(margin as f32, 0.0);
                        if left.abs() < 2e-3 {
                            continue;
                        }
                        let tips = tips([-margin, height], rate, 1.0, gyration);
                        assert_eq!(left < 0.0, tips, "{margin} {height} {rate}: {left}");
                        counts[usize::from(tips)] += 1;
                    }
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
    }

    /// The rate that tips the robot at rest with the margin that was found has the energy that the
    /// turning robot has left. Both follow from the integration.
    #[test]
    fn the_margin_is_that_of_a_robot_at_rest_with_the_same_energy_left() {
        let tipping_rate = |margin: f64, height: f64| {
            let (mut low, mut high) = (0.0, 20.0);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                if tips([-margin, height], middle, 1.0, GYRATION) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            low
        };
        for (margin, height, rate) in [(0.2, 0.25, 0.8), (0.15, 0.1, 1.5), (0.3, 0.3, 1.2)] {
            let tipping = Tipping {
                height: height as f32,
                arm: 0.0,
                rate: rate as f32,
                gyration: GYRATION as f32,
            };
            let found = f64::from(tipping.margin(margin as f32, 0.0));
            assert!(found > 0.0 && found < margin);
            let energy = |margin: f64, rate: f64| {
                0.5 * (margin * margin + height * height + GYRATION) * rate * rate
            };
            let most = energy(margin, tipping_rate(margin, height));
            let left = most - energy(margin, rate);
            let at_rest = energy(found, tipping_rate(found, height));
            assert!((left - at_rest).abs() < 2e-3 * most, "{left} {at_rest}");
        }
    }

    #[test]
    fn a_robot_that_does_not_turn_toward_the_edge_has_the_margin_of_its_centre_of_gravity() {
        for margin in [-0.2, -0.01, 0.0, 0.01, 0.3] {
            for height in [0.0, 0.2] {
                for rate in [0.0, -3.0] {
                    let tipping = Tipping {
                        height,
                        rate,
                        ..Tipping::default()
                    };
                    let found = tipping.margin(margin, 0.0);
                    assert!((found - margin).abs() < 1e-5, "{margin} {height}: {found}");
                }
            }
        }
    }

    /// A support 0.6 m long on a plane with this pitch (rad), and the centre of gravity at `along`
    /// from its rear edge and `up` from the plane, m.
    fn stance(pitch: f64, along: f64, up: f64) -> Stance {
        let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
        let place = |along: f64, left: f64, up: f64| {
            [along * cosine - up * sine, left, along * sine + up * cosine]
                .map(|coordinate| coordinate as f32)
        };
        let contacts = [
            place(0.0, -0.2, 0.0),
            place(0.6, -0.2, 0.0),
            place(0.6, 0.2, 0.0),
            place(0.0, 0.2, 0.0),
        ];
        Stance::on(contacts, place(along, 0.0, up))
    }

    /// Speed along the heading from which an instant stop uses up all energy, m/s, by bisection;
    /// and the margin at rest, m.
    fn limit(stance: &Stance, direction: f32) -> (f32, f32) {
        let parameters = Parameters::new(&Settings::default());
        let level = [0.0, 0.0, GRAVITY];
        let found = Criterion::default().evaluate(stance, level, 0.0, &parameters);
        let edge = if direction > 0.0 {
            Edge::Front
        } else {
            Edge::Back
        } as usize;
        let tipping = Rotation::default().tipping(stance, &found, 0.0, 0.0)[edge];
        let (mut low, mut high) = (0.0, 100.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if tipping.margin(found.gravity[edge], middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        (low, found.gravity[edge])
    }

    #[test]
    fn the_energy_of_an_instant_stop_is_that_which_tips_a_point_mass_on_any_plane() {
        let mut checked = 0;
        for pitch in [-0.8, -0.4, 0.0, 0.4, 0.8] {
            for along in [0.05, 0.15, 0.3, 0.45, 0.55] {
                for up in [0.08, 0.15, 0.3] {
                    for direction in [1.0, -1.0] {
                        let (limit, margin) = limit(&stance(pitch, along, up), direction as f32);
                        let from_edge = if direction > 0.0 { along - 0.6 } else { along };
                        let (sine, cosine) = (libm::sin(pitch), libm::cos(pitch));
                        let place = [
                            from_edge * cosine - up * sine,
                            from_edge * sine + up * cosine,
                        ];
                        if margin <= 0.0 {
                            assert_eq!(limit, 0.0, "outside of the edge");
                            continue;
                        }
                        let [x, z] = place;
                        // Angular momentum of the motion about the edge, toward the edge.
                        let momentum = direction * direction * (z * cosine - x * sine);
                        let tips_at = |speed: f64| {
                            tips(place, speed * momentum / (x * x + z * z), direction, 0.0)
                        };
                        let limit = f64::from(limit);
                        assert!(!tips_at(0.99 * limit), "{pitch} {along} {up} {direction}");
                        // A centre of gravity below the edge is treated as if it were as far above
                        // it.
                        let exact = z > 0.0 && limit < 90.0;
                        assert!(
                            !exact || tips_at(1.01 * limit),
                            "{pitch} {along} {up} {direction}"
                        );
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 60, "{checked}");
    }

    /// A rotation about each edge that turns the robot over it, by the right-hand rule; in level
    /// axes, forward, left and up.
    #[test]
    fn each_rotation_counts_at_the_edge_over_which_it_turns_the_robot() {
        let stance = stance(0.0, 0.3, 0.2);
        for (edge, rate) in [
            (Edge::Back, [0.0, -1.0, 0.0]),
            (Edge::Front, [0.0, 1.0, 0.0]),
            (Edge::Left, [-1.0, 0.0, 0.0]),
            (Edge::Right, [1.0, 0.0, 0.0]),
        ] {
            let mut rotation = Rotation::default();
            for _ in 0..100 {
                rotation.update(&stance, rate, 4e-3);
            }
            for (index, found) in rotation.rates.into_iter().enumerate() {
                let [this, other] = [edge as usize, (edge as usize) ^ 1];
                let expected = match index {
                    index if index == this => 1.0,
                    index if index == other => -1.0,
                    _ => 0.0,
                };
                assert!((found - expected).abs() < 1e-3, "{edge:?}: {found}");
            }
            rotation.update(&stance, [f32::NAN; 3], 4e-3);
            assert_eq!(rotation.rates, [0.0; 4]);
        }
    }

    #[test]
    fn nan_is_no_margin() {
        for (height, margin, stopped) in [
            (f32::NAN, 0.1, 0.0),
            (0.1, f32::NAN, 0.0),
            (0.1, 0.1, f32::NAN),
        ] {
            let tipping = Tipping {
                height,
                arm: 0.1,
                ..Tipping::default()
            };
            assert!(
                !(tipping.margin(margin, stopped) > 0.0),
                "{height} {margin} {stopped}"
            );
        }
    }
}
