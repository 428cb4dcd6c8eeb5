//! The lockstep runner: node programs, one bus, one plant, one operator, a millisecond at a time.
//!
//! [`process`] talks to one node program, `node_log` reads what it logs, `launch` starts it, [`operator`] drives,
//! [`listener`] decodes what the bus makes public, [`faults`] makes things go wrong. Here: the order of one step.

pub mod faults;
mod launch;
pub mod listener;
mod node_log;
pub mod operator;
pub mod process;

use crate::bus::{Bus, Overflow};
use crate::machines::{self, Machine};
use crate::nodes::{Board, Program, Programs, hexadecimal};
use crate::plant::Plant;
use crate::record::{SAMPLE_HZ, Sample};
use crate::scenario::{NodeName, Scenario};
use crate::slcan::SlcanPort;
use crate::summary::{NodeFacts, RunFacts};
use faults::Faults;
use launch::Launch;
use listener::Listener;
use operator::Operator;
use process::{Node, NodeError};
use sha2::{Digest, Sha256};
use std::fmt;
use std::time::{Duration, Instant};
use tautrack::can::Frame;
use tautrack::link::{MAX_FRAMES, MAX_SERIAL, STEP_US, Sensors, Shaft, Step};

/// Steps that a run goes on after the robot turned over, when it ends for that.
const AFTER_TOPPLING: u64 = 500;
/// Slower than these is standing still.
const STILL_MPS: f64 = 0.005;
const STILL_RADPS: f64 = 0.02;

/// How a scenario is run.
#[derive(Default)]
pub struct Options {
    /// Programs that take the place of a node's own, with the board that they are built for.
    pub exchanged: Vec<(NodeName, Board, Program)>,
    /// Virtual seconds per second of the wall clock at the most; as fast as possible when absent.
    pub speed: Option<f64>,
    /// Virtual time at which the operator lets go: no speed asked any more, the chassis left as it is, s.
    pub let_go_s: Option<f64>,
    /// Virtual time from which the operator requests to disarm, s.
    pub disarm_s: Option<f64>,
    /// Ends the run half a second after the robot turned over.
    pub end_when_toppled: bool,
    /// Ends the run once the armed robot has stood still for so long, s.
    pub end_when_still_s: Option<f64>,
    /// A port through which a CAN client from elsewhere takes part; the run keeps to the wall clock while one does.
    pub slcan: Option<SlcanPort>,
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
    /// What only the runner knows.
    pub facts: RunFacts,
    /// Log lines of the nodes, with time and node.
    pub log: Vec<String>,
    /// Virtual times at which the operator's script changed what is commanded, its start included, s.
    pub commands_s: Vec<f64>,
}

