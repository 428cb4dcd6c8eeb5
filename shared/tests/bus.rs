//! Tests the units of positions and velocities on the bus against double precision.

#[allow(dead_code)] // the models need the joints
#[path = "support/random.rs"]
mod random;

use random::Random;
use std::f64::consts::TAU;
use tautrack::bus::scale::{Scale, Target, UNCONFIGURED};
use tautrack::math::Turns;
use tautrack::settings::SCHEMA_VERSION;
use tautrack::units::Angle;

/// Leads of screws, um per turn: the shortest, that of B2P2, and the longest.
const LEADS_UM: [i32; 3] = [1, 5_000, 499_999];
const TURN: f64 = 4_294_967_296.0;
const METRE: f64 = 16_777_216.0;

/// Random positions on the bus, of every magnitude, with the ends of their range.
fn wires() -> impl Iterator<Item = i32> {
    let mut random = Random(7);
    let drawn = move |step| (random.next() * f64::from(i32::MAX)) as i32 >> (step & 15);
    [i32::MIN, -1, 0, 1, i32::MAX]
        .into_iter()
        .chain((0..200_i32).map(drawn))
}

fn close(got: f32, expected: f64) -> bool {
    (f64::from(got) - expected).abs() <= 4e-7 * expected.abs()
}

#[test]
fn a_position_of_a_turning_axle_is_its_fraction_of_a_turn() {
    for bits in 8..=32 {
        let units = Scale::Turning { bits }.units();
        for wire in wires() {
            let expected = f64::from(wire) / f64::from(bits).exp2() * TAU;
            let got = units.position(wire).radians();
            assert!(close(got, expected), "{bits} {wire}: {got} {expected}");
        }
    }
}

#[test]
fn a_position_of_a_screw_counts_in_24_bits_of_a_metre() {
    let units = Scale::linear(5_000).units();
    for wire in wires() {
        let got = units.position(wire).metres();
        assert!(close(got, f64::from(wire) / METRE), "{wire}: {got}");
    }
}

#[test]
fn a_target_of_a_turning_axle_is_within_one_unit_of_its_angle() {
    for bits in 8..=24 {
        let units = Scale::Turning { bits }.units();
        for wire in wires() {
            let angle = Angle::from_bits(wire);
            let exact = f64::from(wire) / (TURN / f64::from(bits).exp2());
            assert_eq!(
                units.target(Target::Angle(angle)),
                Some(exact.floor() as i32)
            );
            let radians = (f64::from(wire) / TURN * TAU * 3.0) as f32;
            let exact = f64::from(radians) / TAU * f64::from(bits).exp2();
            let got = units.target(Target::Radians(radians)).expect("a target");
            let error = (f64::from(got) - exact).abs();
            assert!(error <= 1.0 + 4e-7 * exact.abs(), "{bits}: {got} {exact}");
        }
    }
}

/// A distance of many turns does not wrap, unlike a position.
#[test]
fn a_distance_of_a_turning_axle_is_exact_in_both_directions() {
    for bits in 8..=32 {
        let scale = Scale::Turning { bits };
        for wire in wires() {
            let distance = i64::from(wire) << 8;
            let exact = (distance as f64 / (TURN / f64::from(bits).exp2())).floor();
            assert_eq!(
                scale.distance_to_bus(Turns::from_bits(distance)) as f64,
                exact,
                "{bits} {wire}"
            );
            let back = scale.distance_from_bus(i64::from(wire));
            assert_eq!(
                back.to_bits() as f64,
                f64::from(wire) * TURN / f64::from(bits).exp2()
            );
        }
    }
}

#[test]
fn a_distance_of_a_screw_is_its_turns_times_the_lead() {
    for lead_um in LEADS_UM {
        let scale = Scale::linear(lead_um);
        let lead = f64::from(lead_um) * 1e-6;
        for wire in wires() {
            let turns = scale.distance_from_bus(i64::from(wire)).to_bits() as f64 / TURN;
            // A shaft reaches 2^15 turns; the next test goes beyond.
            let expected = f64::from(wire) / METRE / lead;
            if expected.abs() > 32_767.0 {
                continue;
            }
            // The turns per travel are rounded down to 16 fraction bits, and the turn to 32.
            let bound =
                f64::from(wire).abs() / METRE * (28.0 - 32.0 - 16.0_f64).exp2() + 1.0 / TURN;
            assert!(
                (turns - expected).abs() <= bound,
                "{lead_um} {wire}: {turns} {expected}"
            );
            let back = scale.distance_to_bus(Turns::from_bits(i64::from(wire) << 8));
            // The lead in 2^-32 m, rounded down.
            let lead = (lead * TURN).floor() / TURN;
            let expected = f64::from(wire) * 256.0 / TURN * lead * METRE;
            let error = expected - back as f64;
            assert!(
                (-1e-6..2.0).contains(&error),
                "{lead_um} {wire}: {back} {expected}"
            );
        }
    }
}

/// No screw is that long, but a client may send anything.
#[test]
fn a_length_beyond_the_reach_of_a_shaft_saturates() {
    for lead_um in LEADS_UM {
        let scale = Scale::linear(lead_um);
        let most = scale.shaft_from_length(i64::MAX).to_bits();
        let least = scale.shaft_from_length(i64::MIN).to_bits();
        // 2^63 in the arithmetic with 16 more fraction bits.
        let exact = 47.0_f64.exp2();
        assert!(
            (most as f64 - exact).abs() < 1e-3 * exact,
            "{lead_um}: {most}"
        );
        assert!(
            (least as f64 + exact).abs() < 1e-3 * exact,
            "{lead_um}: {least}"
        );
    }
}

#[test]
fn velocities_of_a_shaft_are_those_of_the_nut_and_of_the_bus() {
    let turning = Scale::Turning { bits: 16 };
    assert_eq!(turning.shaft_velocity_from_linear(0.1), 0.0);
    assert_eq!(turning.velocity_from_bus(-2_500_000), -2.5);
    for lead_um in LEADS_UM {
        let scale = Scale::linear(lead_um);
        let lead = f64::from(lead_um) * 1e-6;
        for velocity in [-0.3, 1e-4, 0.02_f32] {
            let expected = f64::from(velocity) / lead * TAU;
            let got = scale.shaft_velocity_from_linear(velocity);
            assert!(close(got, expected), "{lead_um}: {got} {expected}");
        }
        for wire in [-3_000_000, 1, 250_000_000] {
            let expected = f64::from(wire) * 1e-9 / lead * TAU;
            let got = scale.velocity_from_bus(wire);
            assert!(close(got, expected), "{lead_um}: {got} {expected}");
        }
    }
}

/// The fraction bits in the low byte, 0x100 for a screw, and bit 15 for a drive without settings.
#[test]
fn the_code_of_a_scale_is_the_documented_one() {
    let version = (SCHEMA_VERSION - 1) << 12;
    for bits in 8..=32 {
        assert_eq!(Scale::Turning { bits }.code(), bits as u16 + version);
    }
    assert_eq!(Scale::linear(5_000).code(), 0x118 + version);
    assert_eq!(UNCONFIGURED, 0x8000);
}
