//! The lockstep runner: node programs, one bus, one plant, one operator, a millisecond at a time.
//!
//! [`process`] talks to one node program, `node_log` reads what it logs, `launch` starts it,
//! [`operator`] drives, [`listener`] decodes what the bus makes public, [`faults`] makes things go
//! wrong, `lockstep` is the order of one step, [`pace`] keeps to the wall clock. Here: a run from
//! its first step to its end.

pub mod faults;
mod launch;
pub mod listener;
mod lockstep;
mod node_log;
pub mod operator;
pub mod pace;
pub mod process;

use crate::bus::Overflow;
use crate::nodes::{Board, Program, Programs};
use crate::record::{BusFrame, SAMPLE_HZ, Sample};
use crate::scenario::{NodeName, Scenario};
use crate::slcan::SlcanPort;
use crate::summary::RunFacts;
use lockstep::Run;
use pace::Pace;
use process::NodeError;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tautrack::link::STEP_US;

/// Steps that a run goes on after the robot turned over, when it ends for that.
const AFTER_TOPPLING: u64 = 500;
/// Steps that a run goes on after the last client has left, if a client is the operator: time to
/// come back.
const AFTER_CLIENTS: u64 = 5_000;
/// Slower than these is standing still.
const STILL_MPS: f64 = 0.005;
const STILL_RADPS: f64 = 0.02;

/// How a scenario is run.
#[derive(Default)]
pub struct Options {
    /// Programs that take the place of a node's own, with the board that they are built for.
    pub exchanged: Vec<(NodeName, Board, Program)>,
    /// Maximum of virtual seconds per second of the wall clock. If absent, 1 with a port for
    /// clients, and as fast as possible without.
    pub speed: Option<f64>,
    /// Virtual time at which the operator lets go: no speed asked any more, the chassis left as it is, s.
    pub let_go_s: Option<f64>,
    /// Virtual time from which the operator requests to disarm, s.
    pub disarm_s: Option<f64>,
    /// Ends the run half a second after the robot turned over.
    pub end_when_toppled: bool,
    /// Ends the run once the armed robot has stood still for so long, s.
    pub end_when_still_s: Option<f64>,
    /// A port through which CAN clients take part. The first step waits for the first client.
    pub slcan: Option<SlcanPort>,
    /// Maximum time of the wall clock to wait for the first client; without limit if absent.
    pub slcan_wait: Option<Duration>,
    /// Maximum time of the wall clock that a node may take for an answer; a minute if absent.
    pub node_timeout: Option<Duration>,
    /// Ends the run once it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
}

/// How far a run has come.
pub struct Progress<'a> {
    /// Virtual time, s.
    pub time_s: f64,
    /// Forward speed that the guard passes on, m/s.
    pub speed: f64,
    /// State of the guard.
    pub state: &'a str,
}

/// What a run leaves behind.
pub struct Outcome {
    /// Samples at [`SAMPLE_HZ`].
    pub samples: Vec<Sample>,
    /// Every frame that the bus delivered, in order.
    pub frames: Vec<BusFrame>,
    /// What only the runner knows.
    pub facts: RunFacts,
    /// Log lines of the nodes, with time and node.
    pub log: Vec<String>,
    /// Virtual times at which the operator's script changed what is commanded, its start included, s.
    pub commands_s: Vec<f64>,
    /// Number of clients that took part.
    pub clients: usize,
}

/// Why a run ended before its time.
#[derive(Debug)]
pub enum RunError {
    /// A node could not be started, refused its settings, or did not answer.
    Node(NodeError),
    /// A node or the operator sends more than the bus can carry.
    Overflow(Overflow),
    /// The user ended the run.
    Interrupted,
    /// A client is the operator, and none opened the channel in time.
    NoClient,
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Node(error) => write!(f, "{error}"),
            Self::Overflow(error) => write!(f, "the bus is overloaded: {error}"),
            Self::Interrupted => write!(f, "interrupted by the user"),
            Self::NoClient => write!(
                f,
                "no client opened the channel, and a client is the operator"
            ),
        }
    }
}

impl std::error::Error for RunError {}

impl From<NodeError> for RunError {
    fn from(error: NodeError) -> Self {
        Self::Node(error)
    }
}

impl From<Overflow> for RunError {
    fn from(error: Overflow) -> Self {
        Self::Overflow(error)
    }
}

