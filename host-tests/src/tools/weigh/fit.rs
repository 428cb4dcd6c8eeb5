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
/// Steps of the iteration. The places times the masses make the equations slightly nonlinear.
const STEPS: usize = 20;

/// Masses and places with their uncertainty.
pub(super) struct Fit {
    /// Present values, and their standard deviations.
    pub before: [Masses; 2],
    pub masses: Masses,
    covariance: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub residuals: Vec<Residual>,
    pub cog: Vec<Cog>,
}

/// One comparison of readings with what the masses give, kg.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    pub name: String,
    pub read: f64,
    pub fitted: f64,
    /// Standard deviation of the reading.
    pub deviation: f64,
}

/// Centre of gravity at a chassis angle: its place (m), and the standard deviation of the place
/// (m).
pub(super) struct Cog {
    pub joint_degrees: f64,
    pub place: [f64; 3],
    pub deviation: f64,
}

struct Row {
    name: String,
    read: f64,
    shown: Quantity,
    deviation: f64,
}

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
        for _ in 0..STEPS {
            let mut information = SMatrix::from_diagonal(&prior);
            let mut pull = prior.component_mul(&(before - masses));
            for row in rows(bodies, weighings, &masses)? {
                let weight = row.deviation.powi(-2);
                let gradient = row.shown.gradient;
                information += weight * gradient * gradient.transpose();
                pull += weight * (row.read - row.shown.value) * gradient;
            }
            // Positive definite, because the prior is.
            covariance = information.try_inverse().unwrap_or_default();
            masses += covariance * pull;
        }
        let residuals = rows(bodies, weighings, &masses)?;
        let residuals = residuals.into_iter().map(|row| Residual {
            name: row.name,
            read: row.read,
            fitted: row.shown.value,
            deviation: row.deviation,
        });
        let mut fit = Self {
            before: [before, deviations],
            masses,
            covariance,
            residuals: residuals.collect(),
            cog: Vec::new(),
        };
        for joint_degrees in [-60.0, -30.0, 0.0, 30.0, 60.0] {
            let cog = bodies.cog(f64::to_radians(joint_degrees), &masses)?;
            let variance = |axis: &Quantity| {
                let gradient = axis.gradient;
                (gradient.transpose() * covariance * gradient)[0]
            };
            fit.cog.push(Cog {
                joint_degrees,
                place: cog.map(|axis| axis.value),
                deviation: cog.iter().map(variance).sum::<f64>().sqrt(),
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
    /// The reading that contradicts the others most, or the first setting that is out of bounds.
    pub fn settings(&self) -> Result<Vec<(Setting, i32)>, String> {
        let off =
            |residual: &Residual| (residual.read - residual.fitted).abs() / residual.deviation;
        let worst = self
            .residuals
            .iter()
            .max_by(|one, other| off(one).total_cmp(&off(other)));
        if let Some(worst) = worst.filter(|worst| !(off(worst) <= CONTRADICTION)) {
            return Err(format!(
                "{}: {:.3} kg was read, {:.3} kg fits the others; that is {:.1} standard \
                 deviations, allowed {CONTRADICTION}",
                worst.name,
                worst.read,
                worst.fitted,
                off(worst)
            ));
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
        let pitched = pitched(weighing, weighings.pitch_error_degrees);
        let pitched = bodies.shown(&pitched, masses).map_err(named)?;
        for (place, (axle, reading)) in axles.into_iter().enumerate() {
            let by_pitch = pitched.axles[place].value - shown.axles[place].value;
            rows.push(Row {
                name: format!("weighing {number}, axle {axle}"),
                read: reading.sum(),
                shown: shown.axles[place],
                deviation: (reading.scales().sqrt() * weighings.scale_error_kg).hypot(by_pitch),
            });
        }
        if let [Some(first), Some(second)] = axles.map(|(_, reading)| reading.left_excess()) {
            rows.push(Row {
                name: format!("weighing {number}, left minus right"),
                read: first + second,
                shown: shown.left_excess,
                deviation: 2.0 * weighings.scale_error_kg,
            });
        }
    }
    Ok(rows)
}

/// The same weighing at a pitch that is larger by one standard deviation.
fn pitched(weighing: &Weighing, degrees: f64) -> Weighing {
    Weighing {
        pitch_degrees: weighing.pitch_degrees + degrees,
        ..weighing.clone()
    }
}
