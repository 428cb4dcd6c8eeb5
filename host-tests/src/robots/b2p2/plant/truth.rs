//! Ground truth of B2P2, as recorded in a run.

use super::B2p2;
use crate::world::physics::DT;
use rapier3d_f64::math::Vector;
use tautrack::constants::GRAVITY_F64;

/// Absolute roll from which the robot lies on its side, rad.
const ON_ITS_SIDE: f64 = 80.0 * core::f64::consts::PI / 180.0;

/// Absolute pitch of body 1 from which the robot lies upside down at any chassis angle, rad.
const UPSIDE_DOWN: f64 = 110.0 * core::f64::consts::PI / 180.0;

impl B2p2 {
    /// Sum of the ground's upward forces in the last step, N. It is the robot's weight when the
    /// robot is at rest.
    pub fn lift(&self) -> f64 {
        self.ground.lift
    }

    /// Forces of the corners of the ground on the belts in the last step, in world axes, N.
    pub fn belt_corners(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let pressed = self.belts.sides.iter().flat_map(|belt| &belt.pressed);
        pressed.map(|pressed| pressed.force.to_array())
    }

    /// Kinetic and potential energy of the three segments, J; the potential is zero at z = 0.
    pub fn energy(&self) -> f64 {
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        bodies
            .iter()
            .map(|body| body.kinetic_energy() + body.mass() * GRAVITY_F64 * body.center_of_mass().z)
            .sum()
    }

    /// Updates the ground truth after a step.
    pub(super) fn observe(&mut self) {
        let p = &self.parameters;
        let bodies = self.robot.bodies.map(|handle| &self.world.bodies[handle]);
        let (mut mass, mut moment, mut momentum) = (0.0, Vector::ZERO, Vector::ZERO);
        // The engine's own sums exist only after its first step.
        for (body, properties) in bodies.iter().zip(&self.robot.masses) {
            let centre = body.position().transform_point(properties.local_com);
            mass += properties.mass();
            moment += centre * properties.mass();
            momentum += body.velocity_at_point(centre) * properties.mass();
        }
        let cog = moment / mass;
        let rear = bodies[0];
        let [forward, left] = [Vector::X, Vector::Y].map(|axis| rear.position().rotation * axis);
        // Yaw, roll and pitch in the order of the paper's joints 4, 5 and 6: the pitch is the
        // rotation about the rolled axle.
        let heading = left.cross(Vector::Z).normalize_or_zero();
        let pitch = libm::atan2(forward.dot(heading.cross(left)), forward.dot(heading));
        let roll = libm::atan2(left.z, libm::sqrt(left.x * left.x + left.y * left.y));
        let [theta, _] = self.robot.chassis_joint(&self.world);
        let [extension, _] = self.robot.extension(&self.world, p);
        let axle_1 = rear.position().translation;
        let along = |point: Vector| (point - cog).dot(heading);
        let (mut rearmost, mut foremost) = (f64::INFINITY, f64::NEG_INFINITY);
        let truth = &mut self.truth;
        truth.contacts.clear();
        for point in self.support.points() {
            let distance = along(point);
            rearmost = if distance < rearmost {
                distance
            } else {
                rearmost
            };
            foremost = if distance > foremost {
                distance
            } else {
                foremost
            };
            truth.contacts.push(point.to_array());
        }
        let supported = !truth.contacts.is_empty();
        truth.backward_margin = supported.then_some(-rearmost);
        truth.forward_margin = supported.then_some(foremost);
        truth.axle_1 = axle_1.to_array();
        (truth.pitch, truth.roll) = (pitch, roll);
        truth.yaw = libm::atan2(heading.y, heading.x);
        truth.pitch_rate = -rear.angvel().dot(left);
        (truth.theta, truth.extension) = (theta, extension);
        truth.tension_error = p.chord(theta, extension) + p.l2 + extension - p.k;
        let [left, right] = &self.belts.sides;
        truth.points.clear();
        truth
            .points
            .extend(left.course.iter().map(Vector::to_array));
        truth.channels.extend([
            ("left_belt_tension_n", left.tension),
            ("right_belt_tension_n", right.tension),
            ("left_belt_slack_mm", left.slack * 1e3),
            ("right_belt_slack_mm", right.slack * 1e3),
        ]);
        truth.cog = cog.to_array();
        truth.ground_speed = (momentum / mass).dot(heading);
        truth.belt_speed = self.sprockets.map(|belt| belt.speed);
        truth.slip += 0.5
            * self
                .sprockets
                .iter()
                .map(|belt| belt.slip_speed.abs())
                .sum::<f64>()
            * DT;
        let upright = core::f64::consts::FRAC_PI_2;
        truth.toppled |= roll.abs() > ON_ITS_SIDE
            || pitch.abs() > UPSIDE_DOWN
            || (pitch > upright && along(axle_1) > 0.0)
            // With the front raised, the robot may come to rest on the front's upper side, with
            // axle 3 ahead.
            || pitch < -upright;
    }
}
