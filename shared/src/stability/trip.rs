//! Latches the guard's trip, stores its cause, and clears it on request only.
//!
//! While the guard is tripped, nothing passes. A reset clears a trip when the margins have
//! recovered and the sensors are trusted. It clears an emergency stop when that is released. After
//! a trip by a margin, two requests allow motion, each only as long as the operator makes it. In
//! the supervised override, the operator's own command passes at crawl speed. In backing off, the
//! robot drives back in the direction from which it came.

use super::allowed::Command;
use super::bands::Band;
use super::parameters::Parameters;
use super::support::Edge;
use crate::math::limit;
use crate::sensing::trust::{Reason, Trust};
use crate::sensors::BodySensors;

/// Largest yaw rate at crawl speed, rad/s.
const CRAWL_YAW_RATE: f32 = 0.1;
/// Distance by which the endangered margin may fall below its value at the start of backing off, m:
/// no more than the sensors' noise.
const BACK_OFF_LOSS: f32 = 0.01;

/// Distance back after which the robot counts as travelling in the other direction, um.
const TURNED_ROUND_UM: u32 = 50_000;

/// Cause of a trip.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cause {
    /// The margin to this edge is below the trip margin.
    Margin(Edge),
    /// The body sensors are not trusted.
    Sensors(Reason),
    /// The emergency stop is actuated.
    EmergencyStop,
}

impl Cause {
    /// Code in object 0x4007:1: 0x10 with the edge, 0x20 with the reason, or 0x30; 0 means no trip.
    pub fn code(self) -> u8 {
        match self {
            Self::Margin(edge) => 0x10 | edge as u8,
            Self::Sensors(reason) => 0x20 | reason as u8,
            Self::EmergencyStop => 0x30,
        }
    }
}

/// State of the guard when it tripped.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Snapshot {
    /// Cause of the trip.
    pub cause: Cause,
    /// Time since power-up, us.
    pub time_us: u64,
    /// Margins, m, indexed by [`Edge`].
    pub margins: [f32; 4],
    /// The edge with the narrowest margin.
    pub edge: Edge,
    /// Commanded motion.
    pub command: Command<()>,
    /// Forward speed that was passed on, m/s.
    pub speed: f32,
    /// Newest reading of the body sensors.
    pub sensors: BodySensors,
}

/// Requests to a tripped guard, other than motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[allow(clippy::struct_excessive_bools)] // independent requests, not states
pub struct Requests {
    /// Clear the trip. A change to true counts, not the state.
    pub reset: bool,
    /// Supervised override, for as long as it is true.
    pub override_trip: bool,
    /// Back off, for as long as it is true.
    pub back_off: bool,
    /// The emergency stop is actuated.
    pub emergency_stop: bool,
}

/// Inputs of the latch at one evaluation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Inputs {
    /// Whether the guard is armed. Only an armed guard trips, except for the emergency stop.
    pub armed: bool,
    /// Current band.
    pub band: Band,
    /// Trust in the body sensors.
    pub trust: Trust,
    /// Distance travelled by the encoders, forward positive, um; wraps.
    pub odometry_um: i32,
    /// Snapshot to store if the guard trips; its cause is replaced.
    pub snapshot: Snapshot,
}

/// What the latch lets pass.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Mode {
    /// The part of the command that the filter allows.
    #[default]
    Open,
    /// Nothing.
    Tripped,
    /// The operator's command at crawl speed, without the filter.
    Overridden,
    /// Crawl speed in this direction: 1 forward, -1 back.
    BackingOff(f32),
}

impl Mode {
    /// Command that the filter receives. It never exceeds `command`, except for
    /// [`Mode::BackingOff`], which sets its own command.
    pub fn admit(self, command: Command<()>, parameters: &Parameters) -> Command<()> {
        match self {
            Self::Open => command,
            Self::Tripped => Command::default(),
            Self::Overridden => crawl(command, parameters),
            Self::BackingOff(direction) => {
                Command::new(limit(direction, 1.0) * parameters.crawl_speed, 0.0)
            }
        }
    }
}

/// Limits a command to crawl speed.
pub fn crawl(command: Command<()>, parameters: &Parameters) -> Command<()> {
    Command::new(
        limit(command.forward, parameters.crawl_speed),
        limit(command.yaw_rate, CRAWL_YAW_RATE),
    )
}

/// Direction of the robot's last travel, by its odometry.
#[derive(Clone, Copy, Debug, Default)]
struct Travel {
    /// 1 forward, -1 backward, 0 before the first travel.
    direction: i32,
    /// Farthest place in this direction, um.
    farthest_um: Option<i32>,
}

