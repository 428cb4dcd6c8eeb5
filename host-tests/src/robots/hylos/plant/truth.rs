//! Ground truth of Hylos.

use super::{Hylos, robot};
use rapier3d_f64::math::Vector;
use tautrack::constants::GRAVITY_F64;
use tautrack::robots::hylos::parameters::{MARGIN_FLOOR, MARGIN_LIMIT, POTENTIAL_GAIN};
use tautrack::robots::hylos::stability::AROUND;
use tautrack::robots::hylos::{LEGS, Potential};
use tautrack::stability::tipover::{angles, margin};

/// Number of steps for which a wheel that carried force counts as standing. Single contacts flicker
/// from step to step.
const WINDOW: u64 = 50;
/// Minimum force of a wheel that stands, N.
const LEAST_SUPPORT: f64 = 0.5;
/// Cosine of the angle between platform and ground above which the robot counts as toppled.
const TIPPED: f64 = 0.5;

/// Channel names of each leg: hip, knee, steering, and the force of the ground on its wheel.
const CHANNELS: [[&str; 4]; LEGS] = [
    [
        "front_left_hip_rad",
        "front_left_knee_rad",
        "front_left_steering_rad",
        "front_left_load_n",
    ],
    [
        "front_right_hip_rad",
        "front_right_knee_rad",
        "front_right_steering_rad",
        "front_right_load_n",
    ],
    [
        "rear_left_hip_rad",
        "rear_left_knee_rad",
        "rear_left_steering_rad",
        "rear_left_load_n",
    ],
    [
        "rear_right_hip_rad",
        "rear_right_knee_rad",
        "rear_right_steering_rad",
        "rear_right_load_n",
    ],
];

/// State of the legs in m, rad and N; x forward, y left, z up.
#[derive(Clone, Debug, Default)]
pub struct Detail {
    /// Middle of the platform in world axes.
    pub place: [f64; 3],
    /// Upward direction in the platform's axes.
    pub up: [f64; 3],
    /// Angles of hips and knees.
    pub legs: [[f64; 2]; LEGS],
    /// Steering angles.
    pub steering: [f64; LEGS],
    /// Torques of the gears of hips and knees, N m; the signs are those of the joints.
    pub leg_torques: [[f64; 2]; LEGS],
    /// Force of the ground on each wheel along its normal.
    pub wheel_forces: [f64; LEGS],
    /// Whether each wheel carried force within the last 50 ms.
    pub standing: [bool; LEGS],
    /// Lowest point of each wheel above the ground, whether the wheel stands or not.
    pub contacts: [[f64; 3]; LEGS],
    /// Minimum tip-over angle of the weight about the lines between the contacts of neighbouring
    /// wheels; negative once the robot topples.
    pub margin: f64,
}

impl Hylos {
    /// Ground truth of the legs after the last step; no node may see it.
    pub fn detail(&self) -> &Detail {
        &self.detail
    }

    /// Updates the ground truth after a step.
    pub(super) fn observe(&mut self) {
        let (p, world, robot) = (&self.parameters, &self.world, &self.robot);
        let platform = &world.bodies[robot.platform];
        let pose = platform.position();
        let detail = &mut self.detail;
        detail.place = pose.translation.to_array();
        detail.up = (pose.rotation.inverse() * Vector::Z).to_array();
        detail.wheel_forces = robot.wheel_forces(world);
        let m = &p.measures;
        let com = pose.transform_point(Vector::from_array(m.platform_com));
        let (mut mass, mut moment) = (m.platform_mass, com * m.platform_mass);
        let mut momentum = platform.velocity_at_point(com) * m.platform_mass;
        for leg in 0..LEGS {
            detail.legs[leg] = p.joints(robot.reach(world, p, leg));
            detail.steering[leg] = robot.steering(world, leg);
            detail.leg_torques[leg] = self.leg_torques[leg];
            if detail.wheel_forces[leg] > LEAST_SUPPORT {
                self.standing_until[leg] = self.step + WINDOW;
            }
            detail.standing[leg] = self.standing_until[leg] > self.step;

            let carrier = &world.bodies[robot.carriers[leg]];
            let hub = carrier.position().translation;
            moment += hub * m.wheel_mass;
            momentum += carrier.linvel() * m.wheel_mass;
            mass += m.wheel_mass;
            let normal = Vector::from_array(self.hillside.normal([hub.x, hub.y]));
            let axle = carrier.position().rotation * Vector::Y;
            let across = (normal - axle * normal.dot(axle)).normalize_or_zero();
            detail.contacts[leg] = (hub - across * m.wheel_radius).to_array();
        }
        let cog = moment / mass;
        let around = AROUND.map(|leg| detail.contacts[leg]);
        let weight = [0.0, 0.0, -mass * GRAVITY_F64];
        let tip_over = angles(&around, cog.to_array(), weight, [0.0; 3]);
        detail.margin = margin(&tip_over);
        // Stability potential as in the controller, of the true angles.
        let potential = Potential::new(POTENTIAL_GAIN, MARGIN_LIMIT, MARGIN_FLOOR)
            .map_or(f64::NAN, |potential| potential.total(&tip_over));

        let [forward, left] = [Vector::X, Vector::Y].map(|axis| pose.rotation * axis);
        let heading = left.cross(Vector::Z).normalize_or_zero();
        let truth = &mut self.truth;
        let rear = [2, 3].map(|leg| world.bodies[robot.carriers[leg]].position().translation);
        truth.axle_1 = (0.5 * (rear[0] + rear[1])).to_array();
        truth.pitch = libm::atan2(forward.dot(heading.cross(left)), forward.dot(heading));
        truth.roll = libm::atan2(left.z, libm::sqrt(left.x * left.x + left.y * left.y));
        truth.yaw = libm::atan2(heading.y, heading.x);
        truth.pitch_rate = -platform.angvel().dot(left);
        truth.cog = cog.to_array();
        truth.ground_speed = (momentum / mass).dot(heading);
        truth.contacts.clear();
        let (mut rearmost, mut foremost) = (f64::INFINITY, f64::NEG_INFINITY);
        for leg in (0..LEGS).filter(|leg| detail.standing[*leg]) {
            let contact = detail.contacts[leg];
            truth.contacts.push(contact);
            let along = (Vector::from_array(contact) - cog).dot(heading);
            rearmost = if along < rearmost { along } else { rearmost };
            foremost = if along > foremost { along } else { foremost };
        }
        let supported = !truth.contacts.is_empty();
        truth.backward_margin = supported.then_some(-rearmost);
        truth.forward_margin = supported.then_some(foremost);
        let ground = self.hillside.normal([detail.place[0], detail.place[1]]);
        let upright = (pose.rotation * Vector::Z).dot(Vector::from_array(ground));
        truth.toppled |= upright < TIPPED;
        truth.channels.insert("tip_over_margin_rad", detail.margin);
        truth.channels.insert("stability_potential_1", potential);
        truth.points.clear();
        for (leg, names) in CHANNELS.iter().enumerate() {
            let [hip, knee] = detail.legs[leg];
            let values = [hip, knee, detail.steering[leg], detail.wheel_forces[leg]];
            truth.channels.extend(names.iter().copied().zip(values));
            let places = robot::leg_places(p, leg, detail.legs[leg]);
            truth
                .points
                .extend(places.map(|place| pose.transform_point(place).to_array()));
        }
    }
}
