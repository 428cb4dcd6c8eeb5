//! Random sequences of a drive under a guard that commands in good order, while others interfere.
//!
//! A sequence contains restarts, a second master at any phase and rate, forged frames of each
//! identifier that the drive receives, what a client has written before the guard, limit switches,
//! a software position limit, and loads up to twice the holding torque. `DRIVE_SEQUENCES_SEED`
//! repeats one sequence.

use super::drive_faults::generator::Random;
use super::drive_faults::on_all_processors;
use super::sweep::{complete, unless_unchanged};
use super::wire::{GUARD, ID, JOINT, Wire, motion, set_point};
use tautrack::bus::cia402::{State, mode};
use tautrack::bus::network::sync;
use tautrack::bus::pdo::{Payload, TorqueOffset, receive};
use tautrack::can::Frame;
use tautrack::faults::{ALL, Fault, Reaction};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

/// Number of sequences in a complete campaign and in a short one.
const SEQUENCES: [u64; 2] = [100_000, 5_000];
const EVENTS: u64 = 10;

/// Torque of the hold current of 6 A, N m, and velocity limits of axle and screw, rad/s.
const HOLDING_TORQUE: f64 = 14.4;
const LIMIT: f64 = 6.0;
const SCREW_LIMIT: f64 = 140.0;
/// Time within which a hold is supervised, ms, with the ramp of a drive that a load has turned at 1
/// rad/s before.
const REPORTED_MS: u64 = 50 + 50;

/// What the guard wants.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Goal {
    Off,
    Hold,
    Stand,
    Move(i32),
    Taut,
    /// Release the belt by this slack, 2^-24 m.
    Release(i32),
}

impl Goal {
    /// Returns the guard's frame to a drive in `state`.
    fn frame(self, state: State) -> Frame {
        let up = tautrack::bus::cia402::toward_operation(state);
        match self {
            Self::Off => set_point(0x00, 0, 0),
            Self::Hold => set_point(0x02, 0, 0),
            Self::Stand => set_point(up, mode::CYCLIC_VELOCITY, 0),
            Self::Move(speed) => set_point(up, mode::CYCLIC_VELOCITY, speed),
            Self::Taut => set_point(up, mode::TAUT, 0),
            Self::Release(slack) => set_point(up, mode::RELEASED, slack),
        }
    }
}

/// How often what was looked for has happened.
#[derive(Clone, Copy, Default, Debug)]
struct Tally {
    operated: u64,
    held: u64,
    off: u64,
    interfered: u64,
    faults: u64,
    restarts: u64,
    at_an_end: u64,
    overloaded: u64,
}

impl Tally {
    fn counts(&self) -> [u64; 8] {
        [
            self.operated,
            self.held,
            self.off,
            self.interfered,
            self.faults,
            self.restarts,
            self.at_an_end,
            self.overloaded,
        ]
    }
}

struct Sequence {
    random: Random,
    screw: bool,
    wire: Wire,
    goal: Goal,
    /// Frames of the others, each sent every so many milliseconds.
    foreign: Vec<(Frame, u64, u64)>,
    /// Where the drive has come to a stand that it must keep, and for how long it has been still,
    /// ms.
    stands: Option<f64>,
    still: u64,
    /// When a load began to turn it away from there, ms.
    slips_ms: Option<u64>,
    /// Time for which the guard has commanded otherwise than "off", ms.
    wanted_ms: u64,
    /// Shaft angle at which the positive limit switch closes.
    switch_at: f64,
    farthest: f64,
}

