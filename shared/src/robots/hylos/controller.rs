//! The body controller: from what the sensors say and the operator wishes to the set-points of all sixteen motors.
//!
//! Three things move the legs, and what they ask for is added: the stability potential, while the margin is below its limit; the desired
//! for a clearance, while it is above; and the ground, always: four wheels are one more than a platform needs to stand on, and what
//! would lift one of them is taken out of the motion (`nL_p` cannot follow it), while the loads, felt in the torques of the legs, are spread
//! so that every wheel carries some: that closes gaps.

use super::least_squares::LeastSquares;
use super::parameters::{HIP_RANGE, KNEE_RANGE, MARGIN_LIMIT, STANCE_REACH, STEERING_RANGE};
use super::velocity::steering_rate;
use super::{Attitude, Form, LEGS, Legs, Parameters, Posture, Potential, Pull, Trajectory};
use crate::math::Scalar;
use crate::math::vector::{Vector, cross, dot, scale, sub, zero};
use crate::stability::tipover::margin;

/// Most that a hip or knee turns, rad/s. Assumed.
pub const LEG_RATE: f64 = 0.8;
/// Most that a wheel is steered, rad/s. Assumed.
pub const STEERING_RATE: f64 = 1.5;
/// Most that a wheel turns, rad/s. Assumed: 0.6 m/s.
pub const WHEEL_RATE: f64 = 8.0;
/// Gain `K_gamma` of eq. 22, 1/s. Assumed.
const STEERING_GAIN: f64 = 5.0;
/// Speed over the ground below which a wheel is not steered, m/s: it would turn for nothing.
const STEERING_SPEED: f64 = 0.02;
/// How far above its limit the margin must be for the commanded clearance to have its full say, rad.
const EASE: f64 = 0.1;
/// Rate with which the commanded clearance is approached, 1/s, and the most that it asks of a joint, rad/s.
const RETURN_GAIN: f64 = 0.8;
const RETURN_RATE: f64 = 0.25;
/// Speed with which a wheel follows the ground for each newton that it carries too little or too much, m/(s N), and the most.
const LOAD_GAIN: f64 = 8e-4;
const LOAD_SPEED: f64 = 0.12;
/// Least load of a wheel that is aimed at, N.
const LEAST_LOAD: f64 = 10.0;
/// Time over which loads are averaged, s: gears pass on every jolt.
const LOAD_TIME: f64 = 0.03;
/// How far a set-point may be ahead of its joint, rad: a blocked leg does not wind up.
const LEAD: f64 = 0.15;

/// What the sensors say.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sensed<S> {
    /// Hips and knees, rad.
    pub legs: Legs<S>,
    /// Torques of their motors, positive the way their joints count, N m. Zeros where they are not known: then gaps stay open.
    pub torques: Legs<S>,
    /// Steering angles, rad, counter-clockwise from above.
    pub steering: [S; LEGS],
    /// What is up, a unit vector in the platform's axes ([`Attitude::from_up`]).
    pub up: Vector<S>,
    /// Acceleration of the platform along its axes without gravity, m/s^2; zeros where it is not known.
    pub acceleration: Vector<S>,
}

/// What the operator wishes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Desired<S> {
    /// Speed along the heading, m/s, on the map: on a slope the wheels turn faster.
    pub forward: S,
    /// Yaw rate, rad/s.
    pub yaw_rate: S,
    /// Height of the hips above the wheels' centres in the posture to which the legs return when nothing else moves them, m.
    /// `None` leaves the legs where they are.
    pub clearance: Option<S>,
}

/// Set-points of the sixteen motors.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SetPoints<S> {
    /// Hips and knees, rad.
    pub legs: Legs<S>,
    /// Their rates, rad/s.
    pub leg_rates: Legs<S>,
    /// Steering angles, rad.
    pub steering: [S; LEGS],
    /// Their rates, rad/s.
    pub steering_rates: [S; LEGS],
    /// Wheel speeds, rad/s, forward positive.
    pub wheel_rates: [S; LEGS],
}

