//! Computes what scales under B2P2's axles show for given masses, by the balance of moments.

use super::weighings::Weighing;
use nalgebra::SVector;
use tautrack::robots::b2p2::model::belt::TautBelt;
use tautrack::robots::b2p2::parameters::LENGTHS;
use tautrack::settings::{Setting, Settings};

/// Mass (kg) and place of the centre of mass forward, left and up (m) of each body: of body 1 from
/// axle 1 along its own axes, of body 2 from axle 2 and of body 3 from its rear end along the front
/// part.
pub(super) type Masses = SVector<f64, UNKNOWNS>;

pub(super) const UNKNOWNS: usize = 12;

/// The setting of each value in [`Masses`]. All count millionths.
pub(super) const SETTINGS: [Setting; UNKNOWNS] = [
    Setting::Body1Mass,
    Setting::Body1Forward,
    Setting::Body1Left,
    Setting::BodyHeight,
    Setting::Body2Mass,
    Setting::Body2Forward,
    Setting::Body2Left,
    Setting::Body2Up,
    Setting::Body3Mass,
    Setting::Body3Forward,
    Setting::Body3Left,
    Setting::Body3Up,
];

/// A quantity and its derivative by each of the masses and places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantity {
    pub value: f64,
    pub gradient: Masses,
}

/// Lengths of the robot, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bodies {
    l1: f64,
    l2: f64,
    k: f64,
    half_gauge: f64,
}

/// What the scales show, kg.
pub(super) struct Shown {
    /// Under each of the two axles.
    pub axles: [Quantity; 2],
    /// How much more the left scales show than the right ones.
    pub left_excess: Quantity,
}

impl Bodies {
    pub fn new(settings: &Settings) -> Self {
        let metres = |setting| f64::from(settings.get(setting)) * 1e-6;
        Self {
            l1: metres(Setting::LengthL1),
            l2: metres(Setting::LengthL2),
            k: metres(Setting::LengthK),
            half_gauge: 0.5 * metres(Setting::TrackGauge),
        }
    }

    /// What the scales show if the masses are `masses`. The tracks do not push along the ground, so
    /// the scales carry the robot by vertical forces below the axles.
    ///
    /// # Errors
    /// If the third axle would be below the two on scales, two axles stand above each other, or the
    /// belt's length fits no screw.
    pub fn shown(&self, weighing: &Weighing, masses: &Masses) -> Result<Shown, String> {
        let pitch = weighing.pitch_degrees.to_radians();
        let theta = weighing.joint_degrees.to_radians();
        let [first, second] = weighing.axles()?.map(|(axle, _)| axle);
        let [mass, forward, left] = self.moments(theta, pitch, masses)?;
        let axle = |number| self.axle(number, theta, pitch);
        let ([near, near_up], [far, far_up]) = (axle(first)?, axle(second)?);
        let base = far - near;
        if base.abs() < 0.02 {
            return Err(format!(
                "axles {first} and {second} are {:.0} mm apart along the ground: allowed 20 mm or \
                 more",
                1e3 * base.abs()
            ));
        }
        let third = 6 - first - second;
        let [along, up] = axle(third)?;
        if up < near_up + (far_up - near_up) * (along - near) / base {
            return Err(format!(
                "axle {third} would be below the line through axles {first} and {second}, which \
                 carry the robot"
            ));
        }
        let front = Quantity {
            value: (forward.value - near * mass.value) / base,
            gradient: (forward.gradient - near * mass.gradient) / base,
        };
        let rear = Quantity {
            value: mass.value - front.value,
            gradient: mass.gradient - front.gradient,
        };
        let left_excess = Quantity {
            value: left.value / self.half_gauge,
            gradient: left.gradient / self.half_gauge,
        };
        Ok(Shown {
            axles: [rear, front],
            left_excess,
        })
    }

    /// Centre of gravity forward, left and up from axle 1, m.
    pub fn cog(&self, theta: f64, masses: &Masses) -> Result<[Quantity; 3], String> {
        let [mass, forward, left] = self.moments(theta, 0.0, masses)?;
        let [_, backward, _] = self.moments(theta, core::f64::consts::FRAC_PI_2, masses)?;
        let up = Quantity {
            value: -backward.value,
            gradient: -backward.gradient,
        };
        Ok([forward, left, up].map(|moment| {
            let value = moment.value / mass.value;
            Quantity {
                value,
                gradient: (moment.gradient - value * mass.gradient) / mass.value,
            }
        }))
    }

    /// Mass (kg), and its moments forward along the ground and to the left (kg m), about axle 1.
    fn moments(&self, theta: f64, pitch: f64, masses: &Masses) -> Result<[Quantity; 3], String> {
        let reach = self.reach(theta)?;
        let slid = reach - LENGTHS.axle_3;
        let hinge = self.l1 * pitch.cos();
        let front = pitch + theta;
        // Place of each body's origin along the ground, and its pitch.
        let poses = [
            (0.0, pitch),
            (hinge, front),
            (hinge + slid * front.cos(), front),
        ];
        let mut sums = [Quantity {
            value: 0.0,
            gradient: Masses::zeros(),
        }; 3];
        for (body, (origin, direction)) in poses.into_iter().enumerate() {
            let at = 4 * body;
            let [m, x, y, z] = [0, 1, 2, 3].map(|offset| masses[at + offset]);
            let (sine, cosine) = direction.sin_cos();
            let place = origin + x * cosine - z * sine;
            let [mass, forward, left] = &mut sums;
            mass.value += m;
            mass.gradient[at] = 1.0;
            forward.value += m * place;
            forward.gradient[at] = place;
            forward.gradient[at + 1] = m * cosine;
            forward.gradient[at + 3] = -m * sine;
            left.value += m * y;
            left.gradient[at] = y;
            left.gradient[at + 2] = m;
        }
        Ok(sums)
    }

    /// Position of an axle forward along the ground and up from axle 1, m.
    fn axle(&self, axle: usize, theta: f64, pitch: f64) -> Result<[f64; 2], String> {
        let hinge = [self.l1 * pitch.cos(), self.l1 * pitch.sin()];
        Ok(match axle {
            1 => [0.0, 0.0],
            2 => hinge,
            _ => {
                let (reach, front) = (self.reach(theta)?, pitch + theta);
                [
                    hinge[0] + reach * front.cos(),
                    hinge[1] + reach * front.sin(),
                ]
            }
        })
    }

    /// Distance of axles 2 and 3 with a taut belt, m.
    fn reach(&self, theta: f64) -> Result<f64, String> {
        let belt = TautBelt::<f64>::new(self.k, self.l1, self.l2)
            .map_err(|short| format!("k = {} m: allowed {} m or more", short.got, short.minimum))?;
        Ok(belt.extension(theta).reach)
    }
}
