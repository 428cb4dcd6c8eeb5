//! Parameters of the crawler and its ground: the paper's values, and values that the paper does not
//! give, each marked as assumed.

/// Why values do not describe a robot or its ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ParametersError {
    /// A value is outside its range or NaN.
    OutOfRange {
        /// Name of the value.
        name: &'static str,
        /// Value that was given.
        got: f64,
        /// Smallest value that is accepted.
        minimum: f64,
        /// Largest value that is accepted.
        maximum: f64,
    },
    /// The ground cannot carry the force at any slip.
    BeyondTraction {
        /// The force, N.
        got: f64,
        /// Largest force that the ground carries, N.
        maximum: f64,
    },
}

/// Checks that `minimum <= got <= maximum`; NaN is out of range.
pub(super) fn within(
    name: &'static str,
    got: f64,
    [minimum, maximum]: [f64; 2],
) -> Result<f64, ParametersError> {
    if got >= minimum && got <= maximum {
        Ok(got)
    } else {
        Err(ParametersError::OutOfRange {
            name,
            got,
            minimum,
            maximum,
        })
    }
}

/// Lengths of the robot, m, and its gear ratio.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Dimensions {
    /// Radius `r` of the driving wheel, belt included.
    pub sprocket_radius: f64,
    /// Distance `H` between the middles of the tracks.
    pub track_spacing: f64,
    /// Length `L` of the run that lies on the ground.
    pub contact_length: f64,
    /// Width `b` of a track. Assumed: the paper's eq. 4 names it without a value.
    pub track_width: f64,
    /// Turns of the motor per turn of the driving wheel: bevel gear 25:8, planetary gear 16:1,
    /// reduction gear 10:7, together 500:7.
    pub gear_ratio: f64,
}

/// Dimensions of the paper's robot (section 3).
pub const DIMENSIONS: Dimensions = Dimensions {
    sprocket_radius: 0.027_94,
    track_spacing: 0.145,
    contact_length: 0.127,
    track_width: 0.04,
    gear_ratio: 25.0 / 8.0 * 16.0 * 10.0 / 7.0,
};

/// Number of grousers (the paper's "clutches") of the run on the ground in the paper's example.
pub const GROUSERS: u32 = 8;
/// Distance by which each grouser shears the ground in the paper's example, m.
pub const GROUSER_DEFORMATION: f64 = 0.002;
/// Slope of the paper's simulation, rad.
pub const SLOPE: f64 = 20.0 * core::f64::consts::PI / 180.0;
/// Speed of the paper's simulation, m/s.
pub const SPEED: f64 = 0.15;

/// Mass of the robot and its centre of gravity.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Masses {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity from the middle between the runs on the ground: forward, left, up, m.
    pub cog: [f64; 3],
}

/// Masses of a compact robot with its batteries between the tracks. All assumed: the paper has no
/// masses.
pub const MASSES: Masses = Masses {
    mass: 5.0,
    cog: [0.0, 0.0, 0.045],
};

impl Masses {
    /// Masses of the robot with a load of `mass` (kg) at `place` (as [`Masses::cog`]).
    #[must_use]
    pub fn loaded(&self, mass: f64, place: [f64; 3]) -> Self {
        let sum = self.mass + mass;
        Self {
            mass: sum,
            cog: [0, 1, 2].map(|i: usize| (self.mass * self.cog[i] + mass * place[i]) / sum),
        }
    }

    /// Checks the ranges, and converts mass and centre of gravity to single precision.
    ///
    /// # Errors
    /// A mass outside 10 g to 1 t, a coordinate beyond 10 m.
    pub(super) fn checked(&self) -> Result<(f32, [f32; 3]), ParametersError> {
        let mass = within("mass", self.mass, [1e-2, 1e3])?;
        for coordinate in self.cog {
            within("centre of gravity", coordinate, [-10.0, 10.0])?;
        }
        Ok((mass as f32, self.cog.map(|coordinate| coordinate as f32)))
    }
}

/// Ground that shears under the tracks (eq. 5 and 6).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ground {
    /// Cohesion `c`, Pa; the paper calls it density.
    pub cohesion: f64,
    /// Angle `rho` of internal friction, rad.
    pub friction_angle: f64,
    /// `K1`: how fast the stress rises with the deformation, 1/m.
    pub k1: f64,
    /// `K2`: shape of the curve; the larger, the flatter it is after its peak.
    pub k2: f64,
}

/// Loose soil. Assumed, with a `K1` at which [`MASSES`] on the paper's slope slips by 0.110, as the
/// paper's grousers do.
pub const GROUND: Ground = Ground {
    cohesion: 1_000.0,
    friction_angle: 25.0 * core::f64::consts::PI / 180.0,
    k1: 40.2,
    k2: 1.0,
};
