//! The guard: the master of the network, the controller of the robot's body
//! ([`crate::robots::Body`]), and a filter that passes a command only as far as the margins allow.
//! A margin is the horizontal distance from the centre of gravity to an edge of the support.
//!
//! This file has the tick. The other modules:
//!
//! * [`evaluation`]: what happens between two SYNCs
//! * [`cycle`]: what happens once per SYNC
//! * [`command`]: the operator's command, and how much of it passes
//! * [`commissioning`]: mounting and constant errors of the sensors
//! * [`drive_table`] and [`drive_link`]: what the guard knows of the other nodes
//! * [`identity`]: whether a second node sends with the identifiers of a drive
//! * [`scales`]: comparison of the nodes' position scales
//! * [`operator`] and [`streams`]: the newest command, and whether two operators send them
//! * [`schedule`]: which work is due in a tick
//! * [`sequence`]: the states of the guard
//! * [`gate`]: what the drives may do in each state
//! * [`publish`]: payloads of the guard's process data
//! * [`interface`]: inputs and outputs

mod command;
pub mod commissioning;
mod cycle;
mod drive_link;
mod drive_table;
mod evaluation;
mod gate;
mod identity;
mod interface;
mod operator;
mod publish;
mod scales;
mod schedule;
mod sequence;
mod streams;

pub use drive_table::ScaleMismatch;
pub use interface::{Inputs, MAX_SENT, Outputs};
pub use scales::POSITION_SCALE;
pub use sequence::State;

use crate::constants::CONTROL_PERIOD;
use crate::estimate::attitude::Attitude;
use crate::estimate::state::Estimator;
use crate::robots::Body;
use crate::robots::body::balance_parameters;
use crate::sensing::Sensing;
use crate::sensing::sensor_watch::SensorState;
use crate::sensors::Sensor;
use crate::settings::Settings;
use crate::stability::balance::{Balance, Telemetry};
use crate::stability::parameters::Refusal;
use crate::stability::trip::Requests;
use commissioning::Commissioning;
use drive_table::Drives;
use gate::Gate;
use interface::FaultReport;
use operator::Operator;
use publish::Tally;
use schedule::Schedule;

/// The guard of a robot with this body.
#[derive(Clone, Debug)]
pub struct Guard<B> {
    schedule: Schedule,
    drives: Drives,
    state: State,
    gate: Gate,
    body: B,
    sensing: Sensing,
    balance: Balance,
    refusal: Option<Refusal>,
    speed_scale: f32,
    attitude: Attitude,
    estimator: Estimator,
    commissioning: Commissioning,
    operator: Operator,
    /// Requests for a reset and for an emergency stop since the last SYNC.
    requests: Requests,
    fault: Option<FaultReport>,
    tally: Tally,
    outputs: Outputs,
}

impl<B: Body> Guard<B> {
    /// Creates a guard with these settings.
    ///
    /// # Errors
    /// The refusal of the robot's body, if the settings describe no such robot.
    pub fn new(settings: &Settings) -> Result<Self, B::Refusal> {
        Ok(Self {
            schedule: Schedule::new(settings),
            drives: Drives::new::<B>(settings),
            state: State::default(),
            gate: Gate::Hold,
            body: B::new(settings)?,
            sensing: Sensing::new(settings),
            balance: Balance::new(settings, balance_parameters::<B>(settings)),
            refusal: None,
            speed_scale: 1.0,
            attitude: Attitude::default(),
            estimator: Estimator::new(settings),
            commissioning: Commissioning::default(),
            operator: Operator::new(settings),
            requests: Requests::default(),
            fault: None,
            tally: Tally::default(),
            outputs: Outputs::default(),
        })
    }

    /// Refuses to arm the robot, because the settings are not all those that were saved.
    pub fn doubt_settings(&mut self) {
        self.balance.doubt_settings();
    }

    /// Runs one control period. The outputs stay in place until the next one, because copying the
    /// frames would take longer than creating them.
    pub fn tick(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        let fault_before = self.fault;
        let sensors = self.sensing.receive(inputs.body.as_ref());
        self.attitude.update(sensors, CONTROL_PERIOD);
        self.estimator
            .sense(sensors, &mut self.attitude, inputs.now_us);
        self.commissioning.sense(self.sensing.raw(), CONTROL_PERIOD);
        let fix = self.estimator.listen(inputs.serial, inputs.now_us);
        self.sensing.receive_fix(fix);
        for frame in inputs.frames {
            self.drives.receive(frame, inputs.now_us);
        }
        self.listen(inputs);
        self.latch_fault(inputs.now_us);

        self.outputs.frames.clear();
        self.outputs.robot = None;
        let due = self.schedule.due(inputs.now_us);
        if due.evaluation {
            self.evaluate(inputs.now_us);
        }
        if due.position {
            self.outputs.robot = Some(self.update_estimate(inputs.now_us));
        }
        if due.offsets {
            self.send_feed_forward();
        }
        if due.sync {
            self.cycle(inputs);
        }
        let changed = fault_before != self.fault;
        if due.position || changed {
            self.outputs.faulty_drives = self.drives.faulty();
        }
        self.outputs.emergency = changed.then(|| self.fault.map_or(0, |fault| fault.code));
        self.publish();
        &self.outputs
    }

    /// Returns the outputs of the last tick.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Returns the estimator, which has the origin of the robot's position and the counts of the
    /// GNSS receiver's sentences.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Returns what the guard knows of the robot's balance.
    pub fn telemetry(&self) -> Telemetry {
        self.balance.telemetry(self.refusal)
    }

    /// Starts a step of the commissioning of the sensors
    /// ([`commissioning::request`]).
    pub fn commission(&mut self, request: u8) {
        self.commissioning.request(request, !self.state.driving());
    }

    /// Returns progress and results of the commissioning.
    pub fn commissioning(&self) -> &commissioning::Report {
        self.commissioning.report()
    }

    /// Returns age, rate and health of a sensor.
    pub fn sensor(&self, sensor: Sensor) -> SensorState {
        self.sensing.state(sensor)
    }

    /// Returns the first drive whose scale differs from the one that the robot's equations use.
    pub fn scale_mismatch(&self) -> Option<ScaleMismatch> {
        self.drives.mismatch()
    }
}
