//! Reads the masses of B2P2's bodies and of its payload, and their positions, from the settings.
//!
//! The defaults are the paper's ([`super::parameters::SEGMENTS`]), except for the height of body 1.

use crate::settings::{Setting, Settings};

/// A mass and its position, kg and m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointMass {
    /// Mass, kg.
    pub mass: f32,
    /// Position forward, left and up, m.
    pub place: [f32; 3],
}

/// Masses of the robot's bodies and of its payload.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Masses {
    /// Body 1, from axle 1 along its own axes. It carries the batteries, whose place the paper does
    /// not give; [`Setting::BodyHeight`] replaces the tabulated height of 34.997 mm.
    pub body_1: PointMass,
    /// Body 2, from axle 2 along the front part.
    pub body_2: PointMass,
    /// Body 3, from its rear end along the front part.
    pub body_3: PointMass,
    /// Declared payload, from axle 1 along body 1.
    pub payload: PointMass,
    /// Moments of inertia of bodies 2 and 3 about their centres of mass, about the robot's
    /// transverse axis, kg m^2.
    pub inertia: [f32; 2],
}

impl Masses {
    /// Reads the masses from these settings. Every body has at least 1 g.
    ///
    /// Masses and places of the bodies are the nearest `f32` to the decimal number. The payload is
    /// scaled like every other setting of the guard.
    pub fn new(settings: &Settings) -> Self {
        let nearest = |setting| settings.si_f64(setting) as f32;
        let body = |mass, place: [Setting; 3]| PointMass {
            mass: nearest(mass),
            place: place.map(nearest),
        };
        let [forward, left] = [Setting::Body1Forward, Setting::Body1Left].map(nearest);
        let payload = [
            Setting::PayloadForward,
            Setting::PayloadLeft,
            Setting::PayloadUp,
        ];
        let (second, third) = (
            [Setting::Body2Forward, Setting::Body2Left, Setting::Body2Up],
            [Setting::Body3Forward, Setting::Body3Left, Setting::Body3Up],
        );
        Self {
            body_1: PointMass {
                mass: nearest(Setting::Body1Mass),
                place: [forward, left, settings.si(Setting::BodyHeight)],
            },
            body_2: body(Setting::Body2Mass, second),
            body_3: body(Setting::Body3Mass, third),
            payload: PointMass {
                mass: settings.si(Setting::PayloadMass),
                place: payload.map(|setting| settings.si(setting)),
            },
            inertia: [Setting::Body2Inertia, Setting::Body3Inertia].map(nearest),
        }
    }

    /// Mass of the robot without its payload, kg.
    pub fn of_robot(&self) -> f32 {
        self.body_1.mass + self.body_2.mass + self.body_3.mass
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::SEGMENTS;
    use super::*;

    /// Converts the table's columns from the axes of its frames: R6 is forward, up, right; R7 is
    /// up, backward, right; R8 is up, right, forward.
    #[test]
    fn the_default_masses_are_the_papers() {
        let found = Masses::new(&Settings::default());
        let [first, second, third] = SEGMENTS.map(|segment| segment.centre_of_mass);
        let places = [
            [first[0], -first[2], 0.0],
            [-second[1], -second[2], second[0]],
            [third[2], -third[1], third[0]],
        ];
        let bodies = [found.body_1, found.body_2, found.body_3];
        for ((body, segment), place) in bodies.iter().zip(&SEGMENTS).zip(places) {
            assert_eq!(body.mass, segment.mass as f32);
            assert_eq!(body.place, place.map(|coordinate| coordinate as f32));
        }
        // Parallel axes: the table's moments are about the origins of R7 (its z) and R8 (its y).
        let moments = [
            SEGMENTS[1].inertia_about_origin[2][2]
                - SEGMENTS[1].mass * (second[0] * second[0] + second[1] * second[1]),
            SEGMENTS[2].inertia_about_origin[1][1]
                - SEGMENTS[2].mass * (third[0] * third[0] + third[2] * third[2]),
        ];
        for (inertia, expected) in found.inertia.iter().zip(moments) {
            assert!((f64::from(*inertia) - expected).abs() < 1e-9, "{inertia}");
        }
        assert_eq!(found.payload.mass, 0.0);
    }
}
