//! Draws the commands of a random operator: one change after the other, each after a random time.

use super::OPERATED_S;
use crate::scenario::{Event, OperatorRequest as Request, When};
use crate::tools::suite::draw::generator::Random;

/// Minimum and maximum time from one command to the next, s.
const PAUSE_S: [f64; 2] = [0.2, 3.0];
/// The same during a burst of fast commands, s.
const BURST_PAUSE_S: [f64; 2] = [0.02, 0.15];
/// Probability that a command begins a burst, and minimum and maximum number of commands in one.
const BURST: (f64, [f64; 2]) = (0.06, [5.0, 12.0]);

/// What the operator of one robot can command.
#[derive(Clone, Copy)]
pub struct Controls {
    /// Minimum and maximum forward speed, m/s.
    pub speed_mps: [f64; 2],
    /// Maximum yaw rate in both directions, degrees/s.
    pub yaw_deg_s: f64,
    /// Draws a posture and sets it in an event; `None` for a robot without posture.
    pub posture: Option<fn(&mut Random, &mut Event)>,
    /// Weights with which speed, yaw rate, posture and request are drawn.
    pub weights: [f64; 4],
}

#[derive(Clone, Copy)]
enum Control {
    Speed,
    Yaw,
    Posture,
    Request,
}

/// Draws the commands of a whole run.
pub fn commands(random: &mut Random, controls: &Controls) -> Vec<Event> {
    let (mut events, mut time_s, mut burst) = (Vec::new(), 0.0, 0.0);
    let mut request = Request::Arm;
    loop {
        if burst < 1.0 && random.chance(BURST.0) {
            burst = random.between(BURST.1[0], BURST.1[1]);
        }
        let [shortest, longest] = if burst >= 1.0 { BURST_PAUSE_S } else { PAUSE_S };
        burst -= 1.0;
        let pause = random.between(shortest, longest);
        time_s += pause;
        if time_s >= OPERATED_S {
            return events;
        }
        let mut event = Event {
            when: When {
                after_s: Some(pause),
                ..When::default()
            },
            ..Event::default()
        };
        command(random, controls, &mut request, &mut event);
        events.push(event);
    }
}

/// Draws the changes of one command: one change, or in one of five cases three, of which a later
/// one may replace an earlier one.
fn command(random: &mut Random, controls: &Controls, request: &mut Request, event: &mut Event) {
    let [speed, yaw, posture, requests] = controls.weights;
    let weights = [
        (Control::Speed, speed),
        (Control::Yaw, yaw),
        (Control::Posture, posture),
        (Control::Request, requests),
    ];
    let changes = if random.chance(0.2) { 3 } else { 1 };
    for _ in 0..changes {
        // An operator whose robot is stopped soon tries to drive on.
        let stopped = *request != Request::Arm && random.chance(0.4);
        let control = if stopped {
            Some(Control::Request)
        } else {
            random.weighted(&weights)
        };
        match (control, controls.posture) {
            (Some(Control::Yaw), _) => event.yaw_rate_deg_s = Some(yaw_rate(random, controls)),
            (Some(Control::Posture), Some(posture)) => posture(random, event),
            (Some(Control::Request), _) => {
                *request = next_request(random, *request);
                event.request = Some(*request);
            }
            _ => event.speed_mps = Some(speed_mps(random, controls)),
        }
    }
}

/// Draws a speed: one in eight is the minimum, one the maximum and one zero.
fn speed_mps(random: &mut Random, controls: &Controls) -> f64 {
    let [least, most] = controls.speed_mps;
    let exact = [
        (Some(least), 1.0),
        (Some(most), 1.0),
        (Some(0.0), 1.0),
        (None, 5.0),
    ];
    let drawn = random.between(least, most);
    random.weighted(&exact).flatten().unwrap_or(drawn)
}

/// Draws a yaw rate; one in three is zero.
fn yaw_rate(random: &mut Random, controls: &Controls) -> f64 {
    let drawn = random.between(-controls.yaw_deg_s, controls.yaw_deg_s);
    if random.chance(0.33) { 0.0 } else { drawn }
}

/// Draws the next request. Mostly it leads back to driving: a reset after an emergency stop, arming
/// after a stop or a reset.
fn next_request(random: &mut Random, before: Request) -> Request {
    let [stop, reset, arm, emergency_stop] = match before {
        Request::Arm => [0.45, 0.2, 0.1, 0.25],
        Request::EmergencyStop => [0.1, 0.6, 0.3, 0.0],
        _ => [0.05, 0.15, 0.75, 0.05],
    };
    let weights = [
        (Request::Stop, stop),
        (Request::Reset, reset),
        (Request::Arm, arm),
        (Request::EmergencyStop, emergency_stop),
    ];
    random.weighted(&weights).unwrap_or(Request::Arm)
}
