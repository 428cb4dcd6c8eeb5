//! Computes the summary sample by sample.

use super::belt::Belt;
use super::channels::{Channels, Range};
use super::hold::Hold;
use super::motion::Motion;
use super::verdicts::Interventions;
use super::{BusFigures, ChannelFigures, Summary, notes};
use crate::results::channel::Channel;
use crate::results::phases::Phases;
use crate::results::zmp::Balance;
use crate::robots::Role;
use crate::scenario::Scenario;
use crate::simulator::facts::RunFacts;
use crate::simulator::record::Sample;
use tautrack::link::STEP_US;

/// Figures of a run that goes on. Its memory does not grow with the length of the run.
pub struct Statistics {
    phases: Phases,
    armed: bool,
    toppled: bool,
    came_off: Option<&'static str>,
    belt: Option<Belt>,
    motion: Motion,
    pitch_deg: Option<Range>,
    backward_margin_m: Option<f64>,
    guard_margin_m: Option<f64>,
    balance: Option<Balance>,
    channels: Channels,
    interventions: Interventions,
    hold: Hold,
    load_max: f64,
    load_sum: f64,
}

impl Statistics {
    /// Begins a run of this scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let mut nodes = scenario.nodes().into_iter();
        Self {
            phases: Phases::new(scenario),
            armed: false,
            toppled: false,
            came_off: None,
            belt: nodes
                .any(|node| node.role == Role::Screw)
                .then(Belt::default),
            motion: Motion::default(),
            pitch_deg: None,
            backward_margin_m: None,
            guard_margin_m: None,
            balance: Balance::new(scenario),
            channels: Channels::default(),
            interventions: Interventions::default(),
            hold: Hold::default(),
            load_max: 0.0,
            load_sum: 0.0,
        }
    }

    /// Adds the next sample; there are [`crate::simulator::record::SAMPLE_HZ`] per second.
    pub fn add(&mut self, sample: &Sample) {
        let truth = &sample.truth;
        let received = &sample.received;
        self.phases.add(sample);
        self.armed |= received.guard_state == "armed";
        self.toppled |= truth.toppled;
        self.came_off = self.came_off.or(truth.came_off);
        if let Some(belt) = &mut self.belt {
            belt.add(sample, &self.phases);
        }
        self.motion.add(sample);
        self.pitch_deg = Some(Range::with(self.pitch_deg, truth.pitch.to_degrees()));
        self.backward_margin_m = least(self.backward_margin_m, truth.backward_margin);
        self.guard_margin_m = least(self.guard_margin_m, notes::guard_margin(sample));
        if let Some(balance) = &mut self.balance {
            balance.add(sample);
        }
        self.channels.add(sample);
        self.interventions.add(&received.verdict);
        self.hold.add(sample);
        self.load_max = self.load_max.max(received.bus_load);
        self.load_sum += received.bus_load;
    }

    /// The summary of a run that ends now. Without samples all figures are zero.
    pub fn summary(self, scenario: &Scenario, facts: &RunFacts) -> Summary {
        let phases = &self.phases;
        let simulated_s = (facts.steps * STEP_US) as f64 / 1e6;
        let mut summary = Summary {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            expectation_met: false,
            unmet: Vec::new(),
            ended_early: None,
            clients: 0,
            notes: Vec::new(),
            armed: self.armed,
            landed: phases.landing().is_some(),
            toppled: self.toppled,
            landing_time_s: phases.landing().map(|landing| landing.time_s),
            stopped: self.motion.stopped(),
            simulated_s,
            wall_s: facts.wall_s,
            realtime_factor: if facts.wall_s > 0.0 {
                simulated_s / facts.wall_s
            } else {
                0.0
            },
            steps: facts.steps,
            tension_error_m: self.belt.map(|belt| belt.figures(phases)),
            driven_m: self.motion.driven_m(),
            pitch_deg: self.pitch_deg.unwrap_or_default(),
            min_backward_margin_m: self.backward_margin_m,
            min_guard_margin_m: self.guard_margin_m,
            zero_moment_point: self.balance.and_then(|balance| balance.finish().figures),
            channels: self.channels.figures(),
            headlines: scenario.kind().facts().headlines,
            guard: self.interventions.figures,
            bus: BusFigures {
                load_max: self.load_max,
                load_mean: self.load_sum / phases.end().index.max(1) as f64,
                frames: facts.frames,
                worst_latency_ms: facts.worst_latency_ms,
            },
            faults: facts.faults.clone(),
            nodes: facts.nodes.clone(),
            state_hash: facts.state_hash.clone(),
        };
        summary.unmet = summary.unmet_expectations(scenario);
        summary.notes = summary.explanations(scenario);
        summary.notes.extend(self.hold.note());
        summary.expectation_met = summary.unmet.is_empty();
        if let Some(what) = self.came_off {
            summary.end_early(&format!("the {what} came off"));
        }
        summary
    }
}

/// The smaller of two values, of which either may be absent.
fn least(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::min)
}

impl Summary {
    /// Computes all figures of the samples, which are in order of time.
    pub fn new(scenario: &Scenario, facts: &RunFacts, samples: &[Sample]) -> Self {
        let mut statistics = Statistics::new(scenario);
        for sample in samples {
            statistics.add(sample);
        }
        statistics.summary(scenario, facts)
    }

    /// Marks the run as ended early, for the reason `why`. Its expectation then counts as not met.
    pub fn end_early(&mut self, why: &str) {
        self.unmet.push(format!("The run ended early: {why}."));
        self.expectation_met = false;
        self.ended_early = Some(why.to_owned());
    }

    /// The channels that the terminal shows, with their figures.
    pub fn headlines(&self) -> impl Iterator<Item = (Channel, ChannelFigures)> {
        let found = |name: &&str| Some((Channel::new(name), *self.channels.get(*name)?));
        self.headlines.iter().filter_map(found)
    }
}