/// What the controller knows of the robot's stability.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Assessment<S> {
    /// Tip-over angles about the axes right, front, left and rear, rad.
    pub tip_over: [S; LEGS],
    /// The least of them.
    pub margin: S,
    /// Stability potential; zero while the margin is above its limit.
    pub potential: S,
}

/// Body controller of Hylos.
#[derive(Clone, Debug)]
pub struct Controller<S> {
    parameters: Parameters<S>,
    potential: Potential<S>,
    set_points: SetPoints<S>,
    /// Force of the ground on each wheel along the platform's z axis, low-passed, N.
    loads: [S; LEGS],
    /// Angular velocity of the platform that goes with the rates of the legs, along its axes, rad/s.
    turning: Vector<S>,
    /// Rates that the legs would have if nobody held them.
    proposed: Legs<S>,
    held: bool,
}

impl<S: Scalar> Controller<S> {
    /// A controller of a robot whose joints are where `sensed` says; nothing moves yet.
    pub fn new(parameters: Parameters<S>, potential: Potential<S>, sensed: &Sensed<S>) -> Self {
        Self {
            parameters,
            potential,
            set_points: SetPoints {
                legs: sensed.legs,
                leg_rates: [[S::ZERO; 2]; LEGS],
                steering: sensed.steering,
                steering_rates: [S::ZERO; LEGS],
                wheel_rates: [S::ZERO; LEGS],
            },
            loads: [S::ZERO; LEGS],
            turning: zero(),
            proposed: [[S::ZERO; 2]; LEGS],
            held: false,
        }
    }

    /// From the next step on the legs stay where they are, or may move again. What they would do is still computed ([`Self::ahead`]).
    pub fn hold_legs(&mut self, held: bool) {
        self.held = held;
    }

    /// The last set-points.
    pub fn set_points(&self) -> &SetPoints<S> {
        &self.set_points
    }