impl Sequence {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let screw = random.once_in(3);
        let mut sequence = Self {
            wire: Self::wire(screw),
            random,
            screw,
            goal: Goal::Hold,
            foreign: Vec::new(),
            stands: None,
            still: 0,
            slips_ms: None,
            wanted_ms: 0,
            switch_at: f64::INFINITY,
            farthest: f64::INFINITY,
        };
        sequence.leave();
        sequence
    }

    fn wire(screw: bool) -> Wire {
        if screw {
            Wire::screw(&[])
        } else {
            Wire::axle(&[
                (Setting::PositionMinimum, -30_000),
                (Setting::PositionMaximum, 30_000),
            ])
        }
    }

    /// What a client leaves behind before the guard's first heartbeat.
    fn leave(&mut self) {
        if self.random.once_in(2) {
            return;
        }
        let (random, wire) = (&mut self.random, &mut self.wire);
        wire.write((0x605a, 0), random.pick(&[0_i16, 1, 2, 5, 6]).to_le_bytes());
        wire.write((0x605b, 0), random.pick(&[0_i16, 1]).to_le_bytes());
        wire.write((0x605e, 0), random.pick(&[0_i16, 1, 2]).to_le_bytes());
        wire.write((0x6098, 0), random.pick(&[0_i8, 17, 20, 37]).to_le_bytes());
        wire.write((0x607d, 1), (random.bits() as i32).to_le_bytes());
        wire.write((0x607d, 2), (random.bits() as i32).to_le_bytes());
    }

    /// The node restarts, the rotor keeps its place.
    fn restart(&mut self) {
        let old = std::mem::replace(&mut self.wire, Self::wire(self.screw));
        (self.wire.now_us, self.wire.rotor.angle) = (0, old.rotor.angle);
        (self.wire.rotor.load, self.wire.joint) = (old.rotor.load, old.joint);
        self.leave();
        (self.stands, self.wanted_ms) = (None, 0);
        self.farthest = f64::INFINITY;
    }

    fn next_event(&mut self, tally: &mut Tally) -> u64 {
        if self.random.once_in(12) {
            tally.restarts += 1;
            self.restart();
        }
        let random = &mut self.random;
        let speed = random.pick(&[1_000_000, -3_000_000, 5_900_000]);
        self.goal = match random.below(8) {
            0 => Goal::Off,
            1 | 2 => Goal::Hold,
            3 => Goal::Stand,
            4 if self.screw => Goal::Release(random.pick(&[1, 300_000, 2_000_000, -5, i32::MAX])),
            _ if self.screw => Goal::Taut,
            _ => Goal::Move(speed),
        };
        if random.once_in(3) {
            let part = random.pick(&[0.0, 0.0, 0.4, -0.8, 1.1, -1.5, 2.0]);
            let most = if self.screw { 0.96 } else { HOLDING_TORQUE };
            if self.wire.rotor.load.abs() > 0.9 * most {
                // The load may have turned the drive already.
                self.stands = None;
            }
            self.still = 0;
            self.wire.rotor.load = part * most;
        }
        if random.once_in(6) {
            let near = random.pick(&[0.1, 1.0, f64::INFINITY]);
            self.switch_at = self.wire.rotor.angle + near;
        }
        self.foreign.clear();
        if !matches!(self.goal, Goal::Hold | Goal::Stand) {
            self.stands = None;
        }
        for _ in 0..random.pick(&[0, 0, 1, 1, 2]) {
            let frame = self.foreign_frame();
            let every = self.random.pick(&[1, 2, 4, 5, 9, 40, 170]);
            self.foreign.push((frame, every, self.random.below(every)));
        }
        60 + self.random.below(120)
    }

    /// Returns a frame with an identifier that the drive receives. The guard's heartbeat is that of
    /// a guard that waits.
    fn foreign_frame(&mut self) -> Frame {
        let random = &mut self.random;
        let word = random.pick(&[
            0x00, 0x02, 0x06, 0x07, 0x0f, 0x0f, 0x0f, 0x8f, 0x82, 0x10f, 0x1f,
        ]);
        let mode = random.pick(&[9, 9, 3, 8, 1, 10, 6, -1, -2, 0]);
        let target = random.pick(&[0, 5_900_000, -5_900_000, 300, -300, i32::MAX]);
        let own = random.pick(&[0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700]);
        match random.below(9) {
            0 => Frame::new(own + u16::from(ID), &[5; 8]).unwrap(),
            1 => sync(),
            2 => Frame::new(0x700 + u16::from(GUARD), &[127]).unwrap(),
            3 => TorqueOffset {
                // 1 N m. The guard, which sends none here, is needed to find a larger one.
                torque: random.pick(&[0, 100, -100]),
            }
            .frame(receive(3), ID),
            4 => motion(
                random.pick(&[0.0, 0.3, 1.0, -2.0]),
                random.pick(&[0.0, 2.0]),
            ),
            5 => Frame::new(0x180 + u16::from(JOINT) + 1, &[1; 8]).unwrap(),
            _ => set_point(word, mode, target),
        }
    }

    fn tick(&mut self, tally: &mut Tally) -> Result<(), String> {
        let now = self.wire.milliseconds() + 1;
        let first = self.wire.last().is_none();
        let (powered, state) = if first {
            (false, State::SwitchOnDisabled)
        } else {
            (self.wire.powered(), self.wire.state())
        };
        self.wire.command = Some(self.goal.frame(state));
        let due = self
            .foreign
            .iter()
            .filter(|(_, every, at)| now % every == *at);
        let frames: Vec<_> = due.map(|(frame, ..)| *frame).collect();
        self.wire.rotor.switches = Switches {
            positive_limit: self.wire.rotor.angle >= self.switch_at,
            ..Switches::default()
        };
        self.wire.tick(&frames);
        tally.interfered += u64::from(!frames.is_empty());
        // Each set-point of another sender may move the drive by some travel, until the drive finds
        // that sender.
        let set_points = frames.iter().any(is_set_point);
        if self.goal == Goal::Stand && set_points && !self.wire.has(Fault::SecondMaster) {
            self.stands = self.stands.map(|_| self.wire.rotor.angle);
        }
        self.wanted_ms = if self.goal == Goal::Off {
            0
        } else {
            self.wanted_ms + 1
        };
        self.lets_go(powered, tally)?;
        self.moves(tally)?;
        self.at_switch(tally)
    }

    /// A drive under power lets go only by its own fault, or if the guard commands it.
    fn lets_go(&self, powered: bool, tally: &mut Tally) -> Result<(), String> {
        let state = self.wire.state();
        tally.operated += u64::from(state == State::OperationEnabled);
        tally.held += u64::from(state == State::QuickStopActive);
        let faults = self.wire.outputs().faults;
        tally.faults += u64::from(!faults.is_empty());
        if !powered || self.wire.powered() {
            return Ok(());
        }
        tally.off += 1;
        let own = ALL
            .iter()
            .any(|fault| faults.contains(*fault) && fault.description().reaction != Reaction::Hold);
        if self.goal == Goal::Off || own {
            return Ok(());
        }
        Err("a drive under power lets go".to_owned())
    }

    /// While the guard commands no motion, nobody else moves the drive. A load that the drive
    /// cannot hold is reported.
    fn moves(&mut self, tally: &mut Tally) -> Result<(), String> {
        let faulty = !self.wire.outputs().faults.is_empty();
        // A velocity of zero is no place: a load moves the drive while the loop takes it up.
        let stands = self.goal == Goal::Stand && self.wire.rotor.load == 0.0;
        let quiet = self.goal == Goal::Hold || stands || faulty;
        let (angle, now) = (self.wire.rotor.angle, self.wire.milliseconds());
        let limit = if self.screw { SCREW_LIMIT } else { LIMIT };
        let slow = self.wire.rotor.velocity.abs() < 0.02 * limit;
        self.still = if slow { self.still + 1 } else { 0 };
        if !quiet || !self.wire.powered() {
            (self.stands, self.slips_ms) = (None, None);
            return Ok(());
        }
        let Some(start) = self.stands else {
            self.stands = (self.still > 40).then_some(angle);
            return Ok(());
        };
        let moved = (angle - start).abs();
        let holding = if self.screw { 0.96 } else { HOLDING_TORQUE };
        let far = moved > 20e-3 * limit;
        if self.wire.rotor.load.abs() > 0.9 * holding {
            if self.wire.has(Fault::HoldOverload) {
                // The report has come in time. It may be reset.
                tally.overloaded += 1;
                (self.stands, self.still, self.slips_ms) = (None, 0, None);
            } else if far {
                let holds = self.wire.state() == State::QuickStopActive;
                let since = *self.slips_ms.get_or_insert(now);
                if !holds {
                    self.slips_ms = Some(now);
                } else if now - since > REPORTED_MS && !faulty && self.goal == Goal::Hold {
                    return Err(format!("slips by {moved} rad without a report"));
                }
            }
            return Ok(());
        }
        if self.slips_ms.take().is_some() || self.wire.has(Fault::HoldOverload) {
            // It goes back to where it was.
            (self.stands, self.still) = (None, 0);
        } else if far {
            return Err(format!(
                "moves by {moved} rad without a command of the guard"
            ));
        }
        Ok(())
    }

    /// A closed switch ends motion outward, unless the load pushes.
    fn at_switch(&mut self, tally: &mut Tally) -> Result<(), String> {
        let (angle, velocity) = (self.wire.rotor.angle, self.wire.rotor.velocity.max(0.0));
        if !self.wire.rotor.switches.positive_limit
            || !self.wire.powered()
            || self.wire.rotor.load != 0.0
        {
            self.farthest = f64::INFINITY;
            return Ok(());
        }
        tally.at_an_end += 1;
        // A drive that a load has pulled inward comes back.
        if self.farthest == f64::INFINITY && self.still < 40 {
            return Ok(());
        }
        let (braking, overshoot) = if self.screw { (1e-3, 2.0) } else { (0.01, 0.1) };
        self.farthest = self
            .farthest
            .min(angle + overshoot + braking * velocity * velocity);
        if angle > self.farthest {
            return Err(format!("{} rad outward of a switch", angle - self.farthest));
        }
        Ok(())
    }
}

