//! Where a node's shaft meets the load: stiff gears, belts on their sprockets, and what is left when a node is dead.

use super::physics::{DT, SUBSTEPS};
use core::f64::consts::TAU;
use tautrack::link::Shaft;

/// Time by which the mean of the substeps' ends lies before the end of the step, s.
const MEAN_LEAD: f64 = DT * (SUBSTEPS as f64 - 1.0) / (2.0 * SUBSTEPS as f64);

/// Position of a shaft, turns since power-up.
pub fn turns(shaft: &Shaft) -> f64 {
    shaft.position as f64 / 4_294_967_296.0
}

/// What the solver is told for one step: a spring and a damper towards a moving place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Drive {
    /// Place, rad or m; the same for all substeps, so their mean.
    pub place: f64,
    /// Speed, rad/s or m/s.
    pub speed: f64,
    /// Stiffness and damping.
    pub stiffness: [f64; 2],
    /// Most force or torque.
    pub limit: f64,
}

/// A stiff gear between a shaft and a joint of the robot.
#[derive(Clone, Copy, Debug)]
pub struct Gear {
    /// Stiffness and damping at the joint.
    stiffness: [f64; 2],
    /// Motion of the joint for one turn of the shaft, rad or m.
    per_turn: f64,
    /// Coulomb friction without its node; `None` locks itself.
    dead_friction: Option<f64>,
    /// Place of the joint at the shaft's zero; `None` while the node is dead.
    zero: Option<f64>,
    /// Place at which a self-locking gear was left.
    held: f64,
}

impl Gear {
    /// A gear at `place`, not yet bound to a shaft.
    pub fn new(stiffness: [f64; 2], per_turn: f64, dead_friction: Option<f64>, place: f64) -> Self {
        Self {
            stiffness,
            per_turn,
            dead_friction,
            zero: None,
            held: place,
        }
    }

    /// Takes the shaft's motion; `place` is where the joint is now.
    pub fn drive(&mut self, shaft: Option<&Shaft>, place: f64) -> Drive {
        let Some(shaft) = shaft else {
            if self.zero.take().is_some() {
                self.held = place;
            }
            return match self.dead_friction {
                // Stiff enough that creeping below the friction stays invisible.
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
        // A shaft seen for the first time has already made this step.
        let zero = *self.zero.get_or_insert(place - moved + speed * DT);
        let target = zero + moved;
        Drive {
            place: target - speed * MEAN_LEAD,
            speed,
            stiffness: self.stiffness,
            limit: f64::MAX,
        }
    }

    /// Torque, N m, with which the load resists a positive turn of the shaft when the gear passes `force` (N or N m) on to
    /// its joint in the last substep, the joint having moved at `rate` (rad/s or m/s). Zero without a node.
    ///
    /// The joint moves towards a place that stands still during the step, so the force falls from substep to substep; the
    /// shaft feels the mean.
    pub fn shaft_torque(&self, force: f64, rate: f64) -> f64 {
        let mean = force + self.stiffness[0] * MEAN_LEAD * rate;
        if self.zero.is_some() {
            mean * self.per_turn / TAU
        } else {
            0.0
        }
    }
}

/// A belt on its sprocket.
#[derive(Clone, Copy, Debug, Default)]
pub struct Belt {
    /// Speed, m/s.
    pub speed: f64,
    /// Force of the ground along the belt, forward positive, low-passed, N.
    pub traction: f64,
    /// Speed that is lost on the way from the sprocket to the ground, by sliding and creeping, low-passed, m/s.
    pub slip_speed: f64,
    driven: bool,
}

/// Time constant of the force that a sprocket feels, s: the belt's elasticity. Unfiltered, force and speed chase each other.
const BELT_LAG: f64 = 0.010;
/// Time constant of the slip that counts, s: the solver's single steps tremble around none.
const SLIP_LAG: f64 = 0.050;

impl Belt {
    /// Takes the shaft's motion: the belt moves with its sprocket, or freely against the friction of a dead gear.
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

    /// Speed of its surface on the ground, m/s: rubber creeps under load. Without creep, belts that fight each other over the
    /// robot's heading never come to rest, as their friction knows no middle between holding and sliding.
    pub fn surface_speed(&self, creep: f64) -> f64 {
        self.speed - self.traction / creep
    }

    /// Takes what the ground did in the last step: its force, N, and the speed of the surface over it, m/s.
    pub fn load(&mut self, traction: f64, sliding: f64, creep: f64) {
        let slip_speed = sliding + self.traction / creep;
        self.traction += (traction - self.traction) * (DT / (BELT_LAG + DT));
        self.slip_speed += (slip_speed - self.slip_speed) * (DT / (SLIP_LAG + DT));
    }

    /// Torque with which the ground resists a positive turn of the sprocket, N m. Zero without a node.
    pub fn shaft_torque(&self, radius: f64) -> f64 {
        if self.driven {
            self.traction * radius
        } else {
            0.0
        }
    }
}
