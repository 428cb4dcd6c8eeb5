//! Says by statics whether a drawn obstacle can be cleared.

use super::draw::{Kind, Obstacle};
use crate::robots::Robot;
use crate::robots::payload::Payload;
use tautrack::robots::b2p2::Model;
use tautrack::robots::b2p2::clearance::Straight;
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// Margin, mm, that a difference of 1 in the coefficient of friction counts as.
const FRICTION_MM: f64 = 100.0;

/// The straight robot of a scenario.
pub fn straight(robot: &Robot) -> Straight<f64> {
    let mut settings = Settings::default();
    let mut length = 0.0;
    let mut radius = 0.0;
    if let Robot::B2p2(section) = robot {
        let micro = |metres: f64| (metres * 1e6).round() as i32;
        length = 0.5 * (section.k_m + 0.32);
        radius = section.pulley_radius_m;
        let values = [
            (Setting::PulleyRadius, micro(radius)),
            (Setting::LengthK, micro(section.k_m)),
            (Setting::BodyHeight, micro(section.com_offset_m)),
        ];
        let load = section.payload.iter().flat_map(Payload::settings);
        for (setting, value) in values.into_iter().chain(load) {
            let _ = settings.set(setting.description().key, value);
        }
    }
    let shape = Model::new(&settings).shape(Angle::ZERO, (length - 0.32 - 0.23) as f32);
    Straight {
        cog: [f64::from(shape.cog[0]), f64::from(shape.cog[2])],
        length,
        pulley_radius: radius,
    }
}

/// Margin with which the robot clears the obstacle, mm.
pub fn margin_mm(obstacle: &Obstacle, robot: &Robot) -> f64 {
    let straight = straight(robot);
    let Obstacle {
        riser_m,
        run_m,
        friction,
        ..
    } = *obstacle;
    let holds = |angle: f64| FRICTION_MM * (friction - libm::tan(angle));
    match obstacle.kind {
        Kind::StairsUp => 1e3 * straight.stairs(riser_m, run_m, friction).margin,
        Kind::CurbUp => 1e3 * straight.curb(riser_m, friction).margin,
        Kind::StairsDown => holds(libm::atan2(riser_m, run_m)),
        Kind::CurbDown => {
            let reach = straight.length - straight.cog[0];
            holds(libm::asin((riser_m / reach).min(1.0)))
        }
        Kind::Ramp => holds(obstacle.angle_deg.to_radians()),
    }
}
