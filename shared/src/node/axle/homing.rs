//! Homing: moves fast to the home switch, off it again, and slowly to it once more. The position
//! where the switch closes the second time becomes the home position.
//!
//! Object 0x6098 selects the method (`homing_method`). Methods that look for the edge at which a
//! switch opens are the same motion with the inverse of the switch as its signal.
//!
//! The switch is debounced: it counts as closed or open once it has been so for [`DEBOUNCE`] ticks
//! in a row. The position that counts is that of the first of them. Both approaches go in the same
//! direction, so that the hysteresis of the switch cancels. If they find the switch at different
//! places, one of them was wrong, and the axle stays unhomed.

use super::Axle;
use super::homing_method::{Method, NO_METHOD, PRESENT_POSITION, default_method};
use crate::constants::CONTROL_PERIOD;
use crate::math::Turns;
use crate::sensors::Switches;
use crate::settings::{Setting, Settings};

/// Stage of homing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Stage {
    Idle,
    /// Moves back from the positive limit switch to the switch that it has missed.
    Return,
    /// Moves off the switch, because homing began on it.
    Leave,
    /// Moves towards the switch until it closes.
    Seek,
    /// Moves away from the switch until it opens.
    BackOff,
    /// Moves slowly towards the switch until it closes again.
    Approach,
    Done,
    /// The switch was not found in time, or not within the travel.
    Failed,
    /// The two approaches found the switch at different places.
    Mismatch,
}

impl Stage {
    /// Returns whether homing is under way.
    pub fn is_running(self) -> bool {
        matches!(
            self,
            Self::Return | Self::Leave | Self::Seek | Self::BackOff | Self::Approach
        )
    }

    /// Returns whether homing has ended without a position.
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Failed | Self::Mismatch)
    }
}

/// Number of ticks in a row for which the switch must be closed, or open, to count as such.
const DEBOUNCE: u32 = 5;
/// Ticks of a stage after which the switch counts as not found.
const HOMING_TICKS: u32 = 20_000;
/// Ticks by which the switch may be seen late: one because it is read once per tick, and two for
/// its own reaction and that of its input. In these ticks the fast approach travels farther than
/// the slow one.
const REACTION_TICKS: f32 = 3.0;
/// Speed off the switch, as a fraction of the search speed.
const BACK_OFF: f32 = 0.5;

/// Parameters and state of homing.
#[derive(Clone, Debug)]
pub(super) struct Homing {
    pub stage: Stage,
    /// Code of the method with which homing starts next.
    pub code: i8,
    /// The axle has a reference to find.
    pub needed: bool,
    method: Method,
    /// Speed of the search, rad/s, and that of the second approach as a fraction of it.
    speed: f32,
    approach: f32,
    home_position: Turns,
    /// Largest allowed distance between the places that the two approaches find, 2^-32 turn.
    tolerance: u64,
    /// Ticks since the stage began.
    ticks: u32,
    /// Place where homing began, and how far it may move from there, 2^-32 turn.
    start: Turns,
    reach: u64,
    /// Debounced state of the switch, for how many ticks the switch has differed from it, and the
    /// position at the first of these ticks.
    closed: bool,
    differing: u32,
    changed_at: Turns,
    /// Place where the first approach found the switch.
    first: Turns,
    /// Second place minus first place, 2^-32 turn.
    pub difference: Turns,
}

impl Homing {
    /// Creates the homing of an axle whose switch is at `home_position`.
    pub fn new(settings: &Settings, home_position: Turns) -> Self {
        let speed = settings.si(Setting::HomingSpeed);
        let code = default_method(settings);
        let late = speed * REACTION_TICKS * CONTROL_PERIOD;
        let tolerance = settings.si(Setting::HomingTolerance) + late;
        Self {
            stage: Stage::Idle,
            code,
            needed: code != NO_METHOD,
            method: Method::of(code),
            speed,
            approach: settings.si(Setting::HomingApproach),
            home_position,
            tolerance: Turns::from_radians(tolerance).distance(),
            ticks: 0,
            start: Turns::ZERO,
            reach: 0,
            closed: false,
            differing: 0,
            changed_at: Turns::ZERO,
            first: Turns::ZERO,
            difference: Turns::ZERO,
        }
    }

    /// Starts homing from the beginning, at `position`, and with this reach.
    fn start(&mut self, switches: Switches, position: Turns, reach: u64) {
        self.method = Method::of(self.code);
        let closed = self.method.signal(switches);
        self.stage = if closed { Stage::Leave } else { Stage::Seek };
        self.ticks = 0;
        (self.start, self.reach) = (position, reach);
        self.closed = closed;
        self.differing = 0;
    }

