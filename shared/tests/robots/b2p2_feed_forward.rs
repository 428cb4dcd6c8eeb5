//! Tests the torque feed-forward: the load of the front part against the complete dynamic model.

use crate::random::Random;
use tautrack::estimate::attitude::Attitude;
use tautrack::math::Turns;
use tautrack::motor::profile::Motion;
use tautrack::robots::b2p2::model::belt::TautBelt;
use tautrack::robots::b2p2::parameters::LENGTHS;
use tautrack::robots::b2p2::{FrontPart, Parameters, Posture};
use tautrack::screw::{Geometry, SlackLaw};
use tautrack::sensors::BodySensors;
use tautrack::settings::Settings;

/// The reference is `D q'' + C q' - Q` in double precision, with the closed form of the belt's law,
/// taut and slack.
#[test]
fn load_is_what_the_whole_model_asks_of_joints_7_and_8() {
    let geometry = Geometry::from_micrometres(320_000, 230_000, 1_232_000).unwrap();
    let law = SlackLaw::new(&geometry);
    let front = FrontPart::new(&geometry, &Settings::default());
    let parameters = Parameters::<f64>::paper();
    let mut random = Random(7);
    let (mut worst_joint, mut worst_screw, mut largest) = (0.0_f64, 0.0_f64, [0.0_f64; 2]);
    for _ in 0..20_000 {
        let [yaw, roll, pitch] = [3.0, 0.8, 1.2].map(|scale| (scale * random.next()) as f32);
        let chassis = Motion {
            position: Turns::from_radians((1.7 * random.next()) as f32),
            velocity: (2.0 * random.next()) as f32,
            acceleration: (8.0 * random.next()) as f32,
        };
        let mut attitude = Attitude::default();
        assert!(attitude.update(
            &BodySensors {
                inclination: [pitch, roll],
                ..BodySensors::default()
            },
            1e-3,
        ));
        // Half of the belts are taut.
        let slack = (0.12 * random.next()).max(0.0) as f32;
        let taut = geometry.extension(chassis.position.angle());
        let extension = law.extension(taut, slack);
        let curve = law.second_derivative(extension, slack);
        let load = front.load(extension, curve, &chassis, &attitude);
        let belt = TautBelt::new(1.232 - f64::from(slack), LENGTHS.l1, LENGTHS.l2).unwrap();

        let theta = chassis.position.to_bits() as f64 / 4_294_967_296.0 * std::f64::consts::TAU;
        let [rate, acceleration] = [chassis.velocity, chassis.acceleration].map(f64::from);
        let extension = belt.extension(theta);
        let (mut q, mut rates, mut accelerations) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        (q[3], q[4], q[5]) = (yaw.into(), roll.into(), pitch.into());
        (q[6], q[7]) = (theta, extension.length - LENGTHS.axle_3);
        (rates[6], rates[7]) = (rate, extension.derivative * rate);
        accelerations[6] = acceleration;
        accelerations[7] =
            extension.derivative * acceleration + extension.second_derivative * rate * rate;
        let forces = Posture::new(&parameters, &q).lagrange(&rates, &accelerations);
        worst_joint = worst_joint.max((f64::from(load.joint) - forces[6]).abs());
        worst_screw = worst_screw.max((f64::from(load.screw) - forces[7]).abs());
        largest = [
            largest[0].max(forces[6].abs()),
            largest[1].max(forces[7].abs()),
        ];
    }
    println!(
        "worst {worst_joint:e} N m of {}, {worst_screw:e} N of {}",
        largest[0], largest[1]
    );
    assert!(worst_joint < 2e-4, "{worst_joint:e} N m");
    assert!(worst_screw < 1e-3, "{worst_screw:e} N");
}