    /// The posture that is sensed. No sensor sees the ground, so its normal is taken to be that of the mean plane of the wheels.
    pub fn posture(&self, sensed: &Sensed<S>) -> Posture<'_, S> {
        let normal = ground_normal(&self.parameters, &sensed.legs);
        Posture::new(
            &self.parameters,
            &sensed.legs,
            &sensed.steering,
            Attitude::from_up(sensed.up),
            &[normal; LEGS],
        )
    }

    /// What will be sensed `horizon` s from now if the legs move as the last step proposed.
    pub fn ahead(&self, sensed: &Sensed<S>, horizon: S) -> Sensed<S> {
        let mut next = *sensed;
        for (leg, rates) in next.legs.iter_mut().zip(&self.proposed) {
            for ((place, rate), [low, high]) in
                leg.iter_mut().zip(rates).zip([HIP_RANGE, KNEE_RANGE])
            {
                let moved = *place + *rate * horizon;
                *place = within(moved, S::from_f64(low), S::from_f64(high));
            }
        }
        // Seen from the platform the world turns back.
        let up = sub(sensed.up, scale(horizon, cross(self.turning, sensed.up)));
        let length = dot(up, up).sqrt();
        if length > S::ZERO {
            next.up = scale(S::ONE / length, up);
        }
        next
    }

    /// Moves the set-points by one `period`, s.
    ///
    /// Total: whatever comes in, set-points are numbers within their ranges and do not move faster than their limits; a joint
    /// whose motion cannot be computed holds. Cost: 2600 operations beside sines at most, 9300 instructions of a Cortex-M4F.
    pub fn step(&mut self, sensed: &Sensed<S>, desired: &Desired<S>, period: S) -> Assessment<S> {
        self.feel(sensed, period);
        let posture = self.posture(sensed);
        let follower = posture.follower();
        let pull = Pull {
            force: sub(
                posture.weight().force,
                scale(self.parameters.mass, sensed.acceleration),
            ),
            moment: zero(),
        };
        let tip_over = posture.tip_over_angles(&pull);
        let slopes = tip_over.map(|angle| self.potential.of_angle(angle).1);
        let assessment = Assessment {
            tip_over,
            margin: margin(&tip_over),
            potential: self.potential.total(&tip_over),
        };

        // Eq. 20 with the total gradient: downhill.
        let mut rates = if assessment.potential > S::ZERO {
            let descent = posture.descent(slopes, &pull, &follower);
            slowed(&descent.total.map(|leg| leg.map(|value| -value)))
        } else {
            [[S::ZERO; 2]; LEGS]
        };
        if let Some(clearance) = desired.clearance {
            let spare = assessment.margin - S::from_f64(MARGIN_LIMIT);
            let say = spare * S::from_f64(1.0 / EASE);
            self.return_to(clearance, within(say, S::ZERO, S::ONE), &mut rates);
        }
        keep_on_ground(&posture, &follower, &self.loads, &mut rates);
        let proposed = self.within_ranges(&rates);
        let led_to = motion(&posture, &follower, desired, &proposed);
        let [_, roll, pitch] = led_to.posture;
        let (rates, motion) = if self.held {
            let still = [[S::ZERO; 2]; LEGS];
            (still, motion(&posture, &follower, desired, &still))
        } else {
            (proposed, led_to)
        };
        let turning = posture.attitude.angular_velocity([roll, pitch, S::ZERO]);
        self.turning = turning.map(|rate| bounded(rate, S::from_f64(LEG_RATE)));
        self.proposed = proposed;
        self.advance(sensed, &rates, &motion, period);
        assessment
    }

    /// Takes the loads from the leg motors' torques: a leg at rest is in balance, `tau = -J^T F`.
    fn feel(&mut self, sensed: &Sensed<S>, period: S) {
        let share = period / (S::from_f64(LOAD_TIME) + period);
        for (leg, load) in self.loads.iter_mut().enumerate() {
            let (_, [[ax, az], [bx, bz]]) =
                super::posture::leg_kinematics(&self.parameters, leg, sensed.legs[leg]);
            let [hip, knee] = sensed.torques[leg];
            let area = ax * bz - az * bx;
            // A leg that is nearly straight tells little: damped.
            let felt = (bx * hip - ax * knee) * area / (area * area + S::from_f64(1e-6));
            let change = share * (felt - *load);
            if change.is_finite() {
                *load += change;
            }
        }
    }

    /// Adds the way back to the posture with this clearance, weighed.
    fn return_to(&self, clearance: S, say: S, rates: &mut Legs<S>) {
        let stance = stance(&self.parameters, clearance);
        for (leg, rates) in self.set_points.legs.iter().zip(rates) {
            for ((now, then), rate) in leg.iter().zip(stance).zip(rates) {
                let way = S::from_f64(RETURN_GAIN) * (then - *now);
                *rate += say * bounded(way, S::from_f64(RETURN_RATE));
            }
        }
    }

    /// The same rates, bounded, without what would leave a joint's range.
    fn within_ranges(&self, rates: &Legs<S>) -> Legs<S> {
        let mut rates = slowed(rates);
        for (leg, rates) in self.set_points.legs.iter().zip(&mut rates) {
            for ((place, [low, high]), rate) in leg.iter().zip([HIP_RANGE, KNEE_RANGE]).zip(rates) {
                let (at_low, at_high) =
                    (!(*place > S::from_f64(low)), !(*place < S::from_f64(high)));
                if (at_low && *rate < S::ZERO) || (at_high && *rate > S::ZERO) {
                    *rate = S::ZERO;
                }
            }
        }
        rates
    }

    fn advance(
        &mut self,
        sensed: &Sensed<S>,
        rates: &Legs<S>,
        motion: &super::MotorGoals<S>,
        period: S,
    ) {
        let points = &mut self.set_points;
        points.leg_rates = *rates;
        for (leg, place) in points.legs.iter_mut().enumerate() {
            for (joint, range) in [HIP_RANGE, KNEE_RANGE].into_iter().enumerate() {
                let measured = sensed.legs[leg][joint];
                place[joint] = moved(place[joint], rates[leg][joint], period, measured, range);
            }
        }
        for leg in 0..LEGS {
            let measured = sensed.steering[leg];
            // Rolling is seen in the wheel's own speed: without it the direction of the rest is chance.
            let rolling = motion.wheels[leg] * self.parameters.wheel_radius;
            let fast = rolling * rolling > S::from_f64(STEERING_SPEED * STEERING_SPEED);
            let wanted = match motion.steering[leg] {
                Some(wanted) if fast => wanted,
                _ => points.steering[leg],
            };
            let rate = bounded(
                steering_rate(S::from_f64(STEERING_GAIN), wanted, measured),
                S::from_f64(STEERING_RATE),
            );
            points.steering_rates[leg] = rate;
            points.steering[leg] =
                moved(points.steering[leg], rate, period, measured, STEERING_RANGE);
            points.wheel_rates[leg] = bounded(motion.wheels[leg], S::from_f64(WHEEL_RATE));
        }
    }
}