/// Runs `scenario` with the nodes of `programs` and calls `progress` at every sample.
///
/// # Errors
/// [`RunError`]; no node outlives the call.
pub fn run(
    scenario: &Scenario,
    programs: &Programs,
    options: Options,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Outcome, RunError> {
    let (outcome, broken) = record(scenario, programs, options, progress)?;
    broken.map_or(Ok(outcome), Err)
}

/// As [`run`], but a run that breaks in the middle also returns what it recorded until then, with
/// the reason.
///
/// # Errors
/// [`RunError`] of a run that did not begin.
pub fn record(
    scenario: &Scenario,
    programs: &Programs,
    options: Options,
    progress: &mut dyn FnMut(&Progress),
) -> Result<(Outcome, Option<RunError>), RunError> {
    let conditions = Conditions::of(scenario, &options);
    let (speed, slcan_wait) = (options.speed, options.slcan_wait);
    let run = Run::start(scenario, programs, options)?;
    let mut recorder = Recorder {
        run,
        samples: Vec::new(),
        step: 0,
        conditions,
    };
    let broken = recorder.wait_for_client(slcan_wait).err();
    let speed = speed.or(recorder.run.slcan.as_ref().map(|_| 1.0));
    let began = Instant::now();
    let broken = match broken {
        None => recorder
            .run_to_the_end(Pace::new(speed, began), progress)
            .err(),
        broken => broken,
    };
    let Recorder {
        run, samples, step, ..
    } = recorder;
    let outcome = Outcome {
        samples,
        facts: run.facts(began.elapsed(), step),
        commands_s: run.commands_s(),
        clients: run.slcan.as_ref().map_or(0, SlcanPort::joined),
        frames: run.frames,
        log: run.log,
    };
    Ok((outcome, broken))
}

/// What ends a run.
struct Conditions {
    steps: u64,
    toppled: bool,
    still_s: f64,
    client_operates: bool,
    interrupt: Option<Arc<AtomicBool>>,
}

impl Conditions {
    fn of(scenario: &Scenario, options: &Options) -> Self {
        Self {
            steps: (scenario.duration_s * 1e6) as u64 / STEP_US,
            toppled: options.end_when_toppled,
            still_s: options.end_when_still_s.unwrap_or(f64::INFINITY),
            client_operates: scenario.operator.client,
            interrupt: options.interrupt.clone(),
        }
    }

    fn interrupted(&self) -> bool {
        let set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        self.interrupt.as_ref().is_some_and(set)
    }
}

/// A run and what is recorded of it.
struct Recorder {
    run: Run,
    samples: Vec<Sample>,
    /// Steps done.
    step: u64,
    conditions: Conditions,
}

impl Recorder {
    fn wait_for_client(&mut self, timeout: Option<Duration>) -> Result<(), RunError> {
        let Some(port) = &mut self.run.slcan else {
            return Ok(());
        };
        let conditions = &self.conditions;
        let joined = port.wait_for_client(timeout, &|| conditions.interrupted());
        if conditions.interrupted() {
            return Err(RunError::Interrupted);
        }
        // Without a wait a client may still join later.
        let may_join = joined || !conditions.client_operates || timeout == Some(Duration::ZERO);
        if may_join {
            Ok(())
        } else {
            Err(RunError::NoClient)
        }
    }

    fn run_to_the_end(
        &mut self,
        mut pace: Pace,
        progress: &mut dyn FnMut(&Progress),
    ) -> Result<(), RunError> {
        let mut end = self.conditions.steps;
        let mut still_since_s = 0.0;
        let mut attached_at = 0;
        while self.step < end {
            if self.conditions.interrupted() {
                return Err(RunError::Interrupted);
            }
            self.run.step(self.step + 1)?;
            self.step += 1;
            let step = self.step;
            if step.is_multiple_of(1_000 / u64::from(SAMPLE_HZ)) {
                let sample = self.run.sample(step);
                progress(&Progress {
                    time_s: sample.time_s,
                    speed: sample.heard.passed_speed,
                    state: &sample.heard.guard_state,
                });
                if !is_still(self.samples.last(), &sample) {
                    still_since_s = sample.time_s;
                }
                if sample.time_s - still_since_s >= self.conditions.still_s {
                    end = step;
                }
                self.samples.push(sample);
            }
            std::thread::sleep(pace.pause(Instant::now()));
            if self.conditions.toppled && self.run.plant.truth().toppled {
                end = end.min(step + AFTER_TOPPLING);
            }
            if let Some(port) = &self.run.slcan
                && self.conditions.client_operates
            {
                if port.attached() > 0 || port.joined() == 0 {
                    attached_at = step;
                }
                if step >= attached_at + AFTER_CLIENTS {
                    eprintln!(
                        "tautrack: the last client left 5 s of virtual time ago; the run ends"
                    );
                    end = step;
                }
            }
        }
        Ok(())
    }
}

/// Whether an armed robot, its belts and its joint stood still from one sample to the next.
fn is_still(before: Option<&Sample>, now: &Sample) -> bool {
    let truth = &now.truth;
    let speeds = [truth.ground_speed, truth.belt_speed[0], truth.belt_speed[1]];
    let turned = before.map_or(f64::INFINITY, |before| truth.theta - before.truth.theta);
    now.heard.guard_state == "armed"
        && speeds.iter().all(|speed| speed.abs() < STILL_MPS)
        && truth.pitch_rate.abs() < STILL_RADPS
        && turned.abs() * f64::from(SAMPLE_HZ) < STILL_RADPS
}
