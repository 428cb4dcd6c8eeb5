//! Finds the masses that explain the readings best.
//!
//! Least squares with the present settings as one more observation (a Gaussian prior). What the
//! weighings do not show keeps its present value.

use super::bodies::{Bodies, Masses, Quantity, SETTINGS, UNKNOWNS};
use super::weighings::{Weighing, Weighings};
use nalgebra::SMatrix;
use tautrack::settings::{Setting, Settings};

/// Standard deviations of the present settings: of a mass as a part of it, and of a place, m.
const MASS_BEFORE: f64 = 0.5;
const PLACE_BEFORE: f64 = 0.1;
/// Residual above which the readings contradict each other, in standard deviations.
const CONTRADICTION: f64 = 4.0;
/// Largest standard deviation of the centre of gravity, forward and up, m.
const UNCERTAIN: f64 = 0.01;
/// Steps of the iteration. The places times the masses make the equations slightly nonlinear.
const STEPS: usize = 500;
/// Last step with which the iteration has ended, kg and m.
const CONVERGED: f64 = 1e-5;

/// Masses and places with their uncertainty.
pub(super) struct Fit {
    /// Present values, and their standard deviations.
    pub before: [Masses; 2],
    pub masses: Masses,
    covariance: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub residuals: Vec<Residual>,
    pub cog: Vec<Cog>,
    /// Whether the readings show the places to the left.
    pub left_is_measured: bool,
}

/// One comparison of readings with what the masses give, kg.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    pub name: String,
    pub read: f64,
    pub fitted: f64,
    /// Standard deviation of the reading.
    pub deviation: f64,
    /// Standard deviation of the difference, which is smaller, because the masses follow the
    /// reading.
    difference: f64,
}

/// Centre of gravity at a chassis angle: its place (m), and the standard deviation of the place
/// (m).
pub(super) struct Cog {
    pub joint_degrees: f64,
    pub place: [f64; 3],
    pub deviation: [f64; 3],
}

impl Cog {
    /// Standard deviation in the side view, m.
    pub fn in_side_view(&self) -> f64 {
        let [forward, _, up] = self.deviation;
        forward.hypot(up)
    }
}

struct Row {
    name: String,
    read: f64,
    shown: Quantity,
    deviation: f64,
    is_left: bool,
}

const NO_MASSES: &str = "no masses give these readings; check units and signs";

impl Fit {
    /// # Errors
    /// If a posture cannot be weighed: the text names it.
    pub fn new(
        bodies: &Bodies,
        weighings: &Weighings,
        settings: &Settings,
    ) -> Result<Self, String> {
        let value = |setting: Setting| f64::from(settings.get(setting)) * 1e-6;
        let before = Masses::from_iterator(SETTINGS.into_iter().map(value));
        let deviations = Masses::from_fn(|index, _| {
            if index % 4 == 0 {
                MASS_BEFORE * before[index]
            } else {
                PLACE_BEFORE
            }
        });
        let prior = deviations.map(|deviation| deviation.powi(-2));
        let mut masses = before;
        let mut covariance = SMatrix::zeros();
        let mut step = Masses::zeros();
        for _ in 0..STEPS {
            let mut information = SMatrix::from_diagonal(&prior);
            let mut pull = prior.component_mul(&(before - masses));
            for row in rows(bodies, weighings, &masses)? {
                let weight = row.deviation.powi(-2);
                let gradient = row.shown.gradient;
                information += weight * gradient * gradient.transpose();
                pull += weight * (row.read - row.shown.value) * gradient;
            }
            covariance = information.try_inverse().ok_or(NO_MASSES)?;
            step = covariance * pull;
            masses += step;
        }
        if !(step.amax() <= CONVERGED) {
            return Err(NO_MASSES.to_owned());
        }
        let rows = rows(bodies, weighings, &masses)?;
        let variance = |gradient: Masses| (gradient.transpose() * covariance * gradient)[0];
        let left_is_measured = rows.iter().any(|row| row.is_left);
        let residuals = rows.into_iter().map(|row| Residual {
            name: row.name,
            read: row.read,
            fitted: row.shown.value,
            deviation: row.deviation,
            difference: (row.deviation.powi(2) - variance(row.shown.gradient)).sqrt(),
        });
        let mut fit = Self {
            before: [before, deviations],
            masses,
            covariance,
            residuals: residuals.collect(),
            cog: Vec::new(),
            left_is_measured,
        };
        for joint_degrees in [-60.0, -30.0, 0.0, 30.0, 60.0] {
            let cog = bodies.cog(f64::to_radians(joint_degrees), &masses)?;
            fit.cog.push(Cog {
                joint_degrees,
                place: cog.map(|axis| axis.value),
                deviation: cog.map(|axis| variance(axis.gradient).sqrt()),
            });
        }
        Ok(fit)
    }