/// Motion of platform, wheels and steering that goes with the desired and these rates of the legs.
fn motion<S: Scalar>(
    posture: &Posture<S>,
    follower: &LeastSquares<S>,
    desired: &Desired<S>,
    rates: &Legs<S>,
) -> super::MotorGoals<S> {
    let trajectory = Trajectory {
        velocity: [desired.forward, sideways(posture, follower, rates)],
        yaw_rate: desired.yaw_rate,
    };
    posture.follow(follower, &trajectory, rates, Form::Full)
}

/// Normal of the mean plane of the wheels' centres, in the platform's axes: their diagonals are parallel to it.
fn ground_normal<S: Scalar>(parameters: &Parameters<S>, legs: &Legs<S>) -> Vector<S> {
    let [a, b, c, d] =
        core::array::from_fn(|leg| super::posture::leg_kinematics(parameters, leg, legs[leg]).0);
    let normal = cross(sub(a, d), sub(c, b));
    let length = dot(normal, normal).sqrt();
    if length > S::from_f64(1e-6) {
        scale(S::ONE / length, normal)
    } else {
        [S::ZERO, S::ZERO, S::ONE]
    }
}

/// Hip and knee that put a wheel's centre [`STANCE_REACH`] outside its hip and `clearance` below it, or as near as the leg comes.
pub fn stance<S: Scalar>(parameters: &Parameters<S>, clearance: S) -> [S; 2] {
    let [thigh, shank] = parameters.leg;
    let reach = S::from_f64(STANCE_REACH);
    let square = reach * reach + clearance * clearance;
    let cosine = (square - thigh * thigh - shank * shank) / (thigh * shank + thigh * shank);
    let cosine = within(cosine, -S::ONE, S::ONE);
    let sine = (S::ONE - cosine * cosine).sqrt();
    let hip = clearance.atan2(reach) - (shank * sine).atan2(thigh + shank * cosine);
    [
        within(hip, S::from_f64(HIP_RANGE[0]), S::from_f64(HIP_RANGE[1])),
        within(
            sine.atan2(cosine),
            S::from_f64(KNEE_RANGE[0]),
            S::from_f64(KNEE_RANGE[1]),
        ),
    ]
}

/// Takes out of `rates` what would lift a wheel, and adds what spreads the loads as they should be.
fn keep_on_ground<S: Scalar>(
    posture: &Posture<S>,
    follower: &LeastSquares<S>,
    loads: &[S; LEGS],
    rates: &mut Legs<S>,
) {
    let lifting = follower.residual(posture.normal_speeds([zero(); 2], rates));
    let surplus = surplus(follower, loads);
    for (leg, wheel) in posture.wheels.iter().enumerate() {
        let follow = bounded(
            S::from_f64(LOAD_GAIN) * surplus[leg],
            S::from_f64(LOAD_SPEED),
        );
        let wanted = follow - lifting[leg];
        let [hip, knee] = wheel.along(wheel.normal);
        // The least motion of the leg that does it; damped where the leg cannot.
        let factor = wanted / (hip * hip + knee * knee + S::from_f64(1e-3));
        rates[leg][0] += factor * hip;
        rates[leg][1] += factor * knee;
    }
}