/// Returns whether the frame is a set-point of the drive.
fn is_set_point(frame: &Frame) -> bool {
    let id = frame.id();
    id == receive(1) + u16::from(ID) || id == receive(2) + u16::from(ID)
}

fn run(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut sequence = Sequence::new(seed);
    for event in 0..EVENTS {
        for _ in 0..sequence.next_event(tally) {
            sequence.tick(tally).map_err(|broken| {
                format!(
                    "seed {seed}, event {event}: {broken}\n{:?}, load {}, {:?}\n{:?}",
                    sequence.goal,
                    sequence.wire.rotor.load,
                    sequence.foreign,
                    sequence.wire.last()
                )
            })?;
        }
    }
    Ok(())
}

#[test]
fn nobody_but_the_guard_moves_a_drive_or_makes_it_let_go() {
    if let Ok(seed) = std::env::var("DRIVE_SEQUENCES_SEED") {
        let seed = seed.parse().expect("a number");
        run(seed, &mut Tally::default()).unwrap_or_else(|broken| panic!("{broken}"));
        return;
    }
    let sources = ["src", "tests/node/sequences.rs", "tests/node/wire.rs"];
    unless_unchanged("drive-sequences", &sources, run_all);
}

fn run_all() {
    let [all, short] = SEQUENCES;
    let sequences = if complete() { all } else { short };
    let tallies: Vec<Tally> = on_all_processors(sequences, run);
    println!("{tallies:#?}");
    // In the order of the fields.
    let counts = tallies.iter().map(Tally::counts);
    let total = counts.fold([0; 8], |sum: [u64; 8], counts| {
        std::array::from_fn(|index| sum[index] + counts[index])
    });
    assert!(total.iter().all(|count| *count > 1_000), "{total:?}");
}
