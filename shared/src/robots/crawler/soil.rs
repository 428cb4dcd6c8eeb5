//! Models the ground: shear stress over deformation, driving force of a track over slip, and the
//! slip that a force needs.

use super::parameters::{Ground, ParametersError, within};
use crate::math::Scalar;
use crate::math::exponential::{RECIPROCALS, mean_decay, rise};

/// Part of a track that lies on the ground, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Footprint<S> {
    /// Width `b`.
    pub width: S,
    /// Length `L`.
    pub length: S,
}

/// Ground that shears by the law of Bekker and Kacigin (Kurc and Szybicki, eq. 5 and 6), in a form
/// without singularity: with `s = sqrt(K2^2 - 1)`, `u = K1 dl` and the mean decay
/// `m(x) = (1 - e^-x) / x`,
///
/// `(e^((-K2 + s) u) - e^((-K2 - s) u)) / Y_max  =  p u m(2 s u) e^-(u (K2 - s))`,
/// `p = e^(K2 acosh(K2) / s)`.
///
/// At `K2 = 1` this is its limit `u e^(1 - u)`. Below 1 the root is imaginary. The paper does not
/// cover this case, and [`Self::new`] refuses it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Soil<S> {
    cohesion: S,
    friction: S,
    k1: S,
    /// `K2 - s` and `K2 + s`.
    slow: S,
    fast: S,
    /// The factor `p` of the form above.
    peak: S,
    /// `u` at the end of a run at which the mean over the run is largest; with more slip the ground
    /// carries less.
    utmost: S,
}

impl<S: Scalar> Soil<S> {
    /// Soil with the coefficients of this ground. Cost: some thousand operations in double
    /// precision, for start-up only.
    ///
    /// # Errors
    /// The first value out of range: cohesion 0 to 10^7 Pa, friction angle 0 to 80 degrees
    /// (1.4 rad), `K1` 0.1 to 100000 per metre, `K2` 1 to 100.
    pub fn new(ground: &Ground) -> Result<Self, ParametersError> {
        let cohesion = within("cohesion", ground.cohesion, [0.0, 1e7])?;
        let angle = within("friction angle", ground.friction_angle, [0.0, 1.4])?;
        let k1 = within("K1", ground.k1, [0.1, 1e5])?;
        let k2 = within("K2", ground.k2, [1.0, 100.0])?;
        let (sine, cosine) = Scalar::sin_cos(angle);
        let root = Scalar::sqrt((k2 - 1.0) * (k2 + 1.0));
        // The slow rate is computed as a quotient, because the difference K2 - s would lose its
        // digits.
        let fast = k2 + root;
        let slow = 1.0 / fast;
        // p = e^(K2 a / s) with a = acosh(K2) = ln(K2 + s).
        let rising = arc_hyperbolic_cosine_over_root(k2);
        let mut shape = Soil {
            cohesion,
            friction: sine / cosine,
            k1,
            slow,
            fast,
            peak: fast / (1.0 - rise(slow * rising)),
            utmost: 0.0,
        };
        shape.utmost = bisect([rising, 4.0], |u| {
            shape.mobilised(u) > shape.mean_mobilised(u)
        });
        Ok(Self {
            cohesion: S::from_f64(shape.cohesion),
            friction: S::from_f64(shape.friction),
            k1: S::from_f64(shape.k1),
            slow: S::from_f64(shape.slow),
            fast: S::from_f64(shape.fast),
            peak: S::from_f64(shape.peak),
            utmost: S::from_f64(shape.utmost),
        })
    }

    /// Shear strength `tau_max = c + sigma tan rho` under `pressure` (`sigma`), all in Pa (eq. 5).
    pub fn strength(&self, pressure: S) -> S {
        self.cohesion + self.friction * pressure
    }

    /// Largest value `Y_max` of the numerator of eq. 6; 0 at `K2 = 1`, where numerator and
    /// denominator vanish together.
    pub fn numerator_maximum(&self) -> S {
        (self.fast - self.slow) / self.peak
    }

