//! Position loop around a velocity loop, in fixed point: computes a motor current from a set-point
//! and the measured motion.
//!
//! Velocities count in fractions of the velocity limit, which is 2^28, so that one instruction
//! (SSAT) limits them. Currents count in fractions of the current limit. Their unit follows from
//! the gain, so that no digit is lost. [`Cascade`] converts from and to SI units.

use super::profile::Motion;
use crate::math::cubic::{mul_high, mul_high_add};
use crate::math::{Bound, Turns, saturate, to_i32};

/// Gains of the loops at the output shaft, and the limits of the loops.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// Gain of the position loop, 1/s.
    pub position: f32,
    /// Gain of the velocity loop, A s/rad.
    pub velocity: f32,
    /// Integral time of the velocity loop, s, above zero.
    pub integral_time: f32,
    /// Current per acceleration, for the feed-forward, A s^2/rad.
    pub acceleration: f32,
    /// Largest velocity that the position loop may command, rad/s, above zero.
    pub velocity_limit: f32,
    /// Largest current, A, above zero.
    pub current_limit: f32,
    /// Time from one call to the next, s.
    pub period: f32,
}

/// The velocity limit is 2 to this power.
const VELOCITY_BITS: u32 = 28;
/// The current limit is at most 2 to this power.
const CURRENT_BITS: u32 = 25;
/// Fraction bits that the integral has in addition to those of a current.
const INTEGRAL_BITS: u32 = 4;
/// Velocities and currents from callers are limited to these values: twice their limits, or more.
const OUTSIDE_VELOCITY: i32 = (2 << VELOCITY_BITS) - 1;
const OUTSIDE_CURRENT: i32 = (2 << CURRENT_BITS) - 1;

/// Feed-forward in the units of a [`Cascade`]; [`Cascade::feed_forward`] creates it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct FeedForward {
    /// Velocity, up to 2^29.
    pub velocity: i32,
    /// Current, up to 2^27: the sum of the current for the acceleration and one from the caller.
    pub current: i32,
}

/// Current that the loops demand, and what the limits cut off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Demand {
    /// Demanded current, within the given bound.
    pub current: i32,
    /// What the bound of the current cut off; then the integral stays.
    excess: i32,
    /// What else a limit cut off.
    cut: i32,
    /// The integral of the velocity loop after this call.
    integral: i32,
    /// A torque is demanded: the integral is the current.
    of_torque: bool,
}

impl Demand {
    /// Returns whether a torque is demanded, whose limited current becomes the integral.
    #[inline]
    pub fn is_torque(&self) -> bool {
        self.of_torque
    }

    /// Returns what the velocity limit and the bound of the current cut off, as any number; zero
    /// while neither acts.
    #[inline]
    pub fn cut(&self) -> i32 {
        self.excess | self.cut
    }
}

/// Position loop and velocity loop. Their only state is the integral of the velocity loop. It
/// changes when the caller hands a demand back to [`Cascade::advance`].
///
/// The integral does not change while the current is limited. It grows only while the velocity
/// error has its sign and the sum is within the bound. So it never exceeds the bound plus the
/// feed-forward that acts against it: it does not wind up, and no sum overflows. While a torque is
/// demanded, the integral is the limited current.
#[derive(Clone, Debug)]
pub struct Cascade {
    /// Half a turn, divided by the largest position error that counts; a power of two.
    error_scale: u32,
    /// Velocity at the largest position error; 2^29 is the velocity limit.
    position_gain: i32,
    /// Gains of the velocity loop per unit of velocity, with 32 fraction bits: change of the
    /// integral in one call, and current.
    integral_gain: i32,
    velocity_gain: i32,
    integral: i32,
    /// Units of velocity per rad/s, units of current per rad/s^2 and per A, and A per unit of
    /// current.
    per_velocity: f32,
    per_acceleration: f32,
    per_ampere: f32,
    amperes: f32,
}

impl Cascade {
    /// Creates the loops with an integral of zero.
    ///
    /// A position error above half a turn counts as half a turn. If half a turn would command four
    /// times the velocity limit or more, the largest error that counts is smaller. It still
    /// commands at least twice the velocity limit.
    ///
    /// Very large gains may be reduced: a position gain with which 2^-16 of half a turn commands
    /// more than the velocity limit, and a velocity gain with which a velocity error of 2^-16 of
    /// the velocity limit demands more than the current limit.
    pub fn new(gains: &Gains) -> Self {
        let half_turn = 2_147_483_648.0 / Turns::PER_RADIAN;
        let mut velocity = gains.position * half_turn / gains.velocity_limit;
        let mut error_scale = 1;
        while velocity >= 4.0 && error_scale < 1 << 16 {
            velocity *= 0.5;
            error_scale *= 2;
        }
        let mut full = (1 << CURRENT_BITS) as f32;
        // The high word of 2^28 times a gain of 2^31 is 2^27.
        let mut current = gains.velocity * gains.velocity_limit / gains.current_limit
            * (full / (1 << (VELOCITY_BITS - 1)) as f32);
        let in_one_call = gains.period / gains.integral_time * (1 << INTEGRAL_BITS) as f32;
        while (current >= 1.0 || current * in_one_call >= 1.0) && full > 1024.0 {
            current *= 0.5;
            full *= 0.5;
        }
        let one = 2_147_483_648.0;
        let per_ampere = full / gains.current_limit;
        Self {
            error_scale,
            position_gain: to_i32(velocity * (one / 4.0)),
            integral_gain: to_i32(current * in_one_call * one),
            velocity_gain: to_i32(current * one),
            integral: 0,
            per_velocity: (1_u32 << VELOCITY_BITS) as f32 / gains.velocity_limit,
            per_acceleration: gains.acceleration * per_ampere,
            per_ampere,
            amperes: gains.current_limit / full,
        }
    }

