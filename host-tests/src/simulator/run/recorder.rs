//! Runs the steps of a run until it ends, and passes its record on.

use super::conditions::{Conditions, is_still};
use super::lockstep::Run;
use super::options::{EndWhen, Inject};
use super::pace::Pace;
use super::{Ending, Options, RunError, Sink};
use crate::programs::Programs;
use crate::scenario::Scenario;
use crate::simulator::record::SAMPLE_HZ;
use crate::simulator::slcan::SlcanPort;
use std::time::{Duration, Instant};

/// Number of steps for which a run continues after the robot has toppled, if toppling ends it.
const AFTER_TOPPLING: u64 = 500;
/// Number of steps for which a run continues after the last client has left, if a client is the
/// operator. In this time a client can reconnect.
const AFTER_CLIENTS: u64 = 5_000;

/// Runs a scenario like [`super::run()`], with the record in `sink`. If the run fails after its
/// start, the record until then is in `sink`, and the ending has the error.
///
/// # Errors
/// [`RunError`] of a run that did not start.
pub fn record(
    scenario: &Scenario,
    programs: &Programs,
    options: Options,
    sink: &mut dyn Sink,
) -> Result<Ending, RunError> {
    let conditions = Conditions::of(scenario, &options);
    let (speed, slcan_wait) = (options.speed, options.slcan_wait);
    let mut options = options;
    let end_when = options.end_when.take();
    let inject = options.inject.take();
    let run = Run::start(scenario, programs, options)?;
    let mut recorder = Recorder {
        run,
        step: 0,
        conditions,
        end_when,
        inject,
    };
    let waited = recorder.wait_for_client(slcan_wait);
    let speed = speed.or(recorder.run.slcan.as_ref().map(|_| 1.0));
    let began = Instant::now();
    let ended = waited.and_then(|()| recorder.run_to_the_end(Pace::new(speed, began), sink));
    let Recorder { run, step, .. } = recorder;
    Ok(Ending {
        facts: run.facts(began.elapsed(), step),
        commands_s: run.commands_s(),
        clients: run.slcan.as_ref().map_or(0, SlcanPort::joined),
        error: ended.err(),
    })
}

/// A run and its end.
struct Recorder {
    run: Run,
    /// Number of steps done.
    step: u64,
    conditions: Conditions,
    end_when: Option<EndWhen>,
    inject: Option<Inject>,
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
        // With a timeout of zero, a client may still join later.
        let may_join = joined || !conditions.client_operates || timeout == Some(Duration::ZERO);
        if may_join {
            Ok(())
        } else {
            Err(RunError::NoClient)
        }
    }

    fn run_to_the_end(&mut self, mut pace: Pace, sink: &mut dyn Sink) -> Result<(), RunError> {
        let mut end = self.conditions.steps;
        let mut still_since_s = 0.0;
        let mut theta_before = None;
        let mut attached_at = 0;
        while self.step < end {
            if self.conditions.interrupted() {
                return Err(RunError::Interrupted);
            }
            self.run.step(self.step + 1, sink)?;
            self.step += 1;
            let step = self.step;
            if step.is_multiple_of(1_000 / u64::from(SAMPLE_HZ)) {
                let sample = self.run.sample(step);
                if !is_still(theta_before, &sample) {
                    still_since_s = sample.time_s;
                }
                if sample.time_s - still_since_s >= self.conditions.still_s {
                    end = step;
                }
                if self.end_when.as_mut().is_some_and(|holds| holds(&sample)) {
                    end = step;
                }
                if let Some(fault) = self.inject.as_mut().and_then(|of| of(&sample)) {
                    self.run.add_fault(fault);
                }
                theta_before = Some(sample.truth.theta);
                sink.sample(sample)?;
            }
            std::thread::sleep(pace.pause(Instant::now()));
            let truth = self.run.plant.truth();
            if (self.conditions.toppled && truth.toppled) || truth.came_off.is_some() {
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
