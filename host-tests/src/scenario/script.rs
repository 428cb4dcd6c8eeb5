//! Plays the operator's script during a run. The script reads only what is on the bus.

use super::{Belts, Clearance, Event, Operator, OperatorRequest, When};
use std::f64::consts::PI;

/// What the operator knows, decoded from frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BusView {
    /// Virtual time since power-up, s.
    pub time_s: f64,
    /// Odometry that the guard publishes, m.
    pub odometry_m: f64,
    /// Pitch that the guard publishes, rad.
    pub pitch: f64,
    /// Heading that the guard publishes, rad.
    pub heading: f64,
}

/// The command that the operator sends to the guard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ask {
    /// Forward speed, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, counter-clockwise positive.
    pub yaw_rate: f64,
    /// Chassis angle, rad, front up positive.
    pub theta: f64,
    /// Height of the step ahead, m; 0 commands no gait.
    pub step_m: f64,
    /// Clearance of Hylos, m; the scenario's own value if absent.
    pub clearance_m: Option<f64>,
    /// Whether the belts shall be released.
    pub belts: Belts,
    /// Who clears obstacles.
    pub clearance: Clearance,
    /// Request in addition to the motion.
    pub request: OperatorRequest,
}

/// A running script. It is made when the guard is armed, or at power-up, and takes all reference
/// values ("since arming") at that moment.
#[derive(Clone, Debug)]
pub struct Script {
    operator: Operator,
    next: usize,
    armed: BusView,
    last_event: BusView,
    last: BusView,
    speed_mps: f64,
    yaw_rate: Option<f64>,
    target: f64,
    theta: f64,
    step_m: f64,
    clearance_m: Option<f64>,
    belts: Belts,
    clearance: Clearance,
    request: OperatorRequest,
}

impl Script {
    /// Maximum yaw rate that the heading control commands, rad/s.
    pub const MOST_YAW_RATE: f64 = 0.3;

    /// Starts the script. `theta` is the robot's present chassis angle, rad, from which the
    /// commanded angle starts to move.
    pub fn new(operator: &Operator, now: BusView, theta: f64) -> Self {
        Self {
            operator: operator.clone(),
            next: 0,
            armed: now,
            last_event: now,
            last: now,
            speed_mps: operator.speed_mps,
            yaw_rate: None,
            target: operator.chassis_deg.to_radians(),
            theta,
            step_m: operator.step_m,
            clearance_m: None,
            belts: operator.belts.unwrap_or(Belts::Taut),
            clearance: operator.clearance.unwrap_or(Clearance::Manual),
            request: if operator.from_power_up {
                OperatorRequest::Stop
            } else {
                OperatorRequest::Arm
            },
        }
    }

    /// Adds an event behind the others.
    pub fn add(&mut self, event: Event) {
        self.operator.events.push(event);
    }

    /// The operator's request at present.
    pub fn request(&self) -> OperatorRequest {
        self.request
    }

    /// Number of events that have taken effect.
    pub fn events_done(&self) -> usize {
        self.next
    }

    /// The command at this time. At most one event takes effect per call; call at a fixed rate of
    /// 20 Hz or more.
    pub fn tick(&mut self, now: BusView) -> Ask {
        let holds = self
            .operator
            .events
            .get(self.next)
            .is_some_and(|event| self.holds(&event.when, now));
        if holds {
            let event = &self.operator.events[self.next];
            self.speed_mps = event.speed_mps.unwrap_or(self.speed_mps);
            self.yaw_rate = event.yaw_rate_deg_s.map(f64::to_radians).or(self.yaw_rate);
            self.step_m = event.step_m.unwrap_or(self.step_m);
            self.clearance_m = event.clearance_m.or(self.clearance_m);
            self.belts = event.belts.unwrap_or(self.belts);
            self.clearance = event.clearance.unwrap_or(self.clearance);
            self.request = event.request.unwrap_or(self.request);
            self.target = event.chassis_deg.map_or(self.target, f64::to_radians);
            self.last_event = now;
            self.next += 1;
        }
        let most = self.operator.chassis_rate_deg_s.to_radians()
            * (now.time_s - self.last.time_s).max(0.0);
        self.theta += (self.target - self.theta).clamp(-most, most);
        self.last = now;
        let error = (self.armed.heading - now.heading + PI).rem_euclid(2.0 * PI) - PI;
        let steer = (self.operator.heading_gain_per_s * error)
            .clamp(-Self::MOST_YAW_RATE, Self::MOST_YAW_RATE);
        Ask {
            speed_mps: self.speed_mps,
            yaw_rate: self.yaw_rate.unwrap_or(steer),
            theta: self.theta,
            step_m: self.step_m,
            clearance_m: self.clearance_m,
            belts: self.belts,
            clearance: self.clearance,
            request: self.request,
        }
    }

    fn holds(&self, when: &When, now: BusView) -> bool {
        let reached = |least: Option<f64>, got: f64| least.is_none_or(|least| got >= least);
        let pitch_deg = now.pitch.to_degrees();
        reached(when.time_s, now.time_s)
            && reached(when.after_s, now.time_s - self.last_event.time_s)
            && reached(when.odometry_m, now.odometry_m - self.armed.odometry_m)
            && reached(when.after_m, now.odometry_m - self.last_event.odometry_m)
            && when.pitch_above_deg.is_none_or(|angle| pitch_deg > angle)
            && when.pitch_below_deg.is_none_or(|angle| pitch_deg < angle)
    }
}