    /// Clears the integral. Call it before the bridge is switched on.
    pub fn reset(&mut self) {
        self.integral = 0;
    }

    /// Takes over the integral of a demand. `left` is the current, A, that limits after the loops
    /// leave of it; `None` if none acts. The integral of the velocity loop stays while a limit
    /// acts, so that it does not wind up. That of a torque becomes the current that is left.
    #[inline]
    pub fn advance(&mut self, demand: &Demand, left: Option<f32>) {
        match left {
            Some(left) if demand.of_torque => self.integral = self.current(left) << INTEGRAL_BITS,
            None if demand.excess == 0 => self.integral = demand.integral,
            _ => {}
        }
    }

    /// Takes over the current in the integral of `other`, limited to `bound`. It is used when the
    /// limits change.
    pub fn take_over(&mut self, other: &Self, bound: Bound) {
        let current = self.current(other.amperes(other.integral >> INTEGRAL_BITS));
        self.integral = bound.limit(current) << INTEGRAL_BITS;
    }

    /// Shifts the integral so that the loops demand `amperes` where they demand `demand` now. The
    /// integral stays within `bound`. It is used when the gains change.
    pub fn continue_at(&mut self, amperes: f32, demand: &Demand, bound: Bound) {
        let asked = demand.current.wrapping_add(demand.excess);
        let shift = self.current(amperes).wrapping_sub(asked);
        let current = (self.integral >> INTEGRAL_BITS).saturating_add(shift);
        self.integral = bound.limit(current) << INTEGRAL_BITS;
    }

    /// Converts the velocity and the acceleration of a set-point to the feed-forward.
    #[inline]
    pub fn feed_forward(&self, set_point: &Motion) -> FeedForward {
        FeedForward {
            velocity: self.rate(set_point.velocity),
            current: outside(
                set_point.acceleration * self.per_acceleration,
                OUTSIDE_CURRENT,
            ),
        }
    }

    /// Converts a velocity, rad/s, to the units of the loops.
    #[inline]
    pub fn rate(&self, velocity: f32) -> i32 {
        outside(velocity * self.per_velocity, OUTSIDE_VELOCITY)
    }

    /// Creates a bound of the current from a current in A; 0 for NaN and for negative values.
    #[inline]
    pub fn bound(&self, amperes: f32) -> Bound {
        Bound::new(self.current(amperes))
    }

    /// Converts a current, A, to the units of the loops, up to 2^26; 0 for NaN.
    #[inline]
    pub fn current(&self, amperes: f32) -> i32 {
        outside(amperes * self.per_ampere, OUTSIDE_CURRENT)
    }

    /// Converts a current from the units of the loops to A.
    #[inline]
    pub fn amperes(&self, current: i32) -> f32 {
        current as f32 * self.amperes
    }

    /// Runs both loops: computes the current that ends the following `error` (set-point minus
    /// measured position) at the measured `velocity`. The result never exceeds `bound`,
    /// whatever the inputs are.
    ///
    /// Domain: errors below 2^14 turns, velocities up to 2^29. Worst error against
    /// double precision over 100 000 calls: 8e-6 of the current limit, 1.4e-6 with nominal gains
    /// (`shared/tests/motor/cascade.rs`). Cost on Cortex-M4: about 35 instructions.
    #[inline]
    pub fn position(
        &self,
        error: Turns,
        feed_forward: FeedForward,
        velocity: i32,
        bound: Bound,
    ) -> Demand {
        let error = saturate(error.to_bits().wrapping_mul(i64::from(self.error_scale)));
        // The sum is at most 2 + 4 velocity limits, and 2^31 is 8 of them.
        let wanted = mul_high_add(feed_forward.velocity, error, self.position_gain);
        let allowed = wanted.clamp(-(1 << VELOCITY_BITS), (1 << VELOCITY_BITS) - 1);
        let mut demand = self.velocity(allowed, feed_forward.current, velocity, bound);
        demand.cut = wanted.wrapping_sub(allowed);
        demand
    }