impl Travel {
    /// Takes the present place. The direction turns round where the robot has come back by
    /// [`TURNED_ROUND_UM`] from the farthest place.
    fn update(&mut self, odometry_um: i32) {
        let since = odometry_um.wrapping_sub(*self.farthest_um.get_or_insert(odometry_um));
        if since.unsigned_abs() >= TURNED_ROUND_UM {
            self.direction = since.signum();
        }
        if since.signum() == self.direction {
            self.farthest_um = Some(odometry_um);
        }
    }
}

/// Latch of the guard's trip.
#[derive(Clone, Debug, Default)]
pub struct Trip {
    latched: bool,
    snapshot: Option<Snapshot>,
    /// Trip that an emergency stop has replaced.
    covered: Option<Snapshot>,
    count: u16,
    /// Direction of the last travel, now and at the trip.
    travel: Travel,
    travelled: i32,
    reset_before: bool,
    /// Margin when backing off began.
    back_off_from: Option<f32>,
    /// Whether backing off has ended; it does not begin again until the request was withdrawn.
    back_off_over: bool,
}

impl Trip {
    /// Updates the latch at one evaluation, and returns what may pass.
    pub fn update(&mut self, inputs: &Inputs, requests: Requests, parameters: &Parameters) -> Mode {
        self.travel.update(inputs.odometry_um);
        let asked_to_reset = requests.reset && !self.reset_before;
        self.reset_before = requests.reset;
        let back = inputs.band < Band::Limit && matches!(inputs.trust, Trust::Full);
        let stopped = self.cause() == Some(Cause::EmergencyStop);
        // A robot that is not armed stands still, so any margin allows the reset. If the margin is
        // still too small, it trips the guard once it is armed.
        let back = back || !inputs.armed;
        if asked_to_reset && (back || stopped) && !requests.emergency_stop {
            self.latched = false;
            if let Some(covered) = self.covered.take().filter(|_| !back) {
                (self.latched, self.snapshot) = (true, Some(covered));
            }
        }
        // An emergency stop replaces any other cause.
        let kept = self.latched && (stopped || !requests.emergency_stop);
        if let Some(cause) = Self::new_cause(inputs, requests).filter(|_| !kept) {
            self.covered = self.snapshot.filter(|_| self.latched);
            self.latched = true;
            self.travelled = self.travel.direction;
            self.count = self.count.saturating_add(1);
            self.snapshot = Some(Snapshot {
                cause,
                ..inputs.snapshot
            });
        }
        let direction = self.back_off(inputs, requests, parameters);
        if !self.latched {
            Mode::Open
        } else if requests.override_trip && matches!(self.cause(), Some(Cause::Margin(_))) {
            Mode::Overridden
        } else {
            direction.map_or(Mode::Tripped, Mode::BackingOff)
        }
    }

    /// Cause of the present trip, if the guard is tripped.
    fn cause(&self) -> Option<Cause> {
        let snapshot = self.snapshot.as_ref().filter(|_| self.latched)?;
        Some(snapshot.cause)
    }

    fn new_cause(inputs: &Inputs, requests: Requests) -> Option<Cause> {
        if requests.emergency_stop {
            return Some(Cause::EmergencyStop);
        }
        match (inputs.armed && inputs.band == Band::Stop, inputs.trust) {
            (false, _) => None,
            (true, Trust::None(reason)) => Some(Cause::Sensors(reason)),
            (true, _) => Some(Cause::Margin(inputs.snapshot.edge)),
        }
    }

    /// Direction of backing off: back along the travel that led to the trip, or against the command
    /// if the robot had not travelled yet. `None` if there was neither. Ends when the
    /// endangered margin shrinks, or when it is back above the caution margin.
    fn back_off(
        &mut self,
        inputs: &Inputs,
        requests: Requests,
        parameters: &Parameters,
    ) -> Option<f32> {
        if !(requests.back_off && self.latched) {
            (self.back_off_from, self.back_off_over) = (None, false);
            return None;
        }
        let snapshot = self.snapshot.filter(|_| parameters.back_off)?;
        let Cause::Margin(edge) = snapshot.cause else {
            return None;
        };
        let margin = *inputs.snapshot.margins.get(edge as usize)?;
        let from = *self.back_off_from.get_or_insert(margin);
        // Both comparisons are false for NaN, which ends backing off.
        let on_the_way = margin < parameters.caution && margin > from - BACK_OFF_LOSS;
        self.back_off_over |= !on_the_way || !matches!(inputs.trust, Trust::Full);
        let way = match self.travelled {
            0 => snapshot.command.forward,
            travelled => travelled as f32,
        };
        if self.back_off_over || !(way.abs() > 0.0) {
            return None;
        }
        Some(if way > 0.0 { -1.0 } else { 1.0 })
    }

