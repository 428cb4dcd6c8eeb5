//! Work of the guard once per SYNC: state, command, gate, set-points.

use super::gate::{Gate, Intent};
use super::interface::Inputs;
use super::sequence::{self, Conditions};
use super::{Guard, State};
use crate::bus::network::{NmtCommand, nmt, sync};
use crate::bus::pdo::Request;
use crate::estimate::attitude::Attitude;
use crate::robots::{Body, DriveState, Goal};
use crate::stability::parameters::Refusal;

impl<B: Body> Guard<B> {
    /// Runs the work of one SYNC period: state, filter, body, gate, set-points.
    pub(super) fn cycle(&mut self, inputs: &Inputs<'_>) {
        let now_us = inputs.now_us;
        let before = self.state;
        self.drives.check_restarts(before.driving());
        self.advance_state(inputs);
        self.pass_command(inputs);
        // This comes after the filter, so that a trip or an emergency stop counts in the period in
        // which it comes.
        self.gate = Gate::of(self.state, self.intent(inputs));
        let starting = self.gate == Gate::Open && self.state == before;
        if self.state != State::Armed && !starting {
            self.body.rest();
        }
        // A restarted drive waits for the start command in "held", too: its reset needs its status.
        let joined = before == State::Waiting && self.state == State::Ready;
        let waits = matches!(self.state, State::Ready | State::Held) && self.drives.take_start();
        self.send(joined || waits, now_us);
    }

    /// Returns what the operator and the latch of the trip want of the drives.
    fn intent(&self, inputs: &Inputs<'_>) -> Intent {
        let now_us = inputs.now_us;
        if inputs.emergency_stop {
            Intent::Stand
        } else if self.operator.disarms(now_us) {
            Intent::Disarm
        } else if self.balance.tripped() {
            Intent::Stand
        } else if self.operator.drives(now_us) && self.start_refusal().is_none() {
            Intent::Drive
        } else if self.operator.stands() {
            Intent::Stand
        } else {
            Intent::Nothing
        }
    }

    /// Returns why the robot may not begin or go on with the start.
    fn start_refusal(&self) -> Option<Refusal> {
        let homes = match self.state {
            State::Ready => self.body.first_stage(self.drives.states()),
            State::Starting(stage) => stage,
            State::Waiting | State::Armed | State::Held => return None,
        };
        let homes = usize::from(homes) + 1 < B::STAGES.len();
        // Homing may tilt the sensors themselves: those of RT-Mover sit on the seat. So the tilt
        // counts before the start only; in its stages the margins count.
        // A start that was stopped begins anew: the robot may have been moved.
        let begins = self.state == State::Ready || self.gate != Gate::Open;
        let confirmed = !begins || self.operator.request() == Request::ArmOffLevel;
        let homing = (0..)
            .map_while(|index| self.body.homing_stance(index, &self.attitude))
            .take_while(|_| begins);
        self.balance
            .start_refusal(&self.attitude, homes, confirmed, homing)
    }

    /// Enters the state that follows from fault reports, drives and the operator's request.
    fn advance_state(&mut self, inputs: &Inputs<'_>) {
        let now_us = inputs.now_us;
        let before = self.state;
        let complete = self.drives.complete();
        let ready = complete && self.drives.have_status();
        let arms = ready && self.operator.arms(now_us) && !self.balance.tripped();
        let starts = arms && before == State::Ready || matches!(before, State::Starting(_));
        // The first readings may be wrong. Until they have settled, the start waits.
        let refusal = self.start_refusal().filter(|_| starts);
        let refused = refusal.filter(|_| !self.attitude.settling());
        let last = State::Starting(B::STAGES.len() as u8 - 1);
        let waits = before == last && self.gate == Gate::Open;
        let unrested = self.sensing.await_rest(waits, self.schedule.period());
        let conditions = Conditions {
            complete,
            fault: self.fault.is_some() || self.drives.reset_under_way(),
            disarms: self.operator.disarms(now_us),
            arms: arms && refusal.is_none(),
            refused: refused.is_some(),
            open: self.gate == Gate::Open,
            settling: self.attitude.settling() || unrested,
        };
        let drives = self.drives.states();
        self.state = sequence::next(before, conditions, &mut self.body, drives, now_us);
        if conditions.disarms {
            self.refusal = None;
        }
        if self.state == State::Ready && refused.is_some() && !conditions.disarms {
            self.refusal = refused;
            self.operator.require_new_request();
        }
        match (before, self.state) {
            (State::Ready, State::Starting(_)) => {
                self.refusal = None;
                self.operator.require_new_request();
            }
            (before, State::Held) if before != State::Held => {
                self.operator.require_new_request();
            }
            (State::Starting(_), State::Armed) => self.check(),
            _ => {}
        }
    }

    /// Refuses to arm a robot whose geometry and settings make no sense on level ground.
    fn check(&mut self) {
        let level = self.body.stance(&Attitude::default());
        self.refusal = self.balance.check(&level).err();
        if self.refusal.is_some() {
            self.state = State::Ready;
        }
    }

    /// Sends the frames of one SYNC period. With `starts`, the nodes also get the command to
    /// exchange process data.
    fn send(&mut self, starts: bool, now_us: u64) {
        self.drives.note_sent(starts);
        // There is room for all of them (`MAX_SENT`).
        let frames = &mut self.outputs.frames;
        let _ = frames.push(sync());
        if starts {
            let _ = frames.push(nmt(NmtCommand::Start, 0));
        }
        if !self.state.driving() {
            for frame in self.drives.scale_requests(now_us) {
                let _ = frames.push(frame);
            }
        }
        // While a drive is missing, the others are held.
        let waits = self.state == State::Waiting;
        let (gate, body, phase) = (self.gate, &self.body, self.state.phase());
        let goal = |drive, state: &DriveState| {
            let goal = phase.map_or(Goal::Hold, |phase| body.goal(phase, drive));
            gate.pass(goal, state)
        };
        for frame in self.drives.commands(now_us, waits, goal) {
            let _ = frames.push(frame);
        }
    }
}
