//! Checks what must be true of a drive after every tick, from its inputs and its published outputs
//! alone.

use super::generator::TEMPERATURE_LIMIT;
use tautrack::bus::cia402::State;
use tautrack::faults::{ALL, Fault, Faults, Reaction};
use tautrack::motor::index::Finding;
use tautrack::node::axle::{AlignmentState, BridgeDemand, Inputs, Outputs};

const STATES: [State; 6] = [
    State::SwitchOnDisabled,
    State::ReadyToSwitchOn,
    State::SwitchedOn,
    State::OperationEnabled,
    State::QuickStopActive,
    State::Fault,
];

/// How often each state was entered and each fault raised.
#[derive(Clone, Debug)]
pub struct Tally {
    states: [u64; 6],
    faults: [u64; ALL.len()],
    /// Conditions that were raised while another fault was latched already.
    behind_another: u64,
    alignments: u64,
    aborted_alignments: u64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            states: [0; 6],
            faults: [0; ALL.len()],
            behind_another: 0,
            alignments: 0,
            aborted_alignments: 0,
        }
    }
}

impl Tally {
    pub fn plus(mut self, other: &Self) -> Self {
        for (sum, more) in self.states.iter_mut().zip(&other.states) {
            *sum += more;
        }
        for (sum, more) in self.faults.iter_mut().zip(&other.faults) {
            *sum += more;
        }
        self.behind_another += other.behind_another;
        self.alignments += other.alignments;
        self.aborted_alignments += other.aborted_alignments;
        self
    }

    pub fn counts(&self) -> impl Iterator<Item = (String, u64)> {
        let states = STATES.iter().zip(self.states);
        let states = states.map(|(state, count)| (format!("{state:?}"), count));
        // Drives do not raise the faults that the guard reports. No random current is that of a
        // belt that breaks, and the simulated board does not open its bridge by itself.
        let drive = ALL
            .iter()
            .zip(self.faults)
            .filter(|(fault, _)| !NOT_DRAWN.contains(fault));
        let faults = drive.map(|(fault, count)| (format!("{fault:?}"), count));
        states.chain(faults).chain([
            ("a second fault".to_owned(), self.behind_another),
            ("an alignment".to_owned(), self.alignments),
            ("an aborted alignment".to_owned(), self.aborted_alignments),
        ])
    }
}

const NOT_DRAWN: [Fault; 10] = [
    Fault::SafeTorqueOff,
    Fault::ShortCircuit,
    Fault::ProcessorEvent,
    Fault::ShaftMismatch,
    Fault::BeltLost,
    Fault::NodeLost,
    Fault::UnexpectedState,
    Fault::ScaleMismatch,
    Fault::TwoOperators,
    Fault::DuplicateNode,
];

/// Conditions that readings can meet, with their dwell in ticks.
const DWELLS: [(Fault, u32); 13] = [
    (Fault::InvalidReading, 3),
    (Fault::OverCurrent, 5),
    (Fault::OverVoltage, 5),
    (Fault::UnderVoltage, 5),
    (Fault::Overspeed, 3),
    (Fault::VelocityDeviation, 25),
    (Fault::Blocked, 40),
    (Fault::ControlOverrun, 3),
    (Fault::OverTemperature, 20),
    (Fault::EncoderNoise, 3),
    // With the time in which the filter of the voltage forgets a jump of the encoder.
    (Fault::OpenPhase, 8 + 40),
    (Fault::EncoderMismatch, 8 + 40),
    (Fault::RotorAngle, 200 + 40),
];