/// What each wheel carries too much, N. Balance leaves one pattern of loads free, more on one diagonal and less on the other. There
/// should be none of it, but for what gives every wheel its least load: near the edge of the support equal shares would ask a
/// wheel to pull, and it would be lifted instead.
fn surplus<S: Scalar>(follower: &LeastSquares<S>, loads: &[S; LEGS]) -> [S; LEGS] {
    // Loads that are not known are all zero.
    if loads.iter().all(|load| *load == S::ZERO) {
        return [S::ZERO; LEGS];
    }
    let (one, least) = (S::ONE, S::from_f64(LEAST_LOAD));
    let pattern = follower.residual([one, -one, -one, one]);
    let square = product(&pattern, &pattern);
    let free = product(&pattern, loads) / (square + S::from_f64(1e-6));
    // How much of the pattern may be there.
    let (mut low, mut high) = (S::from_f64(-1e30), S::from_f64(1e30));
    for (share, load) in pattern.into_iter().zip(loads) {
        // So much of the pattern leaves this wheel its least load.
        let bound = (least - (*load - free * share)) / share;
        if share > S::ZERO && bound > low {
            low = bound;
        } else if share < S::ZERO && bound < high {
            high = bound;
        }
    }
    let wanted = if low > high {
        S::from_f64(0.5) * (low + high)
    } else {
        within(S::ZERO, low, high)
    };
    pattern.map(|share| share * (free - wanted))
}

fn product<S: Scalar>(a: &[S; LEGS], b: &[S; LEGS]) -> S {
    a.iter().zip(b).fold(S::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Speed of the platform to its left, m/s, that goes with these rates of the legs: the wheels roll forward, but nothing lets them slide
/// sideways, so when the platform rolls over them it is the platform that moves. Least squares over the four wheels.
fn sideways<S: Scalar>(posture: &Posture<S>, follower: &LeastSquares<S>, rates: &Legs<S>) -> S {
    let slide = |path: [Vector<S>; 2], legs: &Legs<S>| -> [S; LEGS] {
        let rising = posture.normal_speeds(path, legs);
        let following = follower.solve(rising).map(|value| -value);
        let twist = posture.with_posture(path, following);
        core::array::from_fn(|leg| {
            let wheel = &posture.wheels[leg];
            let velocity = wheel.velocity(twist, legs[leg]);
            dot(wheel.lateral, velocity)
        })
    };
    let left = Trajectory {
        velocity: [S::ZERO, S::ONE],
        yaw_rate: S::ZERO,
    };
    let at_rest = [[S::ZERO; 2]; LEGS];
    let (unit, forced) = (
        slide(posture.path_twist(&left), &at_rest),
        slide([zero(); 2], rates),
    );
    -(product(&unit, &forced) / (product(&unit, &unit) + S::from_f64(1e-3)))
}

/// All rates times one factor, so that none is above [`LEG_RATE`]: the direction stays.
fn slowed<S: Scalar>(rates: &Legs<S>) -> Legs<S> {
    let limit = S::from_f64(LEG_RATE);
    let mut largest = limit;
    for rate in rates.as_flattened() {
        let size = if *rate < S::ZERO { -*rate } else { *rate };
        if size > largest {
            largest = size;
        }
    }
    let factor = limit / largest;
    rates.map(|leg| leg.map(|rate| bounded(rate * factor, limit)))
}

/// `place` moved at `rate`, not far from where the joint is, and within its range.
fn moved<S: Scalar>(place: S, rate: S, period: S, measured: S, [low, high]: [f64; 2]) -> S {
    let lead = S::from_f64(LEAD);
    let next = within(place + rate * period, measured - lead, measured + lead);
    let next = within(next, S::from_f64(low), S::from_f64(high));
    if next.is_finite() { next } else { place }
}

/// `value` kept within `low..=high`; a bound that is no number does not bind.
fn within<S: Scalar>(value: S, low: S, high: S) -> S {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// `value` kept within `-bound..=bound`; 0 for NaN.
fn bounded<S: Scalar>(value: S, bound: S) -> S {
    if value > bound {
        bound
    } else if value < -bound {
        -bound
    } else if value.is_finite() {
        value
    } else {
        S::ZERO
    }
}
