//! Computes the robot's motion from the rates of the sprockets, and back, with a separate slip of
//! each track.

use super::parameters::{Dimensions, ParametersError, within};
use crate::math::Scalar;

/// Velocity of a point of the belt over ground, m/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointVelocity<S> {
    /// Along the drift, `V_by`.
    pub along: S,
    /// Across it, `V_bz`.
    pub across: S,
    /// Its magnitude `V_b`.
    pub speed: S,
}

/// Velocity of a point of a belt (Kurc and Szybicki, eq. 1 to 3). The belt runs at `relative`
/// (`V_t`) around a track that drifts at `drift` (`V_u`), m/s, with `angle` (`phi`, rad) between
/// the two.
///
/// On the run that lies on the ground the angle is half a turn: without slip the two speeds are
/// equal, and the point is at rest.
pub fn track_point_velocity<S: Scalar>(drift: S, relative: S, angle: S) -> PointVelocity<S> {
    let (sine, cosine) = angle.sin_cos();
    let (along, across) = (drift + relative * cosine, relative * sine);
    PointVelocity {
        along,
        across,
        // The paper's V_u^2 + V_t^2 + 2 V_u V_t cos phi, in a form that rounding cannot make
        // negative.
        speed: (along * along + across * across).sqrt(),
    }
}

/// Slip `s_b = (n - 1) dl' / L` of a run of length `contact_length` (m, above zero) on which each
/// of `grousers` grousers shears the ground by `deformation`, m.
///
/// The paper writes this formula into eq. 12; its eq. 7 refers to others by mistake. The
/// deformation adds up to `(n - 1) dl'` at the end of the run.
pub fn slip_from_grousers<S: Scalar>(grousers: u32, deformation: S, contact_length: S) -> S {
    S::from_f64(f64::from(grousers) - 1.0) * deformation / contact_length
}

/// Motion of the robot over the ground, along its own axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BodyVelocity<S> {
    /// Forward speed of the point C between the tracks, m/s; negative backward.
    pub forward: S,
    /// Yaw rate `d beta / dt`, rad/s; counter-clockwise positive.
    pub yaw_rate: S,
}

/// Rates that move the robot as commanded; left, then right.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Drive<S> {
    /// Rates of the sprockets, rad/s.
    pub sprockets: [S; 2],
    /// Rates of the motors, rad/s.
    pub motors: [S; 2],
    /// Speeds at which the belts skid over the ground, m/s.
    pub skid: [S; 2],
}

/// Kinematics of the crawler.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Kinematics<S> {
    radius: S,
    spacing: S,
    gear_ratio: S,
}

impl<S: Scalar> Kinematics<S> {
    /// Largest slip that [`Self::inverse`] compensates. Beyond it, the belt mainly digs.
    pub const MAXIMUM_SLIP: f64 = 0.95;

    /// Kinematics of a robot with these dimensions.
    ///
    /// # Errors
    /// A radius or spacing outside 1 mm to 10 m, a gear ratio outside 0.001 to 100000.
    pub fn new(dimensions: &Dimensions) -> Result<Self, ParametersError> {
        const LENGTH: [f64; 2] = [1e-3, 10.0];
        let value = |name, got, range| within(name, got, range).map(S::from_f64);
        Ok(Self {
            radius: value("sprocket radius", dimensions.sprocket_radius, LENGTH)?,
            spacing: value("track spacing", dimensions.track_spacing, LENGTH)?,
            gear_ratio: value("gear ratio", dimensions.gear_ratio, [1e-3, 1e5])?,
        })
    }

    /// Radius of the sprockets, m.
    pub fn radius(&self) -> S {
        self.radius
    }

    /// Motion from the rates of the sprockets (rad/s) and the slips of the tracks: eq. 8 to 10
    /// along the robot's own axes.
    pub fn body_velocity(&self, sprockets: [S; 2], slip: [S; 2]) -> BodyVelocity<S> {
        let [left, right] =
            [0, 1].map(|side: usize| self.radius * sprockets[side] * (S::ONE - slip[side]));
        BodyVelocity {
            forward: (left + right) * S::from_f64(0.5),
            yaw_rate: (right - left) / self.spacing,
        }
    }

    /// Velocity of point C over the ground, x and y, m/s, at heading `heading` (`beta`, rad), and
    /// yaw rate, rad/s (eq. 8 to 10).
    pub fn forward(&self, sprockets: [S; 2], slip: [S; 2], heading: S) -> ([S; 2], S) {
        let body = self.body_velocity(sprockets, slip);
        let (sine, cosine) = heading.sin_cos();
        ([body.forward * cosine, body.forward * sine], body.yaw_rate)
    }

    /// Rates that move the robot at `velocity` with the slips `slip` of the left and the right
    /// track (eq. 11 to 15).
    ///
    /// Corrections to the paper: eq. 11 takes the magnitude of the speed and so could never drive
    /// backward; here the speed is signed. Eq. 12 and 13 equate the sprocket's rate with the
    /// motor's; here the two differ by the gear ratio, and each track has its own slip in both.
    ///
    /// # Errors
    /// A slip that is NaN or beyond +-[`Self::MAXIMUM_SLIP`].
    pub fn inverse(
        &self,
        velocity: BodyVelocity<S>,
        slip: [S; 2],
    ) -> Result<Drive<S>, ParametersError> {
        let range = [-Self::MAXIMUM_SLIP, Self::MAXIMUM_SLIP];
        for got in slip {
            within("slip", got.to_f64(), range)?;
        }
        Ok(self.drive(velocity, slip))
    }

    /// Computes [`Self::inverse`] for slips that are known to be within its bounds.
    pub fn drive(&self, velocity: BodyVelocity<S>, slip: [S; 2]) -> Drive<S> {
        let half = velocity.yaw_rate * self.spacing * S::from_f64(0.5);
        let ground = [velocity.forward - half, velocity.forward + half];
        let sprockets =
            [0, 1].map(|side: usize| ground[side] / (self.radius * (S::ONE - slip[side])));
        Drive {
            sprockets,
            motors: sprockets.map(|rate| self.gear_ratio * rate),
            skid: [0, 1].map(|side: usize| self.radius * sprockets[side] * slip[side]),
        }
    }
}
