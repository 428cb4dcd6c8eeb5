//! Limits the first current after arming until the shaft has turned the way of its torque. So a
//! drive with a reversed encoder, swapped leads or a wrong rotor angle gets no full torque.
//!
//! A shaft that does not turn shows no sign: the current stays at the limit of the probe, and the
//! fault "blocked" is raised there. docs/motor.md says which drives may use the probe.

use crate::math::Turns;
use crate::settings::{Setting, Settings};
use core::f32::consts::TAU;

/// Electrical angles, rad: that which proves the sign, that which disproves it, and that within
/// which a shaft stands. A brushed motor counts as a motor with four pole pairs.
///
/// With a reversed encoder or swapped leads, a three-phase rotor swings to where it has no torque.
/// Its swing looks right, and friction ends it before the angle of the proof.
const PROOF: f32 = 0.375 * TAU;
const PROOF_OF_BRUSHED: f32 = 0.05 * TAU;
const DISPROOF: f32 = 0.025 * TAU;
const STANDING: f32 = TAU / 160.0;
const POLE_PAIRS_OF_BRUSHED: i32 = 4;
/// Fewest counts of the encoder that prove, that disprove, and within which a shaft stands.
const FEWEST: [f32; 3] = [8.0, 4.0, 2.0];
/// Parts of the limit of the probe from which on a motion counts, and from which on the shaft must
/// turn.
const COUNTED: f32 = 0.25;
const PUSHING: f32 = 0.5;
/// Control periods in which a shaft that is pushed must turn, and in which one that moved before
/// must stand.
const PUSHED: u8 = 25;
const SETTLED: u8 = 10;

/// What the probe has found in a control period.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Sign {
    /// The shaft has turned against its torque, or its position is doubtful.
    pub against: bool,
    /// The shaft does not turn.
    pub stands: bool,
}

/// The probe of one axle.
#[derive(Clone, Debug)]
pub(super) struct SignProbe {
    /// Largest current during the probe, A; 0 without a probe.
    current: f32,
    /// Motions that prove, that disprove, and within which a shaft stands, 2^-32 turn of the output
    /// shaft.
    proof: Turns,
    disproof: Turns,
    standing: Turns,
    run: Run,
}

/// What is known since the axle got power.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    proven: bool,
    /// Whether the current is negative; `None` while it is too small.
    backward: Option<bool>,
    /// Position from which the motion counts.
    from: Turns,
    /// The shaft may still have the speed from before the torque.
    coasts: bool,
    /// Position near which the shaft has stood for this many control periods.
    near: Turns,
    stood: u8,
    /// Control periods for which the shaft has had to turn.
    pushed: u8,
}

impl SignProbe {
    /// Creates the probe of an axle that is off.
    pub fn new(settings: &Settings) -> Self {
        let (pole_pairs, proof) = match settings.get(Setting::MotorKind) {
            0 => (POLE_PAIRS_OF_BRUSHED, PROOF_OF_BRUSHED),
            _ => (settings.get(Setting::PolePairs), PROOF),
        };
        let gear = settings.si(Setting::GearRatio);
        let count = TAU / settings.get(Setting::EncoderCounts) as f32;
        let motion = |angle: f32, fewest: f32| {
            let (angle, fewest) = (angle / pole_pairs as f32, fewest * count);
            Turns::from_radians(if angle > fewest { angle } else { fewest } / gear)
        };
        Self {
            current: settings.si(Setting::ProbeCurrent),
            proof: motion(proof, FEWEST[0]),
            disproof: motion(DISPROOF, FEWEST[1]),
            standing: motion(STANDING, FEWEST[2]),
            run: Run::default(),
        }
    }

    /// Begins anew: the axle gets power.
    pub fn start(&mut self) {
        self.run = Run::default();
    }

    /// Returns the current limit: `limit`, or that of the probe.
    #[inline]
    pub fn bound(&self, limit: f32) -> f32 {
        if self.probes() && self.current < limit {
            self.current
        } else {
            limit
        }
    }

    #[inline]
    fn probes(&self) -> bool {
        !self.run.proven && self.current != 0.0
    }

    /// Runs one control period under power, at this position, with the demanded current of the last
    /// one, A. A motion to a `doubtful` position proves nothing.
    #[inline]
    pub fn tick(&mut self, position: Turns, doubtful: bool, demand: f32) -> Sign {
        if !self.probes() {
            return Sign::default();
        }
        let run = &mut self.run;
        if (position - run.near).distance() >= self.standing.distance() {
            (run.near, run.stood) = (position, 0);
        }
        run.stood = run.stood.saturating_add(1);
        let size = demand.abs();
        let counts = size >= COUNTED * self.current && !doubtful;
        let backward = counts.then_some(demand < 0.0);
        if backward.is_none() || run.backward != backward {
            (run.from, run.coasts, run.pushed) = (position, true, 0);
        }
        run.backward = backward;
        let moved = position - run.from;
        let mut along = if demand < 0.0 { -moved } else { moved };
        if run.coasts {
            if along < Turns::ZERO {
                (run.from, along) = (position, Turns::ZERO);
            }
            run.coasts = run.stood < SETTLED && along < self.standing;
        }
        if !(size >= PUSHING * self.current) {
            run.pushed = 0;
            return Sign::default();
        }
        run.pushed = run.pushed.saturating_add(1);
        run.proven = along >= self.proof;
        Sign {
            against: doubtful || along <= -self.disproof,
            stands: run.pushed > PUSHED && run.stood > PUSHED,
        }
    }
}
