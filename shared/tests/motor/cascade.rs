//! Compares the fixed-point cascade with the same loops in double precision.

use std::f64::consts::{PI, TAU};
use tautrack::math::Turns;
use tautrack::motor::cascade::{Cascade, FeedForward, Gains};
use tautrack::motor::profile::Motion;

const TURN: f64 = 4_294_967_296.0;

/// Very different axles: the nominal one, a fast screw, a very slow joint, a stiff direct drive.
const AXLES: [Gains; 4] = [
    gains(20.0, 3.0, 0.05, 6.0, 10.0),
    gains(20.0, 3.0, 0.05, 60.0, 10.0),
    gains(20.0, 30.0, 0.02, 0.05, 4.0),
    gains(100.0, 0.5, 0.01, 200.0, 30.0),
];

const fn gains(
    position: f32,
    velocity: f32,
    integral_time: f32,
    velocity_limit: f32,
    current_limit: f32,
) -> Gains {
    Gains {
        position,
        velocity,
        integral_time,
        acceleration: 0.02,
        velocity_limit,
        current_limit,
        period: 1e-3,
    }
}

/// The same loops in double precision, as in a textbook.
struct Double {
    gains: Gains,
    integral: f64,
}

impl Double {
    /// Returns the current before its limit, A, and the integral that belongs to it, for a position
    /// error in rad.
    fn asked(&self, error: f64, set_point: &Motion, velocity: f64) -> (f64, f64) {
        let value = |gain: f32| f64::from(gain);
        let limit = value(self.gains.velocity_limit);
        let wanted = f64::from(set_point.velocity) + value(self.gains.position) * error;
        let push = value(self.gains.velocity) * (wanted.clamp(-limit, limit) - velocity);
        let share = value(self.gains.period) / value(self.gains.integral_time);
        let integral = self.integral + push * share;
        let fed = value(self.gains.acceleration) * f64::from(set_point.acceleration);
        (push + fed + integral, integral)
    }
}

/// Generates random numbers from -1 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2_f64.powi(52) - 1.0
    }
}

/// Runs both cascades on the same motion for `calls` calls. Returns the largest difference as a
/// fraction of the current limit. `size` scales the motion: at 1 it reaches every limit again and
/// again.
fn worst_difference(gains: &Gains, size: f64, calls: u32) -> f64 {
    let mut cascade = Cascade::new(gains);
    let mut double = Double {
        gains: *gains,
        integral: 0.0,
    };
    let mut random = Random(7);
    let speed = f64::from(gains.velocity_limit);
    let full = f64::from(gains.current_limit);
    let (mut worst, mut limited_calls) = (0.0_f64, 0);
    for call in 0..calls {
        // Sometimes the bound is lower, as for holding.
        let bound_share = if call % 1_000 < 700 { 1.0 } else { 0.6 };
        let bound = cascade.bound((bound_share * full) as f32);
        let reach = 3.0 * speed / f64::from(gains.position);
        let position = (random.next() * 1e15) as i64;
        let difference = (random.next() * size * reach / TAU * TURN) as i64;
        let set_point = Motion {
            position: Turns::from_bits(position + difference),
            velocity: (random.next() * size * speed) as f32,
            acceleration: (random.next() * size * 100.0) as f32,
        };
        let velocity = (random.next() * size * speed) as f32;

        let (ahead, rate) = (cascade.feed_forward(&set_point), cascade.rate(velocity));
        let demand = cascade.position(Turns::from_bits(difference), ahead, rate, bound);
        cascade.advance(&demand, None);
        let current = f64::from(cascade.amperes(demand.current));

        // An error of more than half a turn counts as half a turn.
        let error = (difference as f64 / TURN * TAU).clamp(-PI, PI);
        let (asked, integral) = double.asked(error, &set_point, f64::from(velocity));
        let limit = bound_share * full;
        worst = worst.max((current - asked.clamp(-limit, limit)).abs() / full);
        // Where the sum just reaches the limit, its last digit decides whether the integral
        // changes.
        let near = (asked.abs() - limit).abs() < 1e-5 * full;
        let at_limit =
            demand.current == bound.limit(i32::MAX) || demand.current == bound.limit(i32::MIN);
        assert!(
            near || at_limit == (asked.abs() > limit),
            "call {call}: {asked} A, but {demand:?}"
        );
        if at_limit {
            limited_calls += 1;
        } else {
            double.integral = integral;
        }
    }
    assert_eq!(
        limited_calls > 0,
        size >= 1.0,
        "the sweep is not what it should be"
    );
    worst
}

#[test]
fn the_current_is_that_of_double_precision_at_every_limit() {
    for gains in &AXLES {
        let worst = worst_difference(gains, 1.0, 100_000);
        println!("{worst:e} of the current limit, {gains:?}");
        assert!(worst < 8e-6, "{worst:e} {gains:?}");
    }
}

#[test]
fn the_integral_does_not_drift_in_a_hundred_thousand_calls() {
    for gains in &AXLES {
        let worst = worst_difference(gains, 1e-3, 100_000);
        println!("{worst:e} of the current limit, {gains:?}");
        assert!(worst < 3e-6, "{worst:e} {gains:?}");
    }
}

#[test]
fn an_integral_that_was_let_grow_frees_itself_when_the_bound_shrinks() {
    let mut cascade = Cascade::new(&AXLES[0]);
    let (full, hold) = (cascade.bound(10.0), cascade.bound(1.0));
    for _ in 0..200 {
        let demand = cascade.position(Turns::from_bits(1 << 26), FeedForward::default(), 0, full);
        cascade.advance(&demand, None);
    }
    // The error changes its sign. The current must follow within the integral's own time.
    let mut currents = (0..2_000).map(|_| {
        let demand = cascade.position(Turns::from_bits(-1 << 26), FeedForward::default(), 0, hold);
        cascade.advance(&demand, None);
        demand.current
    });
    let after = currents.position(|current| current < 0);
    let after = after.expect("the current turns");
    assert!(after < 200, "{after} calls");
}
