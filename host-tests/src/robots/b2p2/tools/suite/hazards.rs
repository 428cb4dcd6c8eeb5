//! Families of hazards: runs in which B2P2 topples unless the guard intervenes.

use super::family::{fold_behind, load, mass, near, stairs, straighten_to};
use super::manoeuvres;
use crate::scenario::Description;
use crate::tools::suite::draw::Family;
use crate::tools::suite::draw::generator::Random;
use crate::world::terrain::Terrain;

/// The families; a run's number selects one of them by its position.
pub(super) const FAMILIES: &[Family] = &[
    ("front kept up at the first nose", front_kept_up),
    ("payload", payload),
    ("raised body", raised_body),
    ("riser too high", high_riser),
    ("too fast", too_fast),
    ("curb with the front up", curb_front_up),
    ("front raised on a side slope", raised_on_side_slope),
    ("front up on a steep ramp", steep_ramp),
    ("folded too early", folded_too_early),
    ("driving backward", manoeuvres::backward),
    ("nose down with the front raised", manoeuvres::nose_down),
    ("front folded down on stairs", manoeuvres::folded_on_stairs),
    ("spinning", manoeuvres::spinning),
    ("guard restart", manoeuvres::guard_restart),
    ("reset on stairs", manoeuvres::reset_on_stairs),
];

fn front_kept_up(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.17);
    drawn.terrain = stairs(random, riser, 3, false);
    let kept = if random.coin() {
        drawn.operator.chassis_deg = random.between(40.0, 65.0);
        drawn.operator.chassis_deg
    } else {
        let kept = random.between(18.0, 38.0);
        drawn.operator.events.push(straighten_to(kept));
        kept
    };
    let speed = drawn.operator.speed_mps;
    drawn.about = format!("{kept} degrees, riser {riser} m, {speed} m/s");
}

fn payload(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    let load = load(random, 1.0, 4.0);
    drawn.about = format!(
        "{} kg at {:?} m, riser {riser} m, {} m/s",
        load.mass_kg, load.place_m, drawn.operator.speed_mps
    );
    drawn.robot.b2p2_mut().payload = Some(load);
    drawn.operator.events.push(straighten_to(0.0));
}

fn raised_body(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.robot.b2p2_mut().com_offset_m = random.between(0.03, 0.08);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!(
        "{} m higher, riser {riser} m, {} m/s",
        drawn.robot.b2p2_mut().com_offset_m,
        drawn.operator.speed_mps
    );
}

fn high_riser(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.168, 0.2);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!("{riser} m, {} m/s", drawn.operator.speed_mps);
}

fn too_fast(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.speed_mps = random.between(0.3, 0.5);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!("{} m/s, riser {riser} m", drawn.operator.speed_mps);
}

fn curb_front_up(random: &mut Random, drawn: &mut Description) {
    let height_m = random.between(0.15, 0.3);
    drawn.terrain = Terrain::Curb {
        height_m,
        // Far enough away that the front can rise without touching the face. If the face catches
        // the front, the rear rises instead.
        nose_m: near(random) + 0.1,
        depth_m: 6.0,
    };
    drawn.operator.chassis_deg = random.between(45.0, 75.0);
    drawn.about = format!(
        "{height_m} m, {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn raised_on_side_slope(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let side = if loaded {
        random.between(48.0, 55.0)
    } else {
        random.between(57.0, 62.0)
    };
    drawn.robot.b2p2_mut().payload = loaded.then(|| load(random, 1.5, 4.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Slope {
        angle_deg: 0.0,
        side_deg: random.sign() * side,
    };
    drawn.operator.speed_mps = 0.0;
    drawn.operator.chassis_deg = random.between(85.0, 99.0);
    let mass = mass(drawn.robot.b2p2_mut());
    drawn.about = format!(
        "{side} degrees, to {} degrees, {mass} kg",
        drawn.operator.chassis_deg
    );
}

fn steep_ramp(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let angle = if loaded {
        random.between(50.0, 57.0)
    } else {
        random.between(58.0, 64.0)
    };
    drawn.robot.b2p2_mut().payload = loaded.then(|| load(random, 1.5, 4.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Ramp {
        angle_deg: angle,
        foot_m: near(random),
        length_m: 4.0,
    };
    drawn.duration_s = 18.0;
    drawn.operator.chassis_deg = random.between(75.0, 95.0);
    let mass = mass(drawn.robot.b2p2_mut());
    drawn.about = format!(
        "{angle} degrees, front at {} degrees, {mass} kg, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn folded_too_early(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.145, 0.155);
    drawn.terrain = stairs(random, riser, 2, false);
    let early = random.between(0.15, 0.32);
    drawn.operator.speed_mps = random.between(0.1, 0.15);
    drawn.operator.events.push(straighten_to(0.0));
    drawn
        .operator
        .events
        .extend(fold_behind(riser, 2, -early, random.between(-50.0, -35.0)));
    drawn.about = format!(
        "by {early} m, riser {riser} m, {} m/s",
        drawn.operator.speed_mps
    );
}