#[allow(clippy::struct_excessive_bools)] // each is a fact about the drive, and all are independent
pub struct Oracle {
    current_limit: f32,
    velocity_unit: f32,
    three_phase: bool,
    encoder: i32,
    state: State,
    faults: Faults,
    demand: f32,
    lasted: [u32; DWELLS.len()],
    word: u16,
    mode: i8,
    target: i32,
    guard_us: Option<u64>,
    command_us: u64,
    joint_us: Option<u64>,
    bench: bool,
    unreported: Faults,
    was_reported: bool,
    /// Velocity of the set-point while it is a ramp, rad/s, and the lowest speed since the drive
    /// began to move against its current.
    ramp: Option<f32>,
    slowest: Option<f32>,
    /// A controlword has ended the operation, and the drive may still ramp to standstill.
    leaves: bool,
    /// Ticks in which the brake engages, and for which "disable voltage" has been in force.
    engage_ticks: u32,
    disabled_for: Option<u32>,
    /// Low bits of the newest command, and since when no other one came.
    command: u16,
    command_since_us: u64,
    /// Until when frames of a second master may have hidden those of the guard.
    hidden_us: u64,
    /// When the reset bit rose last.
    reset_us: u64,
    /// The guard has been alive since the drive has power.
    guarded: bool,
    /// An alignment is under way, and the rotor's angle is known.
    aligning: bool,
    aligned: bool,
    /// The rotor's angle was known in the previous tick, so that the encoder's index counts.
    known: bool,
}

impl Oracle {
    /// Creates the oracle of a drive with this current limit, A, this unit of velocities on the
    /// bus, rad/s, whose brake engages in this time, and with this kind of motor.
    pub fn new(
        current_limit: f32,
        velocity_unit: f32,
        engage_ticks: u32,
        three_phase: bool,
    ) -> Self {
        Self {
            current_limit,
            three_phase,
            encoder: 0,
            velocity_unit,
            state: State::SwitchOnDisabled,
            faults: Faults::NONE,
            demand: 0.0,
            lasted: [0; DWELLS.len()],
            word: 0,
            mode: 0,
            target: 0,
            guard_us: None,
            command_us: 0,
            joint_us: None,
            bench: false,
            unreported: Faults::NONE,
            was_reported: false,
            ramp: None,
            slowest: None,
            leaves: false,
            engage_ticks,
            disabled_for: None,
            command: 0,
            command_since_us: 0,
            hidden_us: 0,
            reset_us: 0,
            guarded: false,
            aligning: false,
            aligned: false,
            known: false,
        }
    }

    pub fn check(
        &mut self,
        inputs: &Inputs,
        joint_us: Option<u64>,
        outputs: &Outputs,
        tally: &mut Tally,
    ) -> Result<(), String> {
        let state = State::from_statusword(outputs.status.statusword).ok_or("no state")?;
        self.joint_us = joint_us.or(self.joint_us);
        if inputs.guard_received {
            self.guard_us = Some(inputs.now_us);
        }
        if inputs.set_point.is_some() {
            self.command_us = inputs.now_us;
        }
        if self.bench != outputs.bench_mode && outputs.bench_mode {
            self.command_us = inputs.now_us;
        }
        let velocity = outputs.motion.velocity as f32 * self.velocity_unit;
        self.conditions(inputs, velocity, outputs)?;
        self.reactions(state, outputs)?;
        self.transitions(inputs, state, outputs)?;
        self.reports(inputs, outputs)?;
        self.alignment(inputs, outputs, tally)?;

        let raised = outputs.faults.without(self.faults);
        for (count, fault) in tally.faults.iter_mut().zip(ALL) {
            *count += u64::from(raised.contains(*fault));
        }
        if !raised.is_empty() && !self.faults.is_empty() {
            tally.behind_another += 1;
        }
        let entered = STATES
            .iter()
            .position(|one| *one == state && state != self.state);
        if let Some(entered) = entered {
            tally.states[entered] += 1;
        }
        self.follow_ramp(inputs, state, velocity);
        self.state = state;
        self.faults = outputs.faults;
        self.bench = outputs.bench_mode;
        self.demand = match outputs.bridge {
            BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => current,
            _ => 0.0,
        };
        if let Some(set_point) = inputs.set_point {
            self.word = set_point.controlword;
            self.mode = set_point.mode;
            self.target = set_point.target;
        }
        Ok(())
    }

