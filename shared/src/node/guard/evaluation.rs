//! What the guard computes between two SYNCs: faults of the drives, how the robot stands and where
//! it is.

use super::{Guard, State, publish};
use crate::bus::pdo::GuardPosition;
use crate::estimate::state::State as RobotState;
use crate::robots::Body;

impl<B: Body> Guard<B> {
    /// Latches the first fault report until the operator's reset. A drive that lets go takes the
    /// place of any other report.
    pub(super) fn latch_fault(&mut self, now_us: u64) {
        let let_go = self.drives.take_let_go();
        if let_go.is_some() {
            self.fault = let_go;
        }
        if self.fault.is_none() {
            self.fault = if self.state == State::Waiting {
                self.drives.second_master()
            } else {
                self.drives.fault(now_us, self.state.driving())
            };
        }
    }

    /// Evaluates how the robot stands, and what that means for its balance. This happens once
    /// between two SYNCs, when the drives have answered the first one. It is separate from
    /// [`Self::cycle`], so that no tick has to do both.
    #[inline(never)]
    pub(super) fn evaluate(&mut self, now_us: u64) {
        let period = self.schedule.period();
        if let Some(level) = self.sensing.learn(self.drives.stand(now_us), period) {
            self.attitude.rest(level);
            self.balance.forget_rates();
        }
        if let Some(speed) = self.estimator.take_speed(&self.attitude) {
            self.body.receive_speed(speed, &self.attitude);
        }
        self.body
            .observe(self.drives.states(), &self.attitude, period);
        self.attitude.travel(self.body.odometry_um(), period);
        let stance = self.body.stance(&self.attitude);
        let kept_shape = self.body.stance_with_kept_shape(&self.attitude);
        let speed = self.body.speed();
        self.balance.evaluate(
            &mut self.sensing,
            &stance,
            kept_shape.as_ref(),
            &self.attitude,
            speed,
            period,
        );
    }

    /// Sends the drives their torque feed-forward.
    pub(super) fn send_feed_forward(&mut self) {
        if let Some(phase) = self.state.phase() {
            let offsets = self.body.offsets(phase, &self.attitude);
            for frame in self.drives.offsets(&offsets) {
                let _ = self.outputs.frames.push(frame); // fewer than there is room for
            }
        }
    }

    /// Updates the estimate of the robot's state from the drives.
    pub(super) fn update_estimate(&mut self, now_us: u64) -> (RobotState, GuardPosition) {
        self.estimator.advance(
            self.body.odometry_um(),
            self.drives.odometry_us::<B>(),
            self.body.joints(self.drives.states()),
            &self.attitude,
            now_us,
        );
        let state = self.estimator.state(&self.attitude, now_us);
        (state, publish::position(&state))
    }
}