    /// Fraction of the strength that a deformation `K1 dl = u`, not below zero, mobilises.
    fn mobilised(&self, u: S) -> S {
        let decay = S::ONE - rise(self.slow * u);
        self.peak * u * mean_decay((self.fast - self.slow) * u) * decay
    }

    /// Mean of [`Self::mobilised`] from 0 to `u`, not below zero: the integral of eq. 4 in closed
    /// form.
    fn mean_mobilised(&self, u: S) -> S {
        self.moments_mobilised(u)[0]
    }

    /// Means of [`Self::mobilised`] from 0 to `u`, not below zero: by itself, and weighted by the
    /// fraction of the distance from 0 to `u`.
    fn moments_mobilised(&self, u: S) -> [S; 2] {
        let (a, b) = (self.slow * u, self.fast * u);
        // Divided differences of e^-x: the one at 0, a and b, and minus the sum of those at 0, a,
        // a, b and at 0, a, b, b.
        let differences = if b < S::from_f64(0.25) {
            series(a, b)
        } else {
            let decay = (S::ONE - rise(a)) * mean_decay(b - a);
            let mean = (mean_decay(a) - decay) / b;
            [mean, (mean + decaying_distance(a) - decay) / b]
        };
        differences.map(|difference| self.peak * u * difference)
    }

    /// Shear stress `tau_x`, Pa, under `pressure` (Pa) at `deformation` (`dl_x`, m), with the sign
    /// of the deformation (eq. 6).
    pub fn shear_stress(&self, pressure: S, deformation: S) -> S {
        odd(deformation, |size| {
            self.strength(pressure) * self.mobilised(self.k1 * size)
        })
    }

    /// Driving force `P_n` of one track, N, under `pressure` (Pa) at `slip` (`s_b`), with the sign
    /// of the slip (eq. 4 with 6 and 7).
    ///
    /// The deformation grows in proportion to the distance from where the ground meets the track,
    /// up to `slip` times the length. The factor 10^6 of eq. 4 is for stresses in N/mm^2 and is not
    /// needed here. Worst error in `f64`: 1e-14 of the force
    /// (`shared/tests/robots/crawler_model.rs`).
    pub fn driving_force(&self, footprint: &Footprint<S>, pressure: S, slip: S) -> S {
        let bears = footprint.width * footprint.length * self.strength(pressure);
        odd(slip, |size| {
            bears * self.mean_mobilised(self.k1 * size * footprint.length)
        })
    }

    /// Slip at which one track carries most, at any pressure. Above 1 if the ground yields so much
    /// that the track never reaches this maximum.
    pub fn utmost_slip(&self, footprint: &Footprint<S>) -> S {
        self.utmost / (self.k1 * footprint.length)
    }

    /// Slip at which one track carries `force` (N, either sign): the inverse of
    /// [`Self::driving_force`] up to its maximum.
    ///
    /// The pressure grows along the run, from `1 - shift` times its mean `pressure` where the
    /// ground meets the track to `1 + shift` times it at the other end; `shift` is within +-1.
    /// Worst error in `f32`: 2e-6 of [`Self::utmost_slip`]. With a shift the ground carries a
    /// little more at a slip other than that one, which this function does not use. Cost: 24
    /// evaluations of the force.
    ///
    /// # Errors
    /// [`ParametersError::BeyondTraction`] if the ground carries less, or `force` is NaN.
    pub fn slip_for(
        &self,
        footprint: &Footprint<S>,
        pressure: S,
        shift: S,
        force: S,
    ) -> Result<S, ParametersError> {
        self.slip_bearing(footprint, pressure, shift, force)
            .map_err(|maximum| ParametersError::BeyondTraction {
                got: force.to_f64(),
                maximum: maximum.to_f64(),
            })
    }

