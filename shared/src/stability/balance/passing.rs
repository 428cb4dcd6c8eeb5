//! Limits an admitted command to what the margins allow.

use super::Balance;
use crate::math::{max, min, sin_cos};
use crate::stability::allowed::{Ahead, Allowed, Command};
use crate::stability::filter::{Ramp, Verdict};
use crate::stability::limits::MotionLimits;
use crate::stability::support::{Edge, NO_EDGE};
use crate::stability::trip::Mode;
use crate::stability::{filter, step_behind, stopping};
use crate::units::Angle;

/// Speed scale of the posture in a supervised override.
const OVERRIDE_POSTURE: f32 = 0.25;

impl Balance {
    /// Limits an admitted command to what the margins allow. `ahead` is where the posture's motion
    /// leads within [`Self::horizon`]; `None` while the posture is at rest. `stopping` is the time
    /// of a stop at the configured deceleration, s.
    pub fn filter<P>(
        &self,
        command: &Command<P>,
        ahead: Option<&Ahead>,
        pitch: f32,
        stopping: f32,
    ) -> (Allowed, Verdict) {
        let parameters = &self.parameters;
        let bearable = if command.forward < 0.0 {
            self.limits.forward
        } else {
            self.limits.backward
        };
        // Harder braking is a reserve for the unforeseen.
        let brake = min(bearable, parameters.acceleration);
        let backs_off = matches!(self.mode, Mode::BackingOff(_));
        let horizon = parameters.horizon + stopping * (parameters.acceleration / brake);
        let mut bounds = parameters.bounds(horizon);
        if backs_off {
            // The trip itself watches the edge from which the robot backs off.
            bounds.away = Ramp {
                none: -NO_EDGE,
                all: -NO_EDGE,
            };
        }
        bounds.reserve =
            self.lifted(pitch) * filter::sway(Edge::Back, pitch) * bounds.towards.width();
        // A robot that is about to fall over its rear needs every way out. As driving forward ends,
        // backing and folding begin to pass, whatever may be behind the robot.
        let kept = bounds.towards.moved(bounds.reserve);
        let wide = kept.scale(self.margins.now[Edge::Back as usize]);
        let (posture_scale, posture) = ahead.map_or((1.0, Verdict::Passed), |ahead| {
            let margins = self.as_now(ahead.stance.margins());
            let evaluated = filter::posture(pitch, &self.margins, margins, &bounds);
            if !ahead.lifts {
                return evaluated;
            }
            step_behind::within(evaluated, self.room(), 1.0 - wide)
        });
        let driven = filter::speed_scale(command.speeds(), pitch, &self.margins, &bounds);
        let (speed_scale, drive) = if backs_off {
            driven
        } else {
            filter::within_limit(
                driven,
                command.forward,
                self.speed_limit(command.forward, wide),
            )
        };
        let unhindered = Allowed {
            speed_scale: 1.0,
            stop: self.stop,
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

    /// Returns how much the body counts as lifted, 0 to 1. A lifted body stands on its rear and on
    /// a front that lifts it, and it sways when either moves. The result rises from 0 to 1 while
    /// the sine of the body's pitch exceeds that of its support by 0.05 to 0.15. 0 for NaN.
    fn lifted(&self, pitch: f32) -> f32 {
        const LIFTED: Ramp = Ramp {
            none: 0.05,
            all: 0.15,
        };
        let [_, support] = self.stance.along();
        LIFTED.scale(sin_cos(Angle::from_radians(pitch)).0 - support)
    }

    /// Returns what the robot bears of a fall off a step behind it, as [`step_behind::room`]
    /// defines it, m.
    fn room(&self) -> f32 {
        let parameters = &self.parameters;
        let deduction = parameters.uncertainty.deduction();
        step_behind::room(&self.stance, &parameters.step_behind, deduction)
    }

    /// Returns the largest speed in the direction of a command at which neither an instant stop nor
    /// a fall off a step behind topples the robot, and the edge that limits it. Backing at crawl
    /// speed stays free as far as the rear margin is not `wide` (0 to 1).
    fn speed_limit(&self, forward: f32, wide: f32) -> (f32, Edge) {
        let deduction = self.parameters.uncertainty.deduction();
        let (limit, edge) = stopping::speed_limit(&self.stance, &self.found, forward, deduction);
        if edge == Edge::Front {
            return (limit, edge);
        }
        let crawl = (1.0 - wide) * self.parameters.crawl_speed;
        (
            min(limit, max(step_behind::speed(self.room()), crawl)),
            edge,
        )
    }
}