    /// Ends homing unless it is done.
    pub fn abort(&mut self) {
        if self.stage != Stage::Done {
            self.stage = Stage::Idle;
        }
    }

    /// Reads the switch at `position`. Returns whether its debounced state changes in this tick.
    fn changes(&mut self, closed: bool, position: Turns) -> bool {
        if closed == self.closed {
            self.differing = 0;
            return false;
        }
        if self.differing == 0 {
            self.changed_at = position;
        }
        self.differing += 1;
        let changes = self.differing >= DEBOUNCE;
        if changes {
            self.closed = closed;
            self.differing = 0;
        }
        changes
    }

    /// Returns the velocity with which the axle moves in the present stage, rad/s.
    fn velocity(&self) -> f32 {
        let search = self.speed * f32::from(self.method.direction);
        match self.stage {
            Stage::Leave | Stage::BackOff => -BACK_OFF * search,
            Stage::Seek => search,
            Stage::Approach => search * self.approach,
            Stage::Return => -self.speed,
            _ => 0.0,
        }
    }

    /// Runs one tick at `position`. Returns the velocity with which to move, rad/s, and whether the
    /// place of the switch was found in this tick.
    fn tick(&mut self, switches: Switches, position: Turns) -> (f32, bool) {
        if !self.stage.is_running() {
            return (0.0, false);
        }
        self.ticks += 1;
        let moved = (position - self.start).distance();
        if self.ticks > HOMING_TICKS || moved > self.reach {
            self.stage = Stage::Failed;
            return (0.0, false);
        }
        let before = self.stage;
        let mut found = false;
        if self.changes(self.method.signal(switches), position) {
            self.stage = match self.stage {
                // The axle comes to the switch from its far side.
                Stage::Return if !self.method.opens => Stage::Leave,
                Stage::Return => Stage::Seek,
                Stage::Leave => Stage::Seek,
                Stage::Seek => {
                    self.first = self.changed_at;
                    Stage::BackOff
                }
                Stage::BackOff => Stage::Approach,
                _ => {
                    self.difference = self.changed_at - self.first;
                    found = self.difference.distance() <= self.tolerance;
                    if found { Stage::Done } else { Stage::Mismatch }
                }
            };
        }
        let mut velocity = self.velocity();
        if matches!(self.stage, Stage::Leave | Stage::Seek)
            && self.method.turns_round(switches, velocity)
        {
            self.stage = Stage::Return;
            velocity = self.velocity();
        }
        if self.stage != before {
            self.ticks = 0;
        }
        (velocity, found)
    }
}

impl Axle {
    /// Starts homing with the method that is selected.
    pub(super) fn start_homing(&mut self, switches: Switches) {
        match self.homing.code {
            PRESENT_POSITION => {
                self.homing.stage = Stage::Done;
                self.found_home(self.homing.home_position);
            }
            // An axle that is homed has nothing to do.
            NO_METHOD if self.homed => self.homing.stage = Stage::Done,
            NO_METHOD => self.homing.stage = Stage::Failed,
            _ => self.begin_homing(switches),
        }
    }

    fn begin_homing(&mut self, switches: Switches) {
        let (position, reach) = (self.position(), self.options.homing_reach());
        self.homing.start(switches, position, reach);
    }

    /// Sets the present position to `position`, and counts as homed.
    pub(super) fn found_home(&mut self, position: Turns) {
        self.encoder.set_position(position);
        // These are positions from before homing.
        self.end_stops.clear();
        self.anchor();
        if let Some(shaft) = &mut self.shaft {
            shaft.disregard();
        }
        self.homed = true;
    }

    /// Runs one tick of homing. An axle that still moves faster than homing allows decelerates
    /// first.
    pub(super) fn home(&mut self, switches: Switches) {
        if !self.envelopes.homing() {
            self.select_envelope();
            if !self.envelopes.homing() {
                self.motion
                    .toward_velocity(0.0, self.envelope.limits, CONTROL_PERIOD);
                return;
            }
            if self.homing.stage.is_running() {
                // The axle may have passed the switch.
                self.begin_homing(switches);
            }
        }
        let position = self.position();
        let (velocity, found) = self.homing.tick(switches, position);
        if found {
            let since = position - self.homing.changed_at;
            self.found_home(self.homing.home_position + since);
        }
        self.motion
            .toward_velocity(velocity, self.envelope.limits, CONTROL_PERIOD);
    }
}
