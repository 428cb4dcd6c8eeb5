//! Families of legitimate runs, in which the guard must not hinder the operator.

use super::family::{fold_behind, load, near, stairs, stop_after, straighten_to, when};
use crate::scenario::{Description, Event};
use crate::tools::suite::draw::Family;
use crate::tools::suite::draw::generator::Random;
use crate::world::terrain::Terrain;

/// The families; a run's number selects one of them by its position.
pub(super) const FAMILIES: &[Family] = &[
    ("two steps", two_steps),
    ("low curb", low_curb),
    ("flat ground", flat_ground),
    ("side slope", side_slope),
    ("ramp", ramp),
    ("descent", descent),
    ("small load", small_load),
];

fn two_steps(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.1, 0.15);
    drawn.terrain = stairs(random, riser, 2, false);
    drawn.operator.speed_mps = random.between(0.1, 0.15);
    drawn.operator.chassis_deg = random.between(35.0, 50.0);
    drawn.operator.events.push(straighten_to(0.0));
    let folds = random.coin();
    if folds {
        let fold = fold_behind(riser, 2, random.between(0.02, 0.08), -25.0);
        drawn.operator.events.extend(fold);
    }
    let how = if folds { "folded" } else { "straight" };
    drawn.about = format!("riser {riser} m, {how}, {} m/s", drawn.operator.speed_mps);
}

fn low_curb(random: &mut Random, drawn: &mut Description) {
    let height_m = random.between(0.03, 0.1);
    drawn.terrain = Terrain::Curb {
        height_m,
        nose_m: near(random),
        depth_m: 6.0,
    };
    drawn.operator.chassis_deg = random.between(20.0, 45.0);
    drawn.operator.events = vec![straighten_to(0.0), stop_after(0.6)];
    drawn.about = format!("{height_m} m, {} m/s", drawn.operator.speed_mps);
}

fn flat_ground(random: &mut Random, drawn: &mut Description) {
    drawn.duration_s = 10.0;
    drawn.operator.speed_mps = random.between(-0.3, 0.4);
    drawn.operator.chassis_deg = random.between(-20.0, 60.0);
    let yaw_rate = random.between(-25.0, 25.0);
    drawn.operator.events = vec![Event {
        when: when(|when| when.after_s = Some(3.0)),
        chassis_deg: Some(random.between(-20.0, 60.0)),
        yaw_rate_deg_s: Some(yaw_rate),
        ..Event::default()
    }];
    drawn.about = format!("{} m/s, {yaw_rate} degrees/s", drawn.operator.speed_mps);
}

fn side_slope(random: &mut Random, drawn: &mut Description) {
    drawn.duration_s = 8.0;
    // The higher the front, the smaller the slope.
    let chassis = random.between(0.0, 60.0);
    let side = random.sign() * random.between(5.0, 30.0 - 0.25 * chassis);
    drawn.terrain = Terrain::Slope {
        angle_deg: random.between(-8.0, 8.0),
        side_deg: side,
    };
    drawn.operator.chassis_deg = chassis;
    drawn.about = format!(
        "{side} degrees, front at {chassis} degrees, {} m/s",
        drawn.operator.speed_mps
    );
}

fn ramp(random: &mut Random, drawn: &mut Description) {
    let angle_deg = random.between(5.0, 28.0);
    drawn.terrain = Terrain::Ramp {
        angle_deg,
        foot_m: near(random),
        length_m: random.between(0.4, 1.0),
    };
    drawn.operator.chassis_deg = random.between(0.0, 30.0);
    drawn.operator.speed_mps = random.between(0.12, 0.25);
    drawn.about = format!(
        "{angle_deg} degrees, front at {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn descent(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.06, 0.15);
    let count = if random.coin() { 1 } else { 2 };
    drawn.terrain = stairs(random, riser, count, true);
    drawn.operator.speed_mps = random.between(0.1, 0.18);
    drawn.operator.chassis_deg = random.between(-12.0, 0.0);
    drawn.operator.events = vec![Event {
        when: when(|when| when.pitch_below_deg = Some(-8.0)),
        chassis_deg: Some(0.0),
        ..Event::default()
    }];
    drawn.about = format!(
        "{count} of {riser} m, front at {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn small_load(random: &mut Random, drawn: &mut Description) {
    let mut load = load(random, 0.1, 0.5);
    load.declared = random.coin();
    let riser = random.between(0.1, 0.14);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!(
        "{} kg, declared {}, riser {riser} m, {} m/s",
        load.mass_kg, load.declared, drawn.operator.speed_mps
    );
    drawn.robot.b2p2_mut().payload = Some(load);
}
