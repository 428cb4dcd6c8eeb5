//! Connection between a node's shaft and its load: stiff gears, belts on their sprockets, and their
//! behaviour when the node is dead.

use super::physics::{DT, SUBSTEPS};
use core::f64::consts::TAU;
use tautrack::link::Shaft;

/// Time from the mean of the substeps' ends to the end of the step, s.
const MEAN_LEAD: f64 = DT * (SUBSTEPS as f64 - 1.0) / (2.0 * SUBSTEPS as f64);

/// Position of a shaft, turns since power-up.
pub fn turns(shaft: &Shaft) -> f64 {
    shaft.position as f64 / 4_294_967_296.0
}

/// Motor command of the physics solver for one step: a spring and a damper towards a moving place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Drive {
    /// Place, rad or m. It is the same for all substeps, and therefore their mean.
    pub place: f64,
    /// Speed, rad/s or m/s.
    pub speed: f64,
    /// Stiffness, N m/rad or N/m, and damping, N m s/rad or N s/m.
    pub stiffness: [f64; 2],
    /// Maximum torque or force, N m or N.
    pub limit: f64,
}

/// Stiff gear between a node's shaft and a joint of the robot.
#[derive(Clone, Copy, Debug)]
pub struct Gear {
    /// Stiffness and damping at the joint.
    stiffness: [f64; 2],
    /// Motion of the joint for one turn of the shaft, rad or m.
    per_turn: f64,
    /// Coulomb friction while the node is dead; `None` if the gear locks itself.
    dead_friction: Option<f64>,
    /// Place of the joint when the shaft is at zero; `None` while the node is dead.
    zero: Option<f64>,
    /// Place at which a self-locking gear stays while the node is dead.
    held: f64,
}

impl Gear {
    /// Creates a gear at `place`, not yet connected to a shaft.
    pub fn new(stiffness: [f64; 2], per_turn: f64, dead_friction: Option<f64>, place: f64) -> Self {
        Self {
            stiffness,
            per_turn,
            dead_friction,
            zero: None,
            held: place,
        }
    }

    /// Computes the motor command from the shaft's motion; `place` is the joint's current place.
    pub fn drive(&mut self, shaft: Option<&Shaft>, place: f64) -> Drive {
        let Some(shaft) = shaft else {
            if self.zero.take().is_some() {
                self.held = place;
            }
            return match self.dead_friction {
                // High damping, so that creeping below the friction limit is negligible.
                Some(limit) => Drive {
                    place: 0.0,
                    speed: 0.0,
                    stiffness: [0.0, 1.0e5],
                    limit,
                },
                None => Drive {
                    place: self.held,
                    speed: 0.0,
                    stiffness: self.stiffness,
                    limit: f64::MAX,
                },
            };
        };
        let speed = f64::from(shaft.velocity) * self.per_turn / TAU;
        let moved = turns(shaft) * self.per_turn;
        // A shaft that is new in this step has already moved in it.
        let zero = *self.zero.get_or_insert(place - moved + speed * DT);
        let target = zero + moved;
        Drive {
            place: target - speed * MEAN_LEAD,
            speed,
            stiffness: self.stiffness,
            limit: f64::MAX,
        }
    }

    /// Torque, N m, with which the load resists a positive turn of the shaft; 0 if the node is
    /// dead. `force` (N or N m) is what the gear transmits to its joint in the last substep, and
    /// `rate` (rad/s or m/s) the rate of the joint.
    ///
    /// The joint moves towards a place that is constant during the step, so the force decreases
    /// from substep to substep. The shaft gets the mean.
    pub fn shaft_torque(&self, force: f64, rate: f64) -> f64 {
        let mean = force + self.stiffness[0] * MEAN_LEAD * rate;
        if self.zero.is_some() {
            mean * self.per_turn / TAU
        } else {
            0.0
        }
    }
}

/// Sprocket that drives a belt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sprocket {
    /// Speed, m/s.
    pub speed: f64,
    /// Force of the ground along the belt, forward positive, low-passed, N.
    pub traction: f64,
    /// Speed lost between the sprocket and the ground by sliding and creeping, low-passed, m/s.
    pub slip_speed: f64,
    driven: bool,
}

/// Time constant of the force on a sprocket, s. It models the belt's elasticity; without this
/// filter, force and speed oscillate.
const BELT_LAG: f64 = 0.010;
/// Time constant of the recorded slip, s. In single steps, the solver's slip oscillates around
/// zero.
const SLIP_LAG: f64 = 0.050;

impl Sprocket {
    /// Sets the belt's speed from the motion of the sprocket's shaft. If the node is dead, the belt
    /// moves freely against the friction of the gear.
    pub fn drive(&mut self, shaft: Option<&Shaft>, radius: f64, inertia: f64, friction: f64) {
        self.driven = shaft.is_some();
        self.speed = if let Some(shaft) = shaft {
            f64::from(shaft.velocity) * radius
        } else {
            let mass = inertia / (radius * radius);
            let free = self.speed - self.traction * DT / mass;
            let stopping = friction / radius * DT / mass;
            if free.abs() <= stopping {
                0.0
            } else {
                free - stopping * free.signum()
            }
        };
    }

    /// Speed of the belt's surface on the ground, m/s. Rubber creeps under load: without creep, two
    /// belts that work against each other over the robot's heading would never come to rest,
    /// because their friction would either hold or slide.
    pub fn surface_speed(&self, creep: f64) -> f64 {
        self.speed - self.traction / creep
    }

    /// Filters the ground's action in the last step: its force, N, and the sliding speed of the
    /// surface, m/s.
    pub fn load(&mut self, traction: f64, sliding: f64, creep: f64) {
        let slip_speed = sliding + self.traction / creep;
        self.traction += (traction - self.traction) * (DT / (BELT_LAG + DT));
        self.slip_speed += (slip_speed - self.slip_speed) * (DT / (SLIP_LAG + DT));
    }

    /// Torque with which the ground resists a positive turn of the sprocket, N m; 0 if the node is
    /// dead.
    pub fn shaft_torque(&self, radius: f64) -> f64 {
        if self.driven {
            self.traction * radius
        } else {
            0.0
        }
    }
}
