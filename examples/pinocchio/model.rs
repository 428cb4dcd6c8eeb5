//! C interface to B2P2's model in double precision, for `compare.cpp`.
//!
//! Every function computes everything from the joint values, as the functions of pinocchio do.

use tautrack::math::vector::CoordinateFrame;
use tautrack::robots::b2p2::parameters::{LENGTHS, SEGMENTS};
use tautrack::robots::b2p2::{JointMatrix, Joints, Parameters, Posture};
use tautrack::stability::zmp::{Plane, ZeroMomentPoint, zero_moment_point};

/// Constants of the robot: lengths L1 and L2 (m), gravity (m/s^2), then for each segment its mass
/// (kg), its centre of mass (m) and its inertia about the origin of its frame (kg m^2, by rows).
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_constants(constants: &mut [f64; 42]) {
    let lengths = [LENGTHS.l1, LENGTHS.l2, LENGTHS.gravity];
    let segments = SEGMENTS.iter().flat_map(|segment| {
        let inertia = segment.inertia_about_origin.iter().flatten().copied();
        [segment.mass]
            .into_iter()
            .chain(segment.centre_of_mass)
            .chain(inertia)
    });
    for (to, from) in constants
        .iter_mut()
        .zip(lengths.into_iter().chain(segments))
    {
        *to = from;
    }
}

/// The robot of the paper.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_new() -> Box<Parameters<f64>> {
    Box::new(Parameters::paper())
}

/// Frames R1 to R8 in R0: axes x, y and z, then the origin.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_frames(
    parameters: &Parameters<f64>,
    q: &Joints<f64>,
    frames: &mut [CoordinateFrame<f64>; 8],
) {
    *frames = Posture::new(parameters, q).frames();
}

/// Centre of gravity in R0, m.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_cog(parameters: &Parameters<f64>, q: &Joints<f64>, cog: &mut [f64; 3]) {
    *cog = Posture::new(parameters, q).cog();
}

/// Inertia matrix D.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_inertia(
    parameters: &Parameters<f64>,
    q: &Joints<f64>,
    matrix: &mut JointMatrix<f64>,
) {
    *matrix = Posture::new(parameters, q).inertia_matrix();
}

/// Coriolis matrix C.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_coriolis(
    parameters: &Parameters<f64>,
    q: &Joints<f64>,
    rates: &Joints<f64>,
    matrix: &mut JointMatrix<f64>,
) {
    *matrix = Posture::new(parameters, q).coriolis_matrix(rates);
}

/// Generalized forces of a motion.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_inverse_dynamics(
    parameters: &Parameters<f64>,
    q: &Joints<f64>,
    rates: &Joints<f64>,
    accelerations: &Joints<f64>,
    forces: &mut Joints<f64>,
) {
    *forces = Posture::new(parameters, q)
        .newton_euler(rates, accelerations)
        .forces;
}

/// Zero moment point of a motion on the level plane through the origin, m; zeros if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn b2p2_zmp(
    parameters: &Parameters<f64>,
    q: &Joints<f64>,
    rates: &Joints<f64>,
    accelerations: &Joints<f64>,
    point: &mut [f64; 3],
) {
    let effort = Posture::new(parameters, q).newton_euler(rates, accelerations);
    let ground = Plane {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    *point = match zero_moment_point(&effort.reaction, &ground) {
        ZeroMomentPoint::At(point) => point,
        ZeroMomentPoint::None => [0.0; 3],
    };
}
