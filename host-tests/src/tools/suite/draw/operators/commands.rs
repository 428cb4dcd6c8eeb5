//! What a random operator commands: one change after the other, each after a random time.

use super::OPERATED_S;
use crate::scenario::{Event, OperatorRequest as Request, When};
use crate::tools::suite::draw::generator::Random;

/// Time from one command to the next, s.
const PAUSE_S: [f64; 2] = [0.2, 3.0];
/// The same while the operator presses everything, s.
const BURST_PAUSE_S: [f64; 2] = [0.02, 0.15];
/// Share of commands that begin a burst, and number of commands in one.
const BURST: (f64, [f64; 2]) = (0.06, [5.0, 12.0]);

/// What one robot's operator can command.
#[derive(Clone, Copy)]
pub struct Controls {
    /// Forward speed, m/s.
    pub speed_mps: [f64; 2],
    /// Yaw rate, degrees/s.
    pub yaw_deg_s: f64,
    /// The robot's posture, in an event; nothing for a robot without.
    pub posture: Option<fn(&mut Random, &mut Event)>,
    /// Weights of speed, yaw, posture and request.
    pub weights: [f64; 4],
}

#[derive(Clone, Copy)]
enum Control {
    Speed,
    Yaw,
    Posture,
    Request,
}

/// The commands of a whole run.
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

/// Sets what one command changes: one thing, in one of five cases several at once.
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
        // An operator whose robot stands soon tries to drive on.
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

/// Any speed, one in four at an end of the range, one in eight zero.
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

/// Any yaw rate, one in three zero.
fn yaw_rate(random: &mut Random, controls: &Controls) -> f64 {
    let drawn = random.between(-controls.yaw_deg_s, controls.yaw_deg_s);
    if random.chance(0.33) { 0.0 } else { drawn }
}

/// Mostly what leads back to driving: a reset after an emergency stop, arming after all others.
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