    /// Checks that every condition that has lasted for its dwell is in the set of faults.
    fn conditions(
        &mut self,
        inputs: &Inputs,
        velocity: f32,
        outputs: &Outputs,
    ) -> Result<(), String> {
        let powered = matches!(self.state, State::OperationEnabled | State::QuickStopActive);
        let energized = powered || self.aligning;
        let (current, voltage) = (inputs.current, inputs.supply_voltage);
        let lacking = (current - self.demand).abs() > 0.51 * self.demand.abs()
            && self.demand.abs() > 0.11 * self.current_limit;
        let jumps = self.jumps(inputs.encoder);
        // The bounds are a little wider, because the published velocity is rounded.
        let met = [
            !(current.is_finite()
                && voltage.is_finite()
                && inputs.temperatures.bridge.is_some_and(f32::is_finite)),
            current.is_nan() || current.abs() > 1.2501 * self.current_limit,
            voltage.is_nan() || voltage > 32.001,
            voltage.is_nan() || voltage < 11.999,
            energized && velocity.abs() > 7.201,
            powered && self.deviates(inputs, velocity),
            // A drive that holds reports an overload instead.
            powered
                && self.state != State::QuickStopActive
                && velocity.abs() < 0.0599
                && self.demand.abs() > 0.9001 * self.current_limit,
            inputs.electrical.overrun,
            inputs
                .temperatures
                .bridge
                .is_some_and(|celsius| celsius > TEMPERATURE_LIMIT),
            jumps && energized,
            powered && Self::unexplained(inputs, velocity) && lacking,
            powered && Self::unexplained(inputs, velocity) && !lacking,
            powered && self.turned(inputs, velocity),
        ];
        let at_once = inputs.electrical.over_current;
        if at_once && !outputs.faults.contains(Fault::OverCurrent) {
            return Err("the over-current of the bridge is not raised".to_owned());
        }
        let by_index = match inputs.electrical.index {
            Finding::Misaligned => Some(Fault::Misaligned),
            Finding::Lost => Some(Fault::EncoderNoise),
            Finding::Nothing | Finding::Confirmed => None,
        };
        if let Some(fault) = by_index
            && self.known
            && !outputs.faults.contains(fault)
        {
            return Err(format!("{fault:?} of the index is not raised"));
        }
        for (((fault, dwell), lasted), met) in DWELLS.iter().zip(&mut self.lasted).zip(met) {
            *lasted = if met { *lasted + 1 } else { 0 };
            if *lasted >= *dwell && !outputs.faults.contains(*fault) {
                return Err(format!(
                    "{fault:?} has lasted {lasted} ticks and is not raised"
                ));
            }
        }
        let silent = |since: u64, timeout_us: u64| inputs.now_us > since + timeout_us;
        let enabled = self.state == State::OperationEnabled;
        let taut = enabled && self.mode == -1 && self.joint_us.is_some();
        let losses = [
            (
                Fault::GuardLost,
                energized && !self.bench && self.guard_us.is_some_and(|at| silent(at, 120_000)),
            ),
            (
                Fault::CommandLost,
                energized && silent(self.command_us, 60_000),
            ),
            (
                Fault::JointLost,
                taut && self.joint_us.is_some_and(|at| silent(at, 24_000)),
            ),
        ];
        for (fault, lost) in losses {
            if lost && !outputs.faults.contains(fault) {
                return Err(format!("{fault:?} is not raised"));
            }
        }
        Ok(())
    }

    /// Returns whether the encoder has moved by more than 13 rad/s in this tick. The screw's gear
    /// and encoder are the same.
    fn jumps(&mut self, encoder: i32) -> bool {
        let step = encoder.wrapping_sub(self.encoder);
        self.encoder = encoder;
        f64::from(step).abs() > 13.0e-3 * 4_096.0 * 60.0 / std::f64::consts::TAU
    }

    /// Returns whether much more voltage is at the motor than current and speed explain: 2.4 V
    /// s/rad and 0.6 ohm, or less.
    fn unexplained(inputs: &Inputs, velocity: f32) -> bool {
        inputs.electrical.voltage.is_some_and(|[_, q]| {
            let explained = 2.4 * velocity.abs() + 2.0 * 0.6 * inputs.current.abs();
            q.abs() > explained + 0.3 * 14.4 + 0.6 && q.is_finite()
        })
    }