/// Why a run ended before its time.
#[derive(Debug)]
pub enum RunError {
    /// A node could not be started, refused its settings, or did not answer.
    Node(NodeError),
    /// A node or the operator sends more than the bus can carry.
    Overflow(Overflow),
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Node(error) => write!(f, "{error}"),
            Self::Overflow(error) => write!(f, "the bus is overloaded: {error}"),
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
    let end_when_toppled = options.end_when_toppled;
    let end_when_still_s = options.end_when_still_s.unwrap_or(f64::INFINITY);
    let mut still_since_s = 0.0;
    let mut run = Run::start(scenario, programs, options)?;
    let mut steps = (scenario.duration_s * 1e6) as u64 / STEP_US;
    let began = Instant::now();
    let mut samples = Vec::new();
    let mut step = 0;
    while step < steps {
        step += 1;
        run.step(step)?;
        if step % (1_000 / u64::from(SAMPLE_HZ)) == 0 {
            let sample = run.sample(step);
            progress(&Progress {
                time_s: sample.time_s,
                speed: sample.heard.passed_speed,
                state: &sample.heard.guard_state,
            });
            if !is_still(samples.last(), &sample) {
                still_since_s = sample.time_s;
            }
            if sample.time_s - still_since_s >= end_when_still_s {
                steps = step;
            }
            samples.push(sample);
        }
        run.keep_pace(began, step);
        if end_when_toppled && run.plant.truth().toppled {
            steps = steps.min(step + AFTER_TOPPLING);
        }
    }
    Ok(Outcome {
        samples,
        facts: run.facts(began.elapsed(), steps),
        commands_s: run
            .operator
            .commands_us()
            .iter()
            .copied()
            .map(seconds)
            .collect(),
        log: run.log,
    })
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

fn seconds(microseconds: u64) -> f64 {
    microseconds as f64 * 1e-6
}

struct Run {
    /// In the order of the machine's, the guard last; their places are their numbers on the bus, where operator and client follow.
    nodes: Vec<Option<Node>>,
    launches: Vec<Launch>,
    /// Virtual time at which each node was last powered up, us: its clock begins there.
    powered_up_us: Vec<u64>,
    node_facts: Vec<NodeFacts>,
    bus: Bus,
    plant: Box<dyn Plant>,
    operator: Operator,
    listener: Listener,
    faults: Faults,
    slcan: Option<SlcanPort>,
    speed: Option<f64>,
    hash: Sha256,
    log: Vec<String>,
}

impl Run {
    fn start(scenario: &Scenario, programs: &Programs, options: Options) -> Result<Self, RunError> {
        let Machine {
            kind,
            nodes: specs,
            plant,
        } = machines::machine(scenario);
        let mut nodes = Vec::new();
        let mut node_facts = Vec::new();
        let mut launches = Vec::new();
        for (index, spec) in specs.iter().enumerate() {
            // Each node's noise is its own.
            let seed = scenario
                .seed
                .wrapping_mul(0x1_0001)
                .wrapping_add(index as u64);
            let launch = Launch::new(spec, programs, &options.exchanged, seed);
            let (node, ready) = launch.start()?;
            nodes.push(Some(node));
            node_facts.push(NodeFacts {
                name: spec.name,
                role: ready.role.to_string(),
                board: ready.board.to_string(),
                node_id: spec.id,
                program_sha256: launch.program_sha256().to_owned(),
            });
            launches.push(launch);
        }
        let guard = specs.last().map_or(0, |spec| spec.id);
        Ok(Self {
            powered_up_us: vec![0; nodes.len()],
            nodes,
            launches,
            node_facts,
            bus: Bus::new(specs.len() + 2),
            plant,
            operator: Operator::new(scenario, guard, options.let_go_s, options.disarm_s),
            listener: Listener::new(&specs, kind.stages()),
            faults: Faults::new(scenario, specs.iter().map(|spec| spec.name).collect()),
            slcan: options.slcan,
            speed: options.speed,
            hash: Sha256::new(),
            log: Vec::new(),
        })
    }

    /// One millisecond: what was offered is delivered, the nodes and the operator answer, the world moves.
    fn step(&mut self, step: u64) -> Result<(), RunError> {
        let time_us = step * STEP_US;
        for index in self.faults.apply(time_us, &mut self.bus, &mut self.nodes) {
            let (node, _) = self.launches[index].start()?;
            self.nodes[index] = Some(node);
            self.powered_up_us[index] = time_us - STEP_US;
        }
        self.deliver(time_us);

        let mut inboxes = vec![heapless::Vec::<Frame, MAX_FRAMES>::new(); self.nodes.len()];
        for (index, inbox) in inboxes.iter_mut().enumerate() {
            // A bus at 1 Mbit/s cannot deliver more in one step than the inbox holds.
            inbox.extend(
                self.bus
                    .received_by(index)
                    .map(|delivered| delivered.frame)
                    .take(MAX_FRAMES),
            );
        }
        for (index, frames) in inboxes.into_iter().enumerate() {
            let sensors = self.sensors(index);
            let mut serial = heapless::Vec::new();
            if index == self.guard_number() {
                // The line is slower than what a step can carry.
                serial.extend(self.plant.serial().iter().copied().take(MAX_SERIAL));
            }
            if let Some(node) = &mut self.nodes[index] {
                node.send(Step {
                    time_us: time_us - self.powered_up_us[index],
                    sensors,
                    frames,
                    serial,
                })?;
            }
        }
        if let Some(frame) = self.operator.tick(time_us, self.listener.view()) {
            self.bus.offer(self.operator_number(), frame)?;
        }
        let client = self.client_number();
        if let Some(port) = &mut self.slcan {
            for frame in port.poll(self.bus.room(client)) {
                self.bus.offer(client, frame)?;
            }
        }
        let shafts = self.collect(time_us)?;
        self.plant.step(&shafts);
        let hash = &mut self.hash;
        self.plant.truth_bits(&mut |bytes| hash.update(bytes));
        Ok(())
    }