    /// Computes [`Self::slip_for`] with only the largest force as its error, because a control tick
    /// must not compute in double precision.
    pub(super) fn slip_bearing(
        &self,
        footprint: &Footprint<S>,
        pressure: S,
        shift: S,
        force: S,
    ) -> Result<S, S> {
        let area = footprint.width * footprint.length;
        let shifted = area * self.friction * pressure * shift;
        let even = area * self.strength(pressure) - shifted;
        let borne = |u| {
            let [mean, moment] = self.moments_mobilised(u);
            even * mean + (shifted + shifted) * moment
        };
        let most = borne(self.utmost);
        if !(force <= most && -force <= most) {
            return Err(most);
        }
        Ok(odd(force, |size| {
            let u = bisect([S::ZERO, self.utmost], |u| borne(u) < size);
            u / (self.k1 * footprint.length)
        }))
    }
}

/// Applies `function` to the magnitude of `value`, and gives the result the sign of `value`.
fn odd<S: Scalar>(value: S, function: impl Fn(S) -> S) -> S {
    if value < S::ZERO {
        -function(-value)
    } else {
        function(value)
    }
}

/// Finds where `below` stops being true, in 24 halvings (2^-24 of the range).
fn bisect<S: Scalar>([mut low, mut high]: [S; 2], below: impl Fn(S) -> bool) -> S {
    for _ in 0..24 {
        let middle = (low + high) * S::from_f64(0.5);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low + high) * S::from_f64(0.5)
}

/// Number of terms of the series below.
const TERMS: usize = 10;

/// `(-1)^n / (n + 2)!`, and the same times `(n + 2) / (n + 3)`. A table, because a control tick
/// must not divide in double precision.
const FACTORS: [[f64; 2]; TERMS] = {
    let mut table = [[0.0; 2]; TERMS];
    let (mut n, mut factor) = (0, 0.5);
    while n < TERMS {
        let next = (n + 3) as f64;
        table[n] = [factor, factor * (next - 1.0) / next];
        factor /= -next;
        n += 1;
    }
    table
};

/// Mean of `x e^-(a x)` for `x` from 0 to 1.
fn decaying_distance<S: Scalar>(a: S) -> S {
    if a >= S::from_f64(0.25) {
        return (mean_decay(a) - (S::ONE - rise(a))) / a;
    }
    (0..TERMS).rev().fold(S::ZERO, |rest, n| {
        S::from_f64(RECIPROCALS[n + 1]) - a * S::from_f64(RECIPROCALS[n]) * rest
    })
}

/// The two divided differences of [`Soil::moments_mobilised`] for `0 <= a <= b < 0.25`. They are
/// `sum over n of (-1)^n h_n(a, b) / (n + 2)!`, in the second times `(n + 2) / (n + 3)`, with `h_n`
/// the sum of all products of `n` factors `a` or `b`.
fn series<S: Scalar>(a: S, b: S) -> [S; 2] {
    let (mut products, mut power) = (S::ONE, S::ONE);
    let (mut mean, mut moment) = (S::ZERO, S::ZERO);
    for [of_mean, of_moment] in FACTORS {
        mean += S::from_f64(of_mean) * products;
        moment += S::from_f64(of_moment) * products;
        power = power * b;
        products = a * products + power;
    }
    [mean, moment]
}

/// `acosh(x) / sqrt(x^2 - 1)` for `x` from 1 on; 1 at `x = 1`.
///
/// Halves the argument until a short series of the inverse hyperbolic tangent is exact enough:
/// `a = 2 atanh(sqrt((x - 1) / (x + 1)))`.
fn arc_hyperbolic_cosine_over_root(x: f64) -> f64 {
    let mut excess = x - 1.0;
    // `sinh(2 a) = 2 sinh(a) cosh(a)`: each halving divides the quotient by a hyperbolic cosine.
    // The product keeps the quotient free of 0 / 0.
    let mut quotient = 1.0;
    while excess > 1e-2 {
        let cosine = Scalar::sqrt(1.0 + 0.5 * excess);
        excess = 0.5 * excess / (cosine + 1.0);
        quotient /= cosine;
    }
    let square = excess / (excess + 2.0);
    let mut sum = 0.0;
    for term in (0..10).rev() {
        sum = sum * square + 1.0 / f64::from(2 * term + 1);
    }
    // At the reduced argument: a = 2 t sum with t = tanh(a / 2), and sinh a = 2 t / (1 - t^2).
    quotient * sum * (1.0 - square)
}