    /// Returns whether a back-EMF of 1.6 V s/rad stands more than 30 degrees away from q.
    fn turned(&self, inputs: &Inputs, velocity: f32) -> bool {
        self.three_phase
            && velocity.abs() > 0.6
            // A disturbed sample delays the finding.
            && inputs.current.abs() < 1.25 * self.current_limit
            && inputs.electrical.voltage.is_some_and(|[d, _]| {
                let coupled = 60.0 * 7.0 * 3e-4 * velocity * inputs.current;
                let emf = 1.6 * velocity.abs();
                (d + coupled).abs() > 0.5 * emf + 0.2 * coupled.abs() + 0.2
            })
    }

    /// Checks that the bridge does at least what the strongest latched fault requires.
    fn reactions(&self, state: State, outputs: &Outputs) -> Result<(), String> {
        let faults = ALL.iter().filter(|fault| outputs.faults.contains(**fault));
        let reaction = faults.map(|fault| fault.description().reaction).max();
        let good = match (reaction, outputs.bridge) {
            (Some(Reaction::Off), bridge) => bridge == BridgeDemand::Off,
            (Some(Reaction::Brake), bridge) => {
                matches!(bridge, BridgeDemand::Off | BridgeDemand::Brake)
            }
            (Some(Reaction::Hold), BridgeDemand::Current(_) | BridgeDemand::Braking { .. }) => {
                state == State::QuickStopActive
            }
            (_, BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. }) => {
                matches!(state, State::OperationEnabled | State::QuickStopActive)
                    && current.abs()
                        <= if outputs.bench_mode {
                            2.0
                        } else {
                            self.current_limit
                        }
            }
            (Some(Reaction::Hold), BridgeDemand::Align { .. } | BridgeDemand::Aligned(_)) => false,
            (_, BridgeDemand::Align { current, .. }) => {
                let most = if outputs.bench_mode { 2.0 } else { 3.000_001 };
                state == State::SwitchedOn && (0.0..=most).contains(&current)
            }
            (_, BridgeDemand::Aligned(_)) => state == State::SwitchedOn,
            (_, BridgeDemand::Off | BridgeDemand::Brake) => true,
        };
        if !good {
            return Err(format!("{reaction:?} is not done in {state:?}"));
        }
        let coded = outputs.status.error_code != 0;
        if state == State::OperationEnabled && (coded || !outputs.faults.is_empty()) {
            return Err("operation enabled with a latched fault".to_owned());
        }
        Ok(())
    }

    /// Checks that only a reset clears faults, and that only somebody in command enables a drive.
    /// With a fault it may at most hold.
    fn transitions(
        &mut self,
        inputs: &Inputs,
        state: State,
        outputs: &Outputs,
    ) -> Result<(), String> {
        let guarded = self
            .guard_us
            .is_some_and(|at| inputs.now_us <= at + 120_000);
        let high = inputs
            .set_point
            .is_some_and(|new| new.controlword & 0x80 != 0);
        let edge = high && self.word & 0x80 == 0;
        if edge {
            self.reset_us = inputs.now_us;
        }
        // The guard sends every 4 ms.
        let resets = high && (!guarded || inputs.now_us - self.reset_us >= 7_000);
        if !self.faults.without(outputs.faults).is_empty() && !resets {
            return Err("a fault was cleared without a reset".to_owned());
        }
        let rank = |state| match state {
            State::SwitchOnDisabled | State::Fault => 0,
            State::ReadyToSwitchOn => 1,
            State::SwitchedOn => 2,
            State::QuickStopActive => 3,
            State::OperationEnabled => 4,
        };
        let was_powered = matches!(self.state, State::OperationEnabled | State::QuickStopActive);
        if rank(state) > rank(self.state) {
            // A drive without power may begin to hold for the guard, if its faults require a hold.
            let mut faults = ALL.iter().filter(|fault| outputs.faults.contains(**fault));
            let holds = !was_powered
                && guarded
                && state != State::OperationEnabled
                && faults.all(|fault| fault.description().reaction == Reaction::Hold);
            if edge || !(outputs.faults.is_empty() || holds) {
                return Err(format!(
                    "{:?} to {state:?} by a reset or in a fault",
                    self.state
                ));
            }
            if !guarded && !outputs.bench_mode {
                return Err(format!("{:?} to {state:?} by nobody", self.state));
            }
        }
        if guarded && outputs.bench_mode {
            return Err("bench mode under a living guard".to_owned());
        }
        self.switching_off(inputs, state, guarded, outputs)?;
        let driven = matches!(
            outputs.bridge,
            BridgeDemand::Current(_)
                | BridgeDemand::Braking { .. }
                | BridgeDemand::Align { .. }
                | BridgeDemand::Aligned(_)
        );
        if outputs.brake_released && !driven {
            return Err("the brake is released without a current".to_owned());
        }
        Ok(())
    }

    /// Checks that "disable voltage" switches a drive off, and that nothing else does. Under power
    /// and a guard, the command must come for 20 ms without another one in between.
    fn switching_off(
        &mut self,
        inputs: &Inputs,
        state: State,
        guarded: bool,
        outputs: &Outputs,
    ) -> Result<(), String> {
        let under_power = |state| matches!(state, State::OperationEnabled | State::QuickStopActive);
        let down = matches!(state, State::SwitchOnDisabled | State::Fault);
        let was_powered = under_power(self.state);
        if let Some(new) = inputs.set_point {
            let low = new.controlword & 0x0f;
            let command = match low {
                _ if low & 2 == 0 => 0,
                2 | 3 | 10 | 11 => 2,
                6 | 14 => 6,
                7 => 7,
                _ => 15,
            };
            if command != self.command {
                (self.command, self.command_since_us) = (command, inputs.now_us);
                self.disabled_for = None;
            }
            let since_us = self.command_since_us.max(self.hidden_us);
            let lasts = inputs.now_us - since_us >= 20_000;
            if command == 0 && (lasts || !guarded || !was_powered) {
                self.disabled_for.get_or_insert(0);
            }
        }
        // A second master's frames may have hidden the guard's.
        let hidden = guarded && outputs.faults.contains(Fault::SecondMaster);
        if hidden {
            self.hidden_us = inputs.now_us;
        }
        if down || hidden {
            self.disabled_for = None;
        }
        if let Some(ticks) = &mut self.disabled_for {
            *ticks += 1;
            if *ticks > self.engage_ticks + 1 {
                return Err(format!("disable voltage leads to {state:?}"));
            }
        }
        // A drive that has been under a guard since it has power.
        self.guarded = guarded && (self.guarded || !was_powered);
        let own = ALL.iter().any(|fault| {
            outputs.faults.contains(*fault) && fault.description().reaction != Reaction::Hold
        });
        let commanded =
            matches!(self.command, 0 | 6 | 7) && inputs.now_us - self.command_since_us >= 20_000;
        let lets_go = was_powered && !under_power(state);
        // A brake that engages takes longer than the command.
        if lets_go && self.guarded && !own && !commanded && self.engage_ticks == 0 {
            return Err(format!(
                "{:?} to {state:?} by no command of the guard",
                self.state
            ));
        }
        Ok(())
    }

    /// Checks that a rotor is aligned only while operation is requested, by somebody who may, and
    /// that no other current flows before its end.
    fn alignment(
        &mut self,
        inputs: &Inputs,
        outputs: &Outputs,
        tally: &mut Tally,
    ) -> Result<(), String> {
        let word = inputs.set_point.map_or(self.word, |new| new.controlword);
        match outputs.bridge {
            BridgeDemand::Align { .. } | BridgeDemand::Aligned(_) if word & 0x8f != 0x0f => {
                return Err("aligns without a request".to_owned());
            }
            BridgeDemand::Aligned(_) => {
                self.aligned = true;
                tally.alignments += 1;
            }
            BridgeDemand::Current(_) | BridgeDemand::Braking { .. } => {
                let known = self.aligned || outputs.alignment == AlignmentState::NotNeeded;
                if !known {
                    return Err("a current although the rotor's angle is unknown".to_owned());
                }
            }
            _ => {}
        }
        self.aligned &= outputs.alignment != AlignmentState::Needed;
        self.known = matches!(
            outputs.alignment,
            AlignmentState::Done | AlignmentState::Confirmed
        );
        let was_aligning = self.aligning;
        self.aligning = outputs.alignment == AlignmentState::UnderWay;
        if was_aligning && !self.aligning && !self.aligned {
            tally.aborted_alignments += 1;
        }
        Ok(())
    }

    /// Checks that every fault is reported once, and also the end of the last one.
    fn reports(&mut self, inputs: &Inputs, outputs: &Outputs) -> Result<(), String> {
        let raised = outputs.faults.without(self.faults);
        self.unreported = self.unreported.or(raised);
        // Homing may fail in the same tick as a reset. The reset clears the fault at once, because
        // its cause does not last.
        let resets = inputs
            .set_point
            .is_some_and(|new| new.controlword & 0x80 != 0);
        let fails = [Fault::HomingFailed, Fault::HomingMismatch]
            .into_iter()
            .find(|fault| resets && outputs.emergency == Some(fault.description().code));
        if let Some(fault) = fails {
            self.unreported = self.unreported.or(Faults::of(fault));
        }
        match outputs.emergency.map(Fault::from_code) {
            Some(Some(fault)) => {
                if !self.unreported.contains(fault) {
                    return Err(format!("{fault:?} is reported, and was not raised"));
                }
                self.unreported = self.unreported.without(Faults::of(fault));
                self.was_reported = true;
            }
            Some(None) => {
                if !self.was_reported || !outputs.faults.is_empty() {
                    return Err("all clear, and it is not".to_owned());
                }
                self.was_reported = false;
            }
            None if !self.unreported.is_empty() => return Err("not reported".to_owned()),
            None if self.was_reported && outputs.faults.is_empty() => {
                return Err("no all clear".to_owned());
            }
            None => {}
        }
        Ok(())
    }

    /// Returns whether the drive has gathered speed away from a ramp, against a current of more
    /// than half of the limit, and the motor gives no energy back.
    fn deviates(&mut self, inputs: &Inputs, velocity: f32) -> bool {
        let Some(ramp) = self.ramp else {
            self.slowest = None;
            return false;
        };
        let against = velocity * self.demand < 0.0
            && (velocity - ramp) * self.demand < 0.0
            && (velocity - ramp).abs() > 1.25
            && self.demand.abs() > 5.01;
        let [direct, torque] = inputs.electrical.voltage.unwrap_or([0.0; 2]);
        let power = direct * inputs.electrical.direct + torque * inputs.current;
        if !against || power < 0.01 && inputs.electrical.voltage.is_some() {
            self.slowest = None;
            return false;
        }
        let slowest = self.slowest.get_or_insert(velocity.abs());
        if velocity.abs() < *slowest {
            *slowest = velocity.abs();
        }
        velocity.abs() > *slowest + 1.25
    }

    /// Follows the set-point of a velocity mode and of a stop: a ramp of 20 rad/s^2 from the
    /// velocity at which it began. In other modes, and at a limit switch, the set-point is not
    /// checked.
    fn follow_ramp(&mut self, inputs: &Inputs, state: State, velocity: f32) {
        let stopping = state == State::QuickStopActive;
        let mode = inputs.set_point.map_or(self.mode, |new| new.mode);
        let target = inputs.set_point.map_or(self.target, |new| new.target);
        let switches = inputs.switches.positive_limit || inputs.switches.negative_limit;
        // A halt, and a ramp before the bridge goes off, are stops within "operation enabled".
        let word = inputs.set_point.map_or(self.word, |new| new.controlword);
        self.leaves = state == self.state && (self.leaves || word & 0x0f != 0x0f);
        let runs = word & 0x10f == 0x0f && !self.leaves;
        let in_velocity = state == State::OperationEnabled && runs && matches!(mode, 3 | 9);
        // While a brake is engaged, and before it is, the set-point stands.
        let braked = self.engage_ticks > 0;
        if switches || braked || self.bench || !(stopping || in_velocity) {
            self.ramp = None;
            return;
        }
        // A stop has no mode.
        let changes = state != self.state || !stopping && mode != self.mode;
        let begins = changes || self.ramp.is_none();
        let goal = if stopping {
            0.0
        } else {
            (target as f32 * self.velocity_unit).clamp(-6.0, 6.0)
        };
        let from = if begins {
            velocity
        } else {
            self.ramp.unwrap_or(velocity)
        };
        // After an interruption, the ramp is known again only from the next change of state or
        // mode.
        let known = !begins || changes;
        self.ramp = known.then(|| from + (goal - from).clamp(-0.02, 0.02));
    }
}
