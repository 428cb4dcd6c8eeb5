//! Tests B2P2's zero moment point against statics and against the paper's printed form, and where
//! there is none.

use crate::random::Random;
use tautrack::math::vector::dot;
use tautrack::robots::b2p2::{Parameters, Posture};
use tautrack::stability::zmp::{Plane, ZeroMomentPoint, printed, zero_moment_point};

fn near(got: f64, want: f64, allowed: f64, what: &str) {
    assert!((got - want).abs() <= allowed, "{what}: {got} {want}");
}

#[test]
fn a_robot_at_rest_has_its_zero_moment_point_below_its_cog() {
    let mut random = Random(8);
    let parameters = Parameters::paper();
    for _ in 0..100 {
        let posture = Posture::new(&parameters, &random.q());
        let reaction = posture.newton_euler(&[0.0; 8], &[0.0; 8]).reaction;
        let plane = Plane {
            point: [0.1, -0.3, 0.2],
            normal: [0.3, -0.2, 0.8],
        };
        let ZeroMomentPoint::At(point) = zero_moment_point(&reaction, &plane) else {
            panic!("at rest the ground pushes");
        };
        let cog = posture.cog();
        near(point[0], cog[0], 1e-12, "x");
        near(point[1], cog[1], 1e-12, "y");
        let offset = [0, 1, 2].map(|axis| point[axis] - plane.point[axis]);
        near(dot(offset, plane.normal), 0.0, 1e-12, "on the plane");
        let flat = printed(&reaction, parameters.mass(), parameters.gravity(), cog).unwrap();
        near(flat[0], cog[0], 1e-12, "printed x");
        near(flat[1], cog[1], 1e-12, "printed y");
    }
}

#[test]
fn the_printed_zero_moment_point_misses_sideways_acceleration() {
    let parameters = Parameters::paper();
    let q = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0];
    let posture = Posture::new(&parameters, &q);
    let mut sideways = [0.0; 8];
    sideways[1] = 1.0;
    let reaction = posture.newton_euler(&[0.0; 8], &sideways).reaction;
    let level = Plane {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    let ZeroMomentPoint::At(full) = zero_moment_point(&reaction, &level) else {
        panic!("the ground pushes");
    };
    let cog = posture.cog();
    let flat = printed(&reaction, parameters.mass(), parameters.gravity(), cog).unwrap();
    // The point moves against the acceleration by height over gravity.
    near(full[0] - cog[0], -cog[2] / 9.81, 1e-12, "full");
    near(full[0] - cog[0], -0.0129, 5e-5, "12.9 mm");
    near(flat[0], cog[0], 1e-12, "printed");
}

#[test]
fn the_printed_zero_moment_point_is_off_by_decimetres_on_quick_motions() {
    let mut random = Random(9);
    let parameters = Parameters::paper();
    let level = Plane {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    let mut worst = 0.0f64;
    for _ in 0..1000 {
        let posture = Posture::new(&parameters, &random.joints([0.5; 8]));
        let (qd, qdd) = (random.joints([1.0; 8]), random.joints([3.0; 8]));
        let reaction = posture.newton_euler(&qd, &qdd).reaction;
        let ZeroMomentPoint::At(full) = zero_moment_point(&reaction, &level) else {
            panic!("the ground pushes");
        };
        let (mass, gravity) = (parameters.mass(), parameters.gravity());
        let flat = printed(&reaction, mass, gravity, posture.cog()).unwrap();
        worst = worst.max((full[0] - flat[0]).hypot(full[1] - flat[1]));
    }
    println!("{worst:.3} m");
    assert!(worst > 0.1, "{worst}");
}

#[test]
fn a_falling_robot_has_no_zero_moment_point() {
    let parameters = Parameters::paper();
    let posture = Posture::new(&parameters, &[0.0; 8]);
    let level = Plane {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    for down in [-9.82, -20.0, f64::NAN, f64::NEG_INFINITY] {
        let mut falling = [0.0; 8];
        falling[2] = down;
        let reaction = posture.newton_euler(&[0.0; 8], &falling).reaction;
        assert_eq!(zero_moment_point(&reaction, &level), ZeroMomentPoint::None);
        assert_eq!(printed(&reaction, 8.3, 9.81, [0.0; 3]), None);
    }
}

#[test]
fn a_joint_that_is_no_number_gives_no_zero_moment_point() {
    let parameters = Parameters::<f32>::paper();
    for joint in 0..8 {
        let mut q = [0.0; 8];
        q[joint] = f32::NAN;
        let reaction = Posture::new(&parameters, &q)
            .newton_euler(&[0.0; 8], &[0.0; 8])
            .reaction;
        let level = Plane {
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
        };
        assert_eq!(
            zero_moment_point(&reaction, &level),
            ZeroMomentPoint::None,
            "{joint}"
        );
    }
}