    fn guard_number(&self) -> usize {
        self.nodes.len() - 1
    }

    fn operator_number(&self) -> usize {
        self.nodes.len()
    }

    fn client_number(&self) -> usize {
        self.nodes.len() + 1
    }

    /// Lets the bus work for one step; operator, client, report and hash hear everything.
    fn deliver(&mut self, time_us: u64) {
        let client = self.client_number();
        for delivered in self.bus.step() {
            let frame = &delivered.frame;
            self.hash
                .update([delivered.sender as u8, frame.data().len() as u8]);
            self.hash.update(frame.id().to_le_bytes());
            self.hash.update(frame.data());
            self.listener.hear(frame, time_us);
            if let Some(port) = self.slcan.as_mut().filter(|_| delivered.sender != client) {
                port.send(frame);
            }
        }
        self.faults.notice(time_us, &mut self.listener);
    }

    fn sensors(&self, node: usize) -> Sensors {
        if node == self.guard_number() {
            let body = Some(self.plant.body_sensors());
            return Sensors {
                bus_voltage: self.plant.sensors(0).bus_voltage,
                body,
                ..Sensors::default()
            };
        }
        Sensors {
            encoder_frozen: self.faults.encoder_frozen(node),
            ..self.plant.sensors(node)
        }
    }

    /// Takes the nodes' answers: shafts for the plant, frames for the bus.
    fn collect(&mut self, time_us: u64) -> Result<Vec<Option<Shaft>>, RunError> {
        let mut shafts = vec![None; self.guard_number()];
        for (index, slot) in self.nodes.iter_mut().enumerate() {
            let Some(node) = slot else { continue };
            let stepped = node.receive()?;
            if let Some(shaft) = shafts.get_mut(index) {
                *shaft = Some(stepped.shaft);
            }
            for line in node.log_lines(&stepped) {
                let time_s = time_us as f64 * 1e-6;
                self.log
                    .push(format!("{time_s:.3} {}: {line}", node.name()));
            }
            for frame in stepped.frames {
                self.bus.offer(index, frame)?;
            }
        }
        Ok(shafts)
    }

    fn sample(&mut self, step: u64) -> Sample {
        let mut heard = self.listener.take();
        heard.bus_load = self.bus.figures().window_load();
        Sample {
            time_s: (step * STEP_US) as f64 * 1e-6,
            truth: self.plant.truth().clone(),
            heard,
        }
    }

    /// Waits when the run is ahead of the pace that was asked for; a client from elsewhere lives by the wall clock.
    fn keep_pace(&self, began: Instant, step: u64) {
        let attached = self.slcan.as_ref().is_some_and(SlcanPort::attached);
        let Some(speed) = self.speed.or(attached.then_some(1.0)) else {
            return;
        };
        let due = Duration::from_secs_f64((step * STEP_US) as f64 * 1e-6 / speed);
        std::thread::sleep(due.saturating_sub(began.elapsed()));
    }

    fn facts(&self, wall: Duration, steps: u64) -> RunFacts {
        let hash = self.hash.clone().finalize();
        RunFacts {
            wall_s: wall.as_secs_f64(),
            steps,
            nodes: self.node_facts.clone(),
            frames: self.bus.figures().frames(),
            worst_latency_ms: self.bus.figures().worst_latency_ms(),
            faults: self.faults.facts(),
            state_hash: hexadecimal(&hash),
        }
    }
}
