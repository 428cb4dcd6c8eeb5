//! Constant model of B2P2: the values that Paillat et al. tabulate, and assumed ones.

use super::belt::tension::Elasticity;
use crate::world::gnss::ReceiverParameters;
use crate::world::load::Load;
use crate::world::sensing::BodySensorParameters;

/// Rigid segment with the values that the paper tabulates, in the axes of its D-H
/// (Denavit-Hartenberg) frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Segment {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the D-H frame, m.
    pub centre_of_mass: [f64; 3],
    /// Inertia matrix about the origin of the D-H frame, kg m^2.
    pub inertia_about_origin: [[f64; 3]; 3],
}

/// Segments 1 to 3 in the frames R6, R7 and R8 (Paillat et al., appendix: mechanical constants).
pub const SEGMENTS: [Segment; 3] = [
    Segment {
        mass: 6.356_067,
        centre_of_mass: [0.160_894, 0.034_997, -0.002_784],
        inertia_about_origin: [
            [0.128_728, -0.033_872, 0.002_259],
            [-0.033_872, 0.363_749, 0.001_158],
            [0.002_259, 0.001_158, 0.283_586],
        ],
    },
    Segment {
        mass: 0.897_066,
        centre_of_mass: [-0.000_723, -0.104_083, 0.014_127],
        inertia_about_origin: [
            [0.016_485, -0.000_107, 0.000_002],
            [-0.000_107, 0.003_941, 0.001_773],
            [0.000_002, 0.001_773, 0.012_863],
        ],
    },
    Segment {
        mass: 1.062_15,
        centre_of_mass: [0.000_09, -0.000_01, 0.152_68],
        inertia_about_origin: [
            [0.052_29, 0.0, -0.000_02],
            [0.0, 0.029_64, 0.0],
            [-0.000_02, 0.0, 0.025_23],
        ],
    },
];

/// Parameters of the simulated B2P2. docs/plant.md lists which values are from the paper and which
/// are assumed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct B2p2Parameters {
    /// Length of segment 1, axle 1 to axle 2, m.
    pub l1: f64,
    /// Length of segment 2, m.
    pub l2: f64,
    /// Track constant K of L + (L2 + L3) = K, m (eq. 1).
    pub k: f64,
    /// Radius of the three pulleys with their belt, m.
    pub pulley_radius: f64,
    /// Overall width, m.
    pub width: f64,
    /// Width of one belt, m.
    pub belt_width: f64,
    /// Distance from the origin of R8 to axle 3, m.
    pub axle_3_from_r8: f64,
    /// Height of segment 1's centre of mass above the line of axles 1 and 2, m.
    pub body_1_com_height: f64,
    /// Coefficient of friction between belt and ground.
    pub friction: f64,
    /// Creep coefficient, N s/m: the force along a belt under which its rubber creeps over the
    /// ground at 1 m/s.
    pub belt_creep: f64,
    /// Force that would stretch a belt to twice its length, N.
    pub belt_stiffness: f64,
    /// Tension of a belt whose axles are where the law `L + (L2 + L3) = K` has them, N.
    pub belt_tension: f64,
    /// Distance by which the belt can rise between pulleys before it meets the guide plates, m.
    pub guide_clearance: f64,
    /// Extension of the screw for one turn of its output shaft, m.
    pub screw_lead: f64,
    /// Stiffness, N m/rad, and damping, N m s/rad, of the chassis joint's gear.
    pub joint_gear: [f64; 2],
    /// Stiffness, N/m, and damping, N s/m, of the screw.
    pub screw_gear: [f64; 2],
    /// Inertia of a track's rotor at its output shaft, kg m^2. The belt must move it if the node is
    /// dead.
    pub track_inertia: f64,
    /// Friction of a dead track's gear at the sprocket, N m.
    pub dead_track_friction: f64,
    /// Friction of a belt that is off its sprocket, as a torque at the sprocket, N m.
    pub loose_belt_friction: f64,
    /// Friction of a dead chassis joint's gear, N m.
    pub dead_joint_friction: f64,
    /// Chassis angles at which the limit switches act, rad; the stops are 5 degrees beyond.
    pub joint_travel: [f64; 2],
    /// Chassis angle above which the joint's home switch is actuated, rad.
    pub joint_home: f64,
    /// Extensions at which the screw's limit switches act, m; the stops are 5 mm beyond.
    pub screw_travel: [f64; 2],
    /// Extension below which the screw's home switch is actuated, m.
    pub screw_home: f64,
    /// Chassis angle at power-up, rad; limited to the travel.
    pub initial_theta: f64,
    /// Extension at power-up minus the one that keeps the belts taut, m; negative means slack. The
    /// resulting extension is limited to the travel.
    pub initial_extension_error: f64,
    /// Heading at the start, rad, and distance to the left of the x axis, m.
    pub initial_heading_and_y: [f64; 2],
    /// Height of the lowest point above the ground at the start, m.
    pub initial_clearance: f64,
    /// Load that is put on segment 1 during the run.
    pub payload: Option<Load>,
    /// Supply voltage, V. It is constant, because the plant does not know the currents.
    pub supply_voltage: f64,
    /// Quality of the sensors on the body.
    pub body_sensors: BodySensorParameters,
    /// Quality of the GNSS receiver.
    pub receiver: ReceiverParameters,
}