    /// Whether the guard is tripped.
    pub fn latched(&self) -> bool {
        self.latched
    }

    /// State at the last trip, also after it was cleared.
    pub fn snapshot(&self) -> Option<&Snapshot> {
        self.snapshot.as_ref()
    }

    /// Number of trips since power-up.
    pub fn count(&self) -> u16 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::super::support::narrowest;
    use super::*;
    use crate::settings::Settings;

    const RESET: Requests = Requests {
        reset: true,
        override_trip: false,
        back_off: false,
        emergency_stop: false,
    };
    const OVERRIDE: Requests = Requests {
        reset: false,
        override_trip: true,
        ..RESET
    };
    const BACK_OFF: Requests = Requests {
        reset: false,
        back_off: true,
        ..RESET
    };
    const STOP: Requests = Requests {
        reset: false,
        emergency_stop: true,
        ..RESET
    };
    const NONE: Requests = Requests {
        reset: false,
        ..RESET
    };
    const COMMANDED: Command<()> = Command::new(0.13, 0.3);

    fn parameters() -> Parameters {
        Parameters {
            back_off: true,
            ..Parameters::new(&Settings::default())
        }
    }

    fn inputs(back: f32, band: Band) -> Inputs {
        let margins = [back, 0.3, 0.2, 0.2];
        Inputs {
            armed: true,
            band,
            trust: Trust::Full,
            odometry_um: 0,
            snapshot: Snapshot {
                cause: Cause::EmergencyStop,
                time_us: 7,
                margins,
                edge: narrowest(&margins),
                command: COMMANDED,
                speed: 0.1,
                sensors: BodySensors::default(),
            },
        }
    }

    /// The robot drives there and back before it trips. By then the stick is centred or pulled
    /// back.
    #[test]
    fn backing_off_leads_back_along_the_way_whatever_the_stick_was_at_last() {
        for (there, back, expected) in [
            (600_000, 0, -1.0),
            (600_000, 40_000, -1.0),
            (600_000, 60_000, 1.0),
            (-600_000, -40_000, 1.0),
            (-600_000, -60_000, -1.0),
        ] {
            for forward in [0.0, 0.13, -0.13] {
                let mut trip = Trip::default();
                let parameters = parameters();
                let mut odometry_um = i32::MAX - 300_000;
                let mut good = inputs(0.2, Band::Free);
                for distance in [there, -back] {
                    for _ in 0..100 {
                        odometry_um = odometry_um.wrapping_add(distance / 100);
                        good.odometry_um = odometry_um;
                        trip.update(&good, NONE, &parameters);
                    }
                }
                let mut narrow = inputs(0.005, Band::Stop);
                narrow.odometry_um = odometry_um;
                narrow.snapshot.command.forward = forward;
                trip.update(&narrow, NONE, &parameters);
                // The stick no longer counts, nor does what backing off itself travels.
                narrow.snapshot.command.forward = 0.0;
                for _ in 0..3 {
                    let mode = trip.update(&narrow, BACK_OFF, &parameters);
                    assert_eq!(mode, Mode::BackingOff(expected), "{there} {back} {forward}");
                    narrow.odometry_um = narrow.odometry_um.wrapping_add(expected as i32 * 40_000);
                }
            }
        }
    }

    #[test]
    fn a_robot_that_never_travelled_backs_off_against_its_command_or_not_at_all() {
        for (forward, expected) in [
            (0.13, Mode::BackingOff(-1.0)),
            (-0.13, Mode::BackingOff(1.0)),
            (0.0, Mode::Tripped),
        ] {
            let mut trip = Trip::default();
            let mut narrow = inputs(0.005, Band::Stop);
            narrow.snapshot.command.forward = forward;
            trip.update(&narrow, NONE, &parameters());
            assert_eq!(trip.update(&narrow, BACK_OFF, &parameters()), expected);
        }
    }

    fn tripped() -> Trip {
        let mut trip = Trip::default();
        let mode = trip.update(&inputs(0.005, Band::Stop), NONE, &parameters());
        assert_eq!(mode, Mode::Tripped);
        trip
    }