    /// Standard deviation of each value of [`Self::masses`].
    pub fn deviations(&self) -> Masses {
        self.covariance.diagonal().map(f64::sqrt)
    }

    /// The settings of the masses.
    ///
    /// # Errors
    /// The reading that contradicts the others most, the uncertainty of the centre of gravity, or
    /// the first value that is out of its setting's bounds or far from the one before.
    pub fn settings(&self) -> Result<Vec<(Setting, i32)>, String> {
        let off = |residual: &Residual| {
            (residual.read - residual.fitted).abs() / residual.difference.max(1e-6)
        };
        let worst = self
            .residuals
            .iter()
            .max_by(|one, other| off(one).total_cmp(&off(other)));
        if let Some(worst) = worst.filter(|worst| !(off(worst) <= CONTRADICTION)) {
            return Err(format!(
                "{}: {:.3} kg was read, the masses give {:.3} kg; that is {:.1} standard \
                 deviations, allowed {CONTRADICTION}",
                worst.name,
                worst.read,
                worst.fitted,
                off(worst)
            ));
        }
        if let Some(cog) = self
            .cog
            .iter()
            .find(|cog| !(cog.in_side_view() <= UNCERTAIN))
        {
            return Err(format!(
                "the centre of gravity at a chassis angle of {} degrees has a standard deviation \
                 of {:.1} mm, allowed {:.0} mm: weigh at more chassis angles and pitches",
                cog.joint_degrees,
                1e3 * cog.in_side_view(),
                1e3 * UNCERTAIN
            ));
        }
        let [before, deviations] = &self.before;
        for (index, setting) in SETTINGS.into_iter().enumerate() {
            let change = self.masses[index] - before[index];
            if !(change.abs() <= deviations[index]) {
                let row = setting.description();
                return Err(format!(
                    "{} changes by {:.0} {unit}, allowed {:.0} {unit}: check the signs of the \
                     angles; if it is right, set a value nearby first",
                    row.name,
                    1e6 * change,
                    1e6 * deviations[index],
                    unit = row.unit
                ));
            }
        }
        let setting = |(setting, value): (Setting, &f64)| {
            let row = setting.description();
            let counts = (value * 1e6).round();
            let (minimum, maximum) = (row.minimum, row.maximum);
            if !(f64::from(minimum)..=f64::from(maximum)).contains(&counts) {
                let (name, unit) = (row.name, row.unit);
                return Err(format!(
                    "{name} = {counts} {unit}: allowed {minimum} to {maximum}"
                ));
            }
            Ok((setting, counts as i32))
        };
        SETTINGS
            .into_iter()
            .zip(&self.masses)
            .map(setting)
            .collect()
    }
}

/// What was read, beside what `masses` give.
fn rows(bodies: &Bodies, weighings: &Weighings, masses: &Masses) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (index, weighing) in weighings.weighing.iter().enumerate() {
        let number = index + 1;
        let named = |why: String| format!("weighing {number}: {why}");
        let axles = weighing.axles().map_err(named)?;
        let shown = bodies.shown(weighing, masses).map_err(named)?;
        let turned = [
            Weighing {
                pitch_degrees: weighing.pitch_degrees + weighings.pitch_error_degrees,
                ..weighing.clone()
            },
            Weighing {
                joint_degrees: weighing.joint_degrees + weighings.joint_error_degrees,
                ..weighing.clone()
            },
        ];
        let [pitched, bent] = turned.map(|weighing| bodies.shown(&weighing, masses));
        let (pitched, bent) = (pitched.map_err(named)?, bent.map_err(named)?);
        for (place, (axle, reading)) in axles.into_iter().enumerate() {
            let [by_pitch, by_joint] =
                [&pitched, &bent].map(|other| other.axles[place].value - shown.axles[place].value);
            rows.push(Row {
                name: format!("weighing {number}, axle {axle}"),
                read: reading.sum(),
                shown: shown.axles[place],
                deviation: (reading.scales().sqrt() * weighings.scale_error_kg)
                    .hypot(by_pitch)
                    .hypot(by_joint),
                is_left: false,
            });
        }
        if let [Some(first), Some(second)] = axles.map(|(_, reading)| reading.left_excess()) {
            rows.push(Row {
                name: format!("weighing {number}, left minus right"),
                read: first + second,
                shown: shown.left_excess,
                deviation: 2.0 * weighings.scale_error_kg,
                is_left: true,
            });
        }
    }
    Ok(rows)
}
