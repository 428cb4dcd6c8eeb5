//! Limits an admitted command to what the margins allow.

use super::Balance;
use crate::math::{clamp, max, min};
use crate::stability::allowed::{Ahead, Allowed, Command};
use crate::stability::filter::{Ramp, Verdict};
use crate::stability::limits::MotionLimits;
use crate::stability::support::{Edge, NO_EDGE};
use crate::stability::trip::Mode;
use crate::stability::{filter, step_behind};

/// How the robot moves, for [`Balance::filter`].
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Pitch, nose up positive, rad.
    pub pitch: f32,
    /// Time of a stop at the configured deceleration, s.
    pub stopping: f32,
    /// Scale of a forward speed that a fall over an unseen edge allows, 0 to 1.
    pub forward_scale: f32,
}

/// Speed scale of the posture in a supervised override.
const OVERRIDE_POSTURE: f32 = 0.25;

impl Balance {
    /// Limits an admitted command to what the margins allow. `ahead` is where the posture's motion
    /// leads within [`Self::horizon`]; `None` while the posture is at rest.
    pub fn filter<P>(
        &mut self,
        command: &Command<P>,
        ahead: Option<&Ahead>,
        motion: Motion,
    ) -> (Allowed, Verdict) {
        let Motion {
            pitch,
            stopping,
            forward_scale,
        } = motion;
        let parameters = &self.parameters;
        let bearable = if command.forward < 0.0 {
            self.limits.forward
        } else {
            self.limits.backward
        };
        let brake = min(bearable, parameters.braking);
        let backs_off = matches!(self.mode, Mode::BackingOff(_));
        let horizon = parameters.horizon + stopping * (parameters.acceleration / brake);
        let tipping = self.rotation.tipping(
            &self.stance,
            &self.found,
            parameters.uncertainty.deduction(),
            parameters.gyration,
        );
        let mut bounds = parameters.bounds(horizon, brake, tipping);
        if backs_off {
            // The trip itself watches the edge from which the robot backs off.
            bounds.away = Ramp {
                none: -NO_EDGE,
                all: -NO_EDGE,
            };
        }
        // A robot that is about to fall over its rear needs every way out. As driving forward ends,
        // backing and folding begin to pass, whatever may be behind the robot.
        let wide = bounds.towards.scale(self.margins.now[Edge::Back as usize]);
        let (posture_scale, posture) = ahead.map_or((1.0, Verdict::Passed), |ahead| {
            let margins = self.as_now(ahead.stance.margins());
            let evaluated = filter::posture(pitch, &self.margins, margins, &bounds);
            if !ahead.lifts {
                return evaluated;
            }
            step_behind::within(evaluated, self.room(), 1.0 - wide)
        });
        // The scale applies to what the robot can do, not to a larger command.
        let forward = clamp(command.forward, -parameters.speed, parameters.speed);
        let asked = Command::new(forward, command.yaw_rate);
        let driven = filter::speed_scale(asked, pitch, &self.margins, &bounds);
        let most = match forward {
            _ if backs_off => (f32::INFINITY, Edge::Back),
            forward if forward < 0.0 => (self.backward_limit(wide), Edge::Back),
            forward => (forward * forward_scale, Edge::Front),
        };
        let limited = filter::within_limit(driven, forward, most);
        let rise = parameters.speed * self.period;
        let (speed_scale, drive) = self.recovery.limit(limited, forward, self.speed, rise);
        // The command may lead away from an edge to which the robot still drives.
        let present = Command::new(self.speed, command.yaw_rate);
        let (present_scale, _) = filter::speed_scale(present, pitch, &self.margins, &bounds);
        let unhindered = Allowed {
            speed_scale: 1.0,
            stop: self.stop,
            brakes: false,
            posture: self.stop.is_none(),
            limits: MotionLimits::unlimited(parameters),
        };
        if !self.filter_active {
            return (unhindered, Verdict::Passed);
        }
        if self.mode == Mode::Overridden {
            let limits = MotionLimits {
                posture: OVERRIDE_POSTURE,
                ..unhindered.limits
            };
            return (
                Allowed {
                    limits,
                    ..unhindered
                },
                Verdict::Passed,
            );
        }
        let allowed = Allowed {
            speed_scale,
            stop: self.stop,
            brakes: speed_scale < 1.0 || present_scale < 1.0,
            posture: posture_scale > 0.0 && self.stop.is_none(),
            limits: MotionLimits {
                posture: posture_scale,
                ..self.limits
            },
        };
        let verdict = if drive == Verdict::Passed {
            posture
        } else {
            drive
        };
        (allowed, verdict)
    }

    /// Returns the margins of another shape, m, reduced by what uncertainty and measured force take
    /// from the present margins.
    fn as_now(&self, margins: [f32; 4]) -> [f32; 4] {
        let deduction = self.parameters.uncertainty.deduction();
        core::array::from_fn(|index| {
            let force = self.found.gravity[index] - self.margins.now[index];
            margins[index] - deduction - force
        })
    }

    /// Returns what the robot bears of a fall off a step behind it, as [`step_behind::room`]
    /// defines it, m.
    fn room(&self) -> f32 {
        let parameters = &self.parameters;
        let deduction = parameters.uncertainty.deduction();
        step_behind::room(&self.stance, &parameters.step_behind, deduction)
    }

    /// Returns the largest speed at which a fall off a step behind does not topple the robot, m/s.
    /// Backing at crawl speed stays free as far as the rear margin is not `wide` (0 to 1).
    fn backward_limit(&self, wide: f32) -> f32 {
        let crawl = (1.0 - wide) * self.parameters.crawl_speed;
        max(step_behind::speed(self.room()), crawl)
    }
}
