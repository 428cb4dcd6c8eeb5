//! Tests of the crawler's model against numerical integration, the printed equations and the
//! figures of the paper.

use tautrack::math::exponential::{mean_decay, rise};
use tautrack::robots::crawler::kinematics::{slip_from_grousers, track_point_velocity};
use tautrack::robots::crawler::parameters::{
    DIMENSIONS, GROUND, GROUSER_DEFORMATION, GROUSERS, Ground, MASSES, SLOPE, SPEED,
};
use tautrack::robots::crawler::{BodyVelocity, Footprint, Kinematics, ParametersError, Soil};

/// Returns a random number from 0 to 1.
fn random(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

fn between(state: &mut u64, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * random(state)
}

fn some_ground(state: &mut u64) -> Ground {
    Ground {
        cohesion: between(state, [0.0, 3e4]),
        friction_angle: between(state, [0.1, 0.8]),
        k1: between(state, [20.0, 400.0]),
        // A quarter of the values are at the limit, another quarter just above it.
        k2: match (random(state) * 4.0) as u32 {
            0 => 1.0,
            1 => 1.0 + 1e-6 * random(state),
            _ => between(state, [1.0, 20.0]),
        },
    }
}

/// Eq. 6 as the paper prints it, without its strength; the maximum of the numerator is found by
/// search.
fn printed_share(k2: f64, u: f64) -> f64 {
    if k2 == 1.0 {
        return u * (1.0 - u).exp();
    }
    let root = (k2 * k2 - 1.0).sqrt();
    let numerator = |u: f64| ((-k2 + root) * u).exp() - ((-k2 - root) * u).exp();
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..200 {
        let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if numerator(first) < numerator(second) {
            low = first;
        } else {
            high = second;
        }
    }
    numerator(u) / numerator(low)
}

#[test]
fn decays_are_those_of_the_host_s_library() {
    let (mut worst, mut worst_single) = (0.0f64, 0.0f64);
    for step in 0..400_000 {
        let x = libm::pow(10.0, f64::from(step) / 400_000.0 * 14.0 - 12.0);
        let want = -libm::expm1(-x);
        worst = worst.max((rise(x) / want - 1.0).abs());
        let single = x as f32;
        let want = -libm::expm1(-f64::from(single));
        worst_single = worst_single.max((f64::from(rise(single)) / want - 1.0).abs());
        assert!((mean_decay(x) * x / rise(x) - 1.0).abs() < 1e-15);
    }
    let (ulps, single_ulps) = (worst / f64::EPSILON, worst_single / f64::from(f32::EPSILON));
    println!("{ulps:.2} and {single_ulps:.2} units in the last place");
    assert!(ulps < 2.0 && single_ulps < 2.0);
    assert_eq!((rise(0.0), rise(-3.0), mean_decay(0.0)), (0.0, 0.0, 1.0));
    assert_eq!((rise(f64::INFINITY), rise(1e300)), (1.0, 1.0));
    assert!(rise(f32::NAN).is_nan());
}

#[test]
fn shear_stress_is_the_printed_equation_and_its_limit() {
    let mut state = 1;
    for _ in 0..2_000 {
        let ground = some_ground(&mut state);
        let soil = Soil::<f64>::new(&ground).unwrap();
        let pressure = between(&mut state, [0.0, 6e4]);
        let deformation = between(&mut state, [0.0, 0.1]);
        let strength = ground.cohesion + pressure * ground.friction_angle.tan();
        let want = strength * printed_share(ground.k2, ground.k1 * deformation);
        let got = soil.shear_stress(pressure, deformation);
        // The printed numerator loses the digits in which K2 equals 1.
        let allowed = if ground.k2 < 1.001 { 1e-5 } else { 1e-9 };
        assert!(
            (got - want).abs() <= allowed * strength,
            "{ground:?} {deformation}: {got} {want}"
        );
        assert_eq!(soil.shear_stress(pressure, -deformation), -got);
        assert!(got <= strength * (1.0 + 1e-14));
    }
}

#[test]
fn driving_force_is_the_integral_of_the_shear_stress() {
    let mut state = 2;
    let mut worst = 0.0f64;
    for _ in 0..400 {
        let soil = Soil::<f64>::new(&some_ground(&mut state)).unwrap();
        let footprint = Footprint {
            width: between(&mut state, [0.02, 0.2]),
            length: between(&mut state, [0.05, 0.5]),
        };
        let pressure = between(&mut state, [0.0, 6e4]);
        let slip = between(&mut state, [1e-6, 0.9]);
        // Gauss's rule with three points in 500 intervals; these are shorter where the stress
        // rises: x = L t^4.
        let node = 0.6f64.sqrt();
        let (pieces, mut sum) = (500, 0.0);
        let half = 0.5 / f64::from(pieces);
        for piece in 0..pieces {
            let centre = half * f64::from(2 * piece + 1);
            for (at, weight) in [(-node, 5.0 / 9.0), (0.0, 8.0 / 9.0), (node, 5.0 / 9.0)] {
                let t = centre + at * half;
                let stress = soil.shear_stress(pressure, slip * footprint.length * t.powi(4));
                sum += half * weight * stress * 4.0 * footprint.length * t.powi(3);
            }
        }
        let want = footprint.width * sum;
        let got = soil.driving_force(&footprint, pressure, slip);
        worst = worst.max((got / want - 1.0).abs());
    }
    println!("{worst:.1e} of the force");
    assert!(worst < 1e-11, "{worst:e}");
}

#[test]
fn slip_for_a_force_bears_that_force_and_no_slip_bears_more_than_the_utmost() {
    let mut state = 3;
    for _ in 0..500 {
        let ground = some_ground(&mut state);
        let (soil, single) = (
            Soil::<f64>::new(&ground).unwrap(),
            Soil::<f32>::new(&ground).unwrap(),
        );
        let footprint = Footprint {
            width: 0.04,
            length: 0.127,
        };
        let narrow = Footprint {
            width: 0.04,
            length: 0.127,
        };
        let pressure = between(&mut state, [1e3, 1e4]);
        let utmost = soil.utmost_slip(&footprint);
        let most = soil.driving_force(&footprint, pressure, utmost);
        for step in 1..200 {
            let slip = utmost * f64::from(step) / 50.0;
            assert!(soil.driving_force(&footprint, pressure, slip) <= most * (1.0 + 1e-12));
        }
        let force = most * between(&mut state, [-0.999, 0.999]);
        let slip = soil.slip_for(&footprint, pressure, 0.0, force).unwrap();
        let error = (soil.driving_force(&footprint, pressure, slip) - force).abs();
        assert!(error < 1e-6 * most, "{ground:?}: {error:e} of {most}");
        let coarse = single
            .slip_for(&narrow, pressure as f32, 0.0, force as f32)
            .unwrap();
        // Near the peak the force hardly depends on the slip.
        let steep = force.abs() < 0.9 * most;
        assert!(
            !steep || (f64::from(coarse) - slip).abs() < 2e-5 * utmost,
            "{coarse} {slip}"
        );
        assert!(matches!(
            soil.slip_for(&footprint, pressure, 0.0, -1.001 * most),
            Err(ParametersError::BeyondTraction { .. })
        ));
        assert!(soil.slip_for(&footprint, pressure, 0.0, f64::NAN).is_err());
    }
}

#[test]
fn a_curve_that_the_paper_does_not_cover_is_refused_with_its_bound() {
    let refused = Soil::<f32>::new(&Ground { k2: 0.99, ..GROUND }).unwrap_err();
    let want = ParametersError::OutOfRange {
        name: "K2",
        got: 0.99,
        minimum: 1.0,
        maximum: 100.0,
    };
    assert_eq!(refused, want);
    assert!(Soil::<f32>::new(&Ground { k1: 0.0, ..GROUND }).is_err());
    assert!(
        Soil::<f64>::new(&Ground {
            cohesion: f64::NAN,
            ..GROUND
        })
        .is_err()
    );
    assert!(
        Soil::<f64>::new(&Ground {
            k2: 100.0,
            ..GROUND
        })
        .is_ok()
    );
}

#[test]
fn inverse_kinematics_undo_the_forward_ones_in_both_directions() {
    let kinematics = Kinematics::<f64>::new(&DIMENSIONS).unwrap();
    let mut state = 4;
    for _ in 0..1_000 {
        let velocity = BodyVelocity {
            forward: between(&mut state, [-0.5, 0.5]),
            yaw_rate: between(&mut state, [-2.0, 2.0]),
        };
        let slip = [
            between(&mut state, [-0.3, 0.9]),
            between(&mut state, [-0.3, 0.9]),
        ];
        let heading = between(&mut state, [-3.0, 3.0]);
        let drive = kinematics.inverse(velocity, slip).unwrap();
        let ([x, y], yaw_rate) = kinematics.forward(drive.sprockets, slip, heading);
        let forward = x * heading.cos() + y * heading.sin();
        assert!((forward - velocity.forward).abs() < 1e-14);
        assert!((yaw_rate - velocity.yaw_rate).abs() < 1e-13);
        assert!(
            (y * heading.cos() - x * heading.sin()).abs() < 1e-15,
            "no track moves sideways"
        );
    }
    let slipping = kinematics.inverse(
        BodyVelocity {
            forward: 0.1,
            yaw_rate: 0.0,
        },
        [0.0, 1.0],
    );
    assert!(matches!(
        slipping,
        Err(ParametersError::OutOfRange {
            name: "slip",
            got: 1.0,
            ..
        })
    ));
    assert!(
        Kinematics::<f32>::new(&DIMENSIONS)
            .unwrap()
            .inverse(
                BodyVelocity {
                    forward: 0.1,
                    yaw_rate: 0.0
                },
                [f32::NAN, 0.0]
            )
            .is_err()
    );
}

#[test]
fn figures_of_the_paper_come_out() {
    let kinematics = Kinematics::<f64>::new(&DIMENSIONS).unwrap();
    let slip = slip_from_grousers(GROUSERS, GROUSER_DEFORMATION, DIMENSIONS.contact_length);
    let straight = BodyVelocity {
        forward: SPEED,
        yaw_rate: 0.0,
    };
    let without = kinematics.inverse(straight, [0.0; 2]).unwrap();
    let with = kinematics.inverse(straight, [slip; 2]).unwrap();
    for (got, want, digit) in [
        (DIMENSIONS.gear_ratio, 500.0 / 7.0, 1e-12),
        (slip, 0.110_236, 1e-6),
        (without.sprockets[0], 5.368_65, 1e-5),
        (with.sprockets[1], 6.033_79, 1e-5),
        (without.motors[1], 383.475, 1e-3),
        (with.motors[0], 430.985, 1e-3),
        (with.skid[0], 0.018_584, 1e-6),
        (without.skid[0], 0.0, 1e-15),
    ] {
        assert!((got - want).abs() <= 0.6 * digit, "{got} {want}");
    }
}

/// Without slip, the point of the belt on the ground rests. The point above moves at twice the
/// robot's speed, those at half height at sqrt(2) times this speed.
#[test]
fn a_belt_without_slip_rests_on_the_ground() {
    let at = |angle: f64| track_point_velocity(0.15, 0.15, angle);
    assert!(at(core::f64::consts::PI).speed < 1e-16);
    assert!((at(0.0).speed - 0.3).abs() < 1e-16);
    let side = at(core::f64::consts::FRAC_PI_2);
    assert!((side.speed - 0.15 * 2f64.sqrt()).abs() < 1e-16 && (side.across - 0.15).abs() < 1e-16);
}

/// The force for the slip that was found is summed over 20000 strips, with a pressure that changes
/// linearly along the run.
#[test]
fn slip_under_a_shifted_load_bears_the_force() {
    let mut state = 5;
    let footprint = Footprint {
        width: 0.04,
        length: 0.127,
    };
    let (mut worst, mut tried) = (0.0f64, 0);
    for _ in 0..200 {
        let soil = Soil::<f64>::new(&some_ground(&mut state)).unwrap();
        let pressure = between(&mut state, [1e3, 1e4]);
        let shift = between(&mut state, [-1.0, 1.0]);
        let even = soil.driving_force(&footprint, pressure, soil.utmost_slip(&footprint));
        let force = between(&mut state, [0.1, 0.8]) * even;
        let Ok(slip) = soil.slip_for(&footprint, pressure, shift, force) else {
            continue;
        };
        tried += 1;
        let strips = 20_000;
        let strip = footprint.length / f64::from(strips);
        let borne: f64 = (0..strips)
            .map(|number| {
                let along = (f64::from(number) + 0.5) / f64::from(strips);
                let here = pressure * (1.0 + shift * (2.0 * along - 1.0));
                let stress = soil.shear_stress(here, slip * along * footprint.length);
                stress * footprint.width * strip
            })
            .sum();
        worst = worst.max((borne - force).abs() / even);
    }
    println!("{worst:.1e} of the greatest force, {tried} grounds");
    assert!(worst < 1e-5 && tried > 100, "{worst:e} {tried}");
}

/// With the assumed soil and masses, the slip on the paper's slope is that of the paper.
#[test]
fn assumed_soil_makes_the_robot_slip_as_the_paper_s_grousers_do() {
    let soil = Soil::<f64>::new(&GROUND).unwrap();
    let footprint = Footprint {
        width: DIMENSIONS.track_width,
        length: DIMENSIONS.contact_length,
    };
    let weight = MASSES.mass * 9.81;
    let pressure = 0.5 * weight * SLOPE.cos() / (footprint.width * footprint.length);
    let slip = soil
        .slip_for(&footprint, pressure, 0.0, 0.5 * weight * SLOPE.sin())
        .unwrap();
    println!("slip {slip:.4} on the slope");
    assert!((slip - 0.110_236).abs() < 5e-4, "{slip}");
}