impl B2p2Parameters {
    /// The model of B2P2 that the published results use.
    pub fn nominal() -> Self {
        Self::with_track_constant(1.232)
    }

    /// The short variant: K = 0.80 m, and a centre of mass 35 mm below the axles, without which it
    /// could not climb.
    pub fn short() -> Self {
        Self {
            body_1_com_height: -0.035,
            ..Self::with_track_constant(0.80)
        }
    }

    /// The nominal robot with another track constant `k`, m, and the matching travel of the screw.
    pub fn with_track_constant(k: f64) -> Self {
        let (l1, l2) = (0.32, 0.23);
        let extension = |theta: f64| taut_length(k, l1, theta) - l2;
        // The belt is released where it can lie along the line of axles; at theta = 0, eq. 2 gives
        // the same length.
        let released = extension(0.0);
        let joint_travel = [(-60.0_f64).to_radians(), 100.0_f64.to_radians()];
        Self {
            l1,
            l2,
            k,
            pulley_radius: 0.05,
            width: 0.37,
            belt_width: 0.05,
            axle_3_from_r8: 0.226,
            body_1_com_height: 0.0,
            friction: 1.0,
            belt_creep: 2.0e4,
            belt_stiffness: 1.0e5,
            belt_tension: 50.0,
            guide_clearance: 0.0,
            screw_lead: 0.005,
            joint_gear: [2.0e4, 20.0],
            screw_gear: [2.0e6, 5.0e3],
            track_inertia: 0.05,
            dead_track_friction: 1.5,
            loose_belt_friction: 0.2,
            dead_joint_friction: 8.0,
            joint_travel,
            joint_home: 20.0_f64.to_radians(),
            screw_travel: [released - 0.012, extension(joint_travel[1]) + 0.010],
            screw_home: released - 0.006,
            initial_theta: 0.0,
            initial_extension_error: 0.0,
            initial_heading_and_y: [0.0; 2],
            initial_clearance: 0.001,
            payload: None,
            supply_voltage: 24.0,
            body_sensors: BodySensorParameters::NOMINAL,
            receiver: ReceiverParameters::NOMINAL,
        }
    }

    /// Length L2 + L3 that keeps the belts taut at chassis angle `theta` (rad), m (eq. 2, solved
    /// for the triangle of the axles).
    pub fn taut_length(&self, theta: f64) -> f64 {
        taut_length(self.k, self.l1, theta)
    }

    /// Chassis angle at power-up, limited to the travel, rad.
    pub fn initial_theta(&self) -> f64 {
        self.initial_theta
            .clamp(self.joint_travel[0], self.joint_travel[1])
    }

    /// Chassis angle in the middle of the travel, rad.
    pub fn joint_middle(&self) -> f64 {
        0.5 * (self.joint_travel[0] + self.joint_travel[1])
    }

    /// Extension at power-up, limited to the travel, m.
    pub fn initial_extension(&self) -> f64 {
        let wanted =
            self.taut_length(self.initial_theta()) - self.l2 + self.initial_extension_error;
        wanted.clamp(self.screw_travel[0], self.screw_travel[1])
    }

    /// Elasticity of a belt. Its length is that of `K`, of segment 1 and of half a turn around a
    /// pulley, less what the belt's tension stretches it.
    pub fn belt(&self) -> Elasticity {
        let stretched = self.k + self.l1 + core::f64::consts::PI * self.pulley_radius;
        Elasticity {
            stiffness: self.belt_stiffness,
            length: stretched / (1.0 + self.belt_tension / self.belt_stiffness),
        }
    }

    /// Stiffness of a belt against bending in its surface, N m^2: that of a strip of one material.
    pub fn belt_rigidity(&self) -> f64 {
        self.belt_stiffness * self.belt_width * self.belt_width / 12.0
    }

    /// Distance from axle 1 to axle 3, m.
    pub fn chord(&self, theta: f64, extension: f64) -> f64 {
        let r = self.l2 + extension;
        libm::sqrt(self.l1 * self.l1 + r * r + 2.0 * self.l1 * r * libm::cos(theta))
    }
}

fn taut_length(k: f64, l1: f64, theta: f64) -> f64 {
    (k * k - l1 * l1) / (2.0 * (k + l1 * libm::cos(theta)))
}