    #[test]
    fn it_latches_with_what_was_known_and_nothing_clears_it_but_a_reset_with_the_margin_back() {
        let mut trip = tripped();
        let kept = *trip.snapshot().expect("a snapshot");
        assert_eq!(
            (kept.cause, kept.time_us, kept.command),
            (Cause::Margin(Edge::Back), 7, COMMANDED)
        );
        let parameters = parameters();
        let good = inputs(0.2, Band::Free);
        assert_eq!(trip.update(&good, NONE, &parameters), Mode::Tripped);
        // The first reset is too early and then held: the request must be made again.
        assert_eq!(
            trip.update(&inputs(0.04, Band::Limit), RESET, &parameters),
            Mode::Tripped
        );
        assert_eq!(trip.update(&good, RESET, &parameters), Mode::Tripped);
        trip.update(&good, NONE, &parameters);
        assert_eq!(trip.update(&good, RESET, &parameters), Mode::Open);
        assert_eq!((trip.snapshot(), trip.count()), (Some(&kept), 1));
    }

    #[test]
    fn an_emergency_stop_takes_the_place_of_a_trip_and_takes_a_reset_of_its_own() {
        let mut trip = tripped();
        let (narrow, parameters) = (inputs(0.005, Band::Stop), parameters());
        trip.update(&narrow, STOP, &parameters);
        let cause = |trip: &Trip| trip.snapshot().map(|kept| kept.cause);
        assert_eq!(cause(&trip), Some(Cause::EmergencyStop));
        // After its release it is still latched: neither override nor backing off allows motion.
        for requests in [OVERRIDE, BACK_OFF, NONE] {
            assert_eq!(trip.update(&narrow, requests, &parameters), Mode::Tripped);
        }
        // The reset clears the emergency stop, and the trip by the margin is back in the same
        // evaluation.
        assert_eq!(trip.update(&narrow, RESET, &parameters), Mode::Tripped);
        assert_eq!(cause(&trip), Some(Cause::Margin(Edge::Back)));
        assert_eq!(
            trip.update(&narrow, OVERRIDE, &parameters),
            Mode::Overridden
        );
    }

    #[test]
    fn an_override_passes_the_operator_s_command_at_crawl_speed() {
        let mut trip = tripped();
        let mode = trip.update(&inputs(0.005, Band::Stop), OVERRIDE, &parameters());
        assert_eq!(
            mode.admit(COMMANDED, &parameters()),
            Command::new(0.05, 0.1)
        );
        let small = Command::new(-0.01, 0.0);
        assert_eq!(mode.admit(small, &parameters()), small);
        assert_eq!(
            trip.update(&inputs(0.005, Band::Stop), NONE, &parameters()),
            Mode::Tripped
        );
    }

    #[test]
    fn backing_off_goes_back_the_way_until_the_margin_is_back_or_shrinks() {
        let mut trip = tripped();
        let parameters = parameters();
        for back in [0.005, 0.02, 0.06] {
            let mode = trip.update(&inputs(back, Band::Stop), BACK_OFF, &parameters);
            assert_eq!(mode, Mode::BackingOff(-1.0));
            assert_eq!(mode.admit(COMMANDED, &parameters), Command::new(-0.05, 0.0));
        }
        assert_eq!(
            trip.update(&inputs(0.095, Band::Caution), BACK_OFF, &parameters),
            Mode::Tripped
        );
        for bad in [-0.01, f32::NAN] {
            let mut trip = tripped();
            trip.update(&inputs(0.005, Band::Stop), BACK_OFF, &parameters);
            assert_eq!(
                trip.update(&inputs(bad, Band::Stop), BACK_OFF, &parameters),
                Mode::Tripped
            );
            // It does not begin again until it is requested anew.
            assert_eq!(
                trip.update(&inputs(0.02, Band::Stop), BACK_OFF, &parameters),
                Mode::Tripped
            );
        }
        let forbidden = Parameters {
            back_off: false,
            ..parameters
        };
        assert_eq!(
            tripped().update(&inputs(0.02, Band::Stop), BACK_OFF, &forbidden),
            Mode::Tripped
        );
    }

    #[test]
    fn an_emergency_stop_trips_an_unarmed_guard_too_and_no_override_passes_it() {
        let mut trip = Trip::default();
        let standing = Inputs {
            armed: false,
            ..inputs(0.2, Band::Free)
        };
        assert_eq!(trip.update(&standing, STOP, &parameters()), Mode::Tripped);
        let both = Requests {
            override_trip: true,
            ..STOP
        };
        assert_eq!(trip.update(&standing, both, &parameters()), Mode::Tripped);
        let still = Requests {
            reset: true,
            ..STOP
        };
        assert_eq!(trip.update(&standing, still, &parameters()), Mode::Tripped);
        trip.update(&standing, NONE, &parameters());
        assert_eq!(trip.update(&standing, RESET, &parameters()), Mode::Open);
    }
}
