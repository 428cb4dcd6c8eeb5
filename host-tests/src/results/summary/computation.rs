//! Computes the summary from the samples of a run.

use super::belt::tension_error;
use super::channels::{channels, range};
use super::motion::{path, stopped};
use super::verdicts::guard_figures;
use super::{BusFigures, ChannelFigures, Summary, notes};
use crate::results::channel::Channel;
use crate::results::phases::{climb, landing};
use crate::results::zmp::Balance;
use crate::robots::Kind;
use crate::scenario::Scenario;
use crate::simulator::facts::RunFacts;
use crate::simulator::record::{SAMPLE_HZ, Sample};
use tautrack::link::STEP_US;

impl Summary {
    /// Computes all figures. Samples are in order of time, [`SAMPLE_HZ`] per second. Without
    /// samples all figures are zero.
    pub fn new(scenario: &Scenario, facts: &RunFacts, samples: &[Sample]) -> Self {
        let landing = landing(scenario, samples);
        let climb = climb(scenario, samples);
        let is_b2p2 = scenario.kind() == Kind::B2p2;
        let simulated_s = (facts.steps * STEP_US) as f64 / 1e6;
        let loads = || samples.iter().map(|sample| sample.received.bus_load);
        let mut summary = Self {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            expectation_met: false,
            unmet: Vec::new(),
            ended_early: None,
            clients: 0,
            notes: Vec::new(),
            landed: landing.is_some(),
            toppled: samples.iter().any(|sample| sample.truth.toppled),
            landing_time_s: landing.map(|index| samples[index].time_s),
            stopped: stopped(samples),
            simulated_s,
            wall_s: facts.wall_s,
            realtime_factor: if facts.wall_s > 0.0 {
                simulated_s / facts.wall_s
            } else {
                0.0
            },
            steps: facts.steps,
            tension_error_m: is_b2p2.then(|| tension_error(&samples[climb])),
            driven_m: path(samples) / f64::from(SAMPLE_HZ),
            pitch_deg: range(samples.iter().map(|sample| sample.truth.pitch.to_degrees())),
            min_backward_margin_m: samples
                .iter()
                .filter_map(|sample| sample.truth.backward_margin)
                .reduce(f64::min),
            min_guard_margin_m: notes::guard_margin(samples),
            zero_moment_point: is_b2p2
                .then(|| Balance::new(scenario, samples).figures)
                .flatten(),
            channels: channels(samples),
            headlines: scenario.kind().facts().headlines,
            guard: guard_figures(
                samples
                    .iter()
                    .map(|sample| sample.received.verdict.as_str()),
            ),
            bus: BusFigures {
                load_max: loads().fold(0.0, f64::max),
                load_mean: loads().sum::<f64>() / samples.len().max(1) as f64,
                frames: facts.frames,
                worst_latency_ms: facts.worst_latency_ms,
            },
            faults: facts.faults.clone(),
            nodes: facts.nodes.clone(),
            state_hash: facts.state_hash.clone(),
        };
        summary.unmet = summary.unmet_expectations(scenario);
        summary.notes = summary.explanations(scenario);
        summary.expectation_met = summary.unmet.is_empty();
        summary
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