    /// Limits a demanded current, up to 2^27, so that it does not drive the axle beyond the
    /// velocity limit. In each direction the current is at most what the velocity loop without its
    /// integral demands at the velocity limit. The integral follows the current, also one that
    /// [`Self::advance`] hands back, so that the loops take over without a jump.
    #[inline]
    pub fn torque(&self, current: i32, velocity: i32, bound: Bound) -> Demand {
        // Velocities are at most twice the limit, so nothing overflows.
        let most = mul_high((1 << VELOCITY_BITS) - velocity, self.velocity_gain);
        let least = mul_high(-(1 << VELOCITY_BITS) - velocity, self.velocity_gain);
        let slowed = if current > most {
            most
        } else if current < least {
            least
        } else {
            current
        };
        let limited = bound.limit(slowed);
        Demand {
            current: limited,
            excess: 0,
            cut: current.wrapping_sub(limited),
            integral: limited << INTEGRAL_BITS,
            of_torque: true,
        }
    }

    /// Runs the velocity loop alone, with a current feed-forward.
    #[inline]
    pub fn velocity(&self, wanted: i32, current: i32, velocity: i32, bound: Bound) -> Demand {
        let error = wanted.wrapping_sub(velocity);
        // Rounded, because a sum of truncated products would drift.
        let integral = mul_high_add(self.integral, error, self.integral_gain);
        let held = (integral >> INTEGRAL_BITS).wrapping_add(current);
        let asked = mul_high_add(held, error, self.velocity_gain);
        let current = bound.limit(asked);
        Demand {
            current,
            excess: asked.wrapping_sub(current),
            cut: 0,
            integral,
            of_torque: false,
        }
    }
}

/// Converts a value from a caller to fixed point, limited to `end`; 0 for NaN.
#[inline]
fn outside(value: f32, end: i32) -> i32 {
    to_i32(value).clamp(-end - 1, end)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains {
        position: 20.0,
        velocity: 3.0,
        integral_time: 0.05,
        acceleration: 0.02,
        velocity_limit: 6.0,
        current_limit: 10.0,
        period: 1e-3,
    };

    /// Simulates a rotor with an inertia of 0.05 kg m^2 and 2.4 N m/A against a constant load
    /// torque. Returns its last position and velocity, and its largest angle, rad.
    fn settle(load: f32, target: Turns) -> (Turns, f32, f32) {
        let (mut cascade, mut position, mut velocity, mut peak) =
            (Cascade::new(&GAINS), Turns::ZERO, 0.0_f32, 0.0_f32);
        let bound = cascade.bound(10.0);
        for _ in 0..3_000 {
            let rate = cascade.rate(velocity);
            let error = target - position;
            let demand = cascade.position(error, FeedForward::default(), rate, bound);
            cascade.advance(&demand, None);
            velocity += (2.4 * cascade.amperes(demand.current) - load) / 0.05 * 1e-3;
            position += Turns::from_radians(velocity * 1e-3);
            peak = if position.radians() > peak {
                position.radians()
            } else {
                peak
            };
        }
        (position, velocity, peak)
    }

    #[test]
    fn holds_a_position_against_a_constant_load() {
        let (position, velocity, _) = settle(5.0, Turns::ZERO);
        assert!(
            position.radians().abs() < 1e-4 && velocity.abs() < 1e-3,
            "{position:?} {velocity}"
        );
    }

    #[test]
    fn a_long_step_does_not_wind_up() {
        let target = Turns::from_radians(10.0);
        let (position, _, peak) = settle(0.0, target);
        assert!((position - target).radians().abs() < 1e-3);
        assert!(peak < 10.0 * 1.02, "overshoot to {peak}");
    }

    #[test]
    fn nothing_exceeds_the_bound() {
        let numbers = [i32::MIN, -1 << 29, -1, 0, 1, 1 << 29, i32::MAX];
        for bad in numbers {
            for velocity in numbers {
                let mut cascade = Cascade::new(&GAINS);
                let bound = cascade.bound(8.0);
                for position in [0, i64::MIN, i64::MAX, i64::from(bad) << 31] {
                    let error = Turns::from_bits(i64::from(bad).wrapping_sub(position));
                    let feed_forward = FeedForward {
                        velocity: bad,
                        current: bad,
                    };
                    let demand = cascade.position(error, feed_forward, velocity, bound);
                    cascade.advance(&demand, None);
                    assert!(cascade.amperes(demand.current).abs() <= 8.000_001);
                    let demand = cascade.velocity(bad, bad, velocity, bound);
                    cascade.advance(&demand, None);
                    assert!(cascade.amperes(demand.current).abs() <= 8.000_001);
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_asks_for_nothing() {
        let cascade = Cascade::new(&GAINS);
        assert_eq!(cascade.rate(f32::NAN), 0);
        assert_eq!(cascade.bound(f32::NAN), Bound::new(0));
        assert_eq!(cascade.bound(-1.0), Bound::new(0));
        assert_eq!(cascade.rate(f32::INFINITY), OUTSIDE_VELOCITY);
    }
}
