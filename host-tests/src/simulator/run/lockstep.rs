//! Runs one step of a run: the actions of each participant within a millisecond of virtual time,
//! and their order.

use super::faults::Faults;
use super::flash::Flash;
use super::launch::Launch;
use super::listener::{Listener, View};
use super::node::Node;
use super::operator::Operator;
use super::{Options, RunError, Sink};
use crate::programs::{Programs, hexadecimal};
use crate::scenario::{ClientFrame, Event, Fault, Scenario};
use crate::simulator::bus::Bus;
use crate::simulator::facts::{NodeFacts, RunFacts};
use crate::simulator::record::{BusFrame, DriveState, Sample};
use crate::simulator::slcan::{MAX_CLIENTS, SlcanPort};
use crate::world::Plant;
use crate::world::hand::Path;
use crate::world::sensor_board::SensorBoard;
use sha2::{Digest, Sha256};
use std::collections::VecDeque;
use std::time::Duration;
use tautrack::link::{BodyMeasurands, MAX_FRAMES, MAX_SERIAL, STEP_US, Sensors, Shaft, Step};

/// Maximum number of a client's frames in a millisecond. After a pause of the run they would come
/// in a burst that keeps the guard's frames waiting.
const CLIENT_FRAMES: usize = 2;

/// Running simulation: a robot's nodes on their bus, its plant, the operator and the faults.
pub struct Run {
    /// The nodes in the robot's order, the guard last; `None` for a dead node. Their indices are
    /// their numbers on the bus, followed by those of the operator, the clients and the forger.
    nodes: Vec<Option<Node>>,
    launches: Vec<Launch>,
    _flash: Flash,
    /// Nodes that restart before the next step.
    restarting: Vec<usize>,
    /// Virtual time at which each node was last powered up, us; its clock starts there.
    powered_up_us: Vec<u64>,
    node_facts: Vec<NodeFacts>,
    bus: Bus,
    pub(super) plant: Box<dyn Plant>,
    hand: Path,
    /// Board of the sensors on the body, unless it is along the body's axes and without errors.
    sensor_board: Option<SensorBoard>,
    /// What acts on the sensors on the body in this step.
    body: BodyMeasurands,
    operator: Operator,
    listener: Listener,
    faults: Faults,
    pub(super) slcan: Option<SlcanPort>,
    /// Frames that a client of the scenario will send, the next one first.
    frames: VecDeque<ClientFrame>,
    hash: Sha256,
    /// Output shafts of the drives in the last step.
    shafts: Vec<Option<Shaft>>,
}

impl Run {
    /// Starts all nodes and creates the plant.
    ///
    /// # Errors
    /// [`RunError`] of a node that does not start.
    pub fn start(
        scenario: &Scenario,
        programs: &Programs,
        options: Options,
    ) -> Result<Self, RunError> {
        let specs = scenario.nodes();
        let mut nodes = Vec::new();
        let mut node_facts = Vec::new();
        let mut launches = Vec::new();
        let flash = Flash::of(&options);
        for (index, spec) in specs.iter().enumerate() {
            // Each node has its own noise.
            let seed = scenario
                .seed
                .wrapping_mul(0x1_0001)
                .wrapping_add(index as u64);
            let launch = Launch::new(spec, programs, &options, &flash, seed);
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
            _flash: flash,
            restarting: Vec::new(),
            node_facts,
            bus: Bus::new(specs.len() + 1 + MAX_CLIENTS + 1),
            plant: scenario.plant(),
            hand: scenario.hand(),
            sensor_board: scenario.sensors.errors.board(),
            body: BodyMeasurands::default(),
            operator: Operator::new(scenario, guard, options.let_go_s, options.disarm_s),
            listener: Listener::new(&specs, &scenario.robot),
            faults: Faults::new(scenario, specs.iter().map(|spec| spec.name).collect()),
            slcan: options.slcan,
            frames: scenario.frames.iter().cloned().collect(),
            hash: Sha256::new(),
            shafts: Vec::new(),
        })
    }

    /// Runs one millisecond: the bus delivers frames, nodes and operator answer, and the plant
    /// moves. Frames and log lines go to `sink`. The first step has the number 1.
    ///
    /// # Errors
    /// [`RunError`]. After one the run must not be used.
    pub fn step(&mut self, step: u64, sink: &mut dyn Sink) -> Result<(), RunError> {
        let time_us = step * STEP_US;
        let mut reset = std::mem::take(&mut self.restarting);
        reset.retain(|node| self.nodes[*node].is_some());
        let powered = self.faults.apply(time_us, &mut self.bus, &mut self.nodes);
        for index in reset.into_iter().chain(powered) {
            let (node, _) = self.launches[index].start()?;
            self.nodes[index] = Some(node);
            self.powered_up_us[index] = time_us - STEP_US;
        }
        self.deliver(time_us, sink)?;

        let acting = self.plant.body_sensors();
        let acting = self
            .sensor_board
            .map_or(acting, |board| board.measurands(acting));
        self.body = BodyMeasurands {
            faults: self.faults.of_chips(),
            ..acting
        };
        for number in 0..self.guard_number() {
            self.send(number, time_us)?;
        }
        let frame = self.operator.tick(time_us, self.listener.view());
        if let Some(frame) = frame.filter(|_| !self.faults.of_operator()) {
            self.bus.offer(self.operator_number(), frame)?;
        }
        let first = self.first_client_number();
        if let Some(port) = &mut self.slcan {
            let room = |client| self.bus.room(first + client).min(CLIENT_FRAMES);
            for (client, frame) in port.poll(room) {
                self.bus.offer(first + client, frame)?;
            }
        }
        while self.bus.room(first) > 0
            && let Some(next) = self.frames.front()
            && next.at_ms <= step
        {
            if let Some(frame) = next.frame() {
                self.bus.offer(first, frame)?;
            }
            self.frames.pop_front();
        }
        for frame in self.faults.forged(time_us) {
            self.bus.offer(first + MAX_CLIENTS, frame)?;
        }
        let guard = self.guard_number();
        let mut shafts = Vec::with_capacity(guard);
        for number in 0..guard {
            // The plant waits for the drives alone. So the guard starts late: it computes while the
            // last drive does, and while the plant moves.
            if number == guard.saturating_sub(2) {
                self.send(guard, time_us)?;
            }
            self.plant
                .set_track_fault(number, self.faults.of_track(number));
            shafts.push(self.receive(number, time_us, sink)?);
        }
        self.shafts = shafts;
        self.plant
            .hold(self.hand.at(time_us as f64 * 1e-6).as_ref());
        self.plant.step(&self.shafts);
        let hash = &mut self.hash;
        self.plant.truth_bits(&mut |bytes| hash.update(bytes));
        self.receive(guard, time_us, sink)?;
        Ok(())
    }

    /// Sends this step's sensor values and the frames that the bus has delivered to a node.
    fn send(&mut self, number: usize, time_us: u64) -> Result<(), RunError> {
        let sensors = self.sensors(number);
        let mut serial = heapless::Vec::new();
        if number == self.guard_number() {
            // The serial line is slower than what a step message can carry.
            serial.extend(self.plant.serial().iter().copied().take(MAX_SERIAL));
        }
        let Some(node) = &mut self.nodes[number] else {
            return Ok(());
        };
        let delivered = self.bus.received_by(number);
        node.send(Step {
            time_us: time_us - self.powered_up_us[number],
            sensors,
            // A bus at 1 Mbit/s cannot deliver more frames in one step than the message holds.
            frames: delivered
                .map(|delivered| delivered.frame)
                .take(MAX_FRAMES)
                .collect(),
            serial,
        })?;
        Ok(())
    }

    fn guard_number(&self) -> usize {
        self.nodes.len() - 1
    }

    fn operator_number(&self) -> usize {
        self.nodes.len()
    }

    fn first_client_number(&self) -> usize {
        self.nodes.len() + 1
    }

    /// Runs the bus for one step. Operator, report and hash receive every frame; a client receives
    /// all except its own.
    fn deliver(&mut self, time_us: u64, sink: &mut dyn Sink) -> Result<(), RunError> {
        let first = self.first_client_number();
        for delivered in self.bus.step() {
            let frame = &delivered.frame;
            self.hash
                .update([delivered.sender as u8, frame.data().len() as u8]);
            self.hash.update(frame.id().to_le_bytes());
            self.hash.update(frame.data());
            self.listener.receive(frame, time_us);
            sink.frame(&BusFrame {
                time_us,
                sender: delivered.sender,
                frame: *frame,
            })?;
            if let Some(port) = &mut self.slcan {
                port.send(frame, delivered.sender.checked_sub(first), time_us);
            }
        }
        if let Some(port) = &mut self.slcan {
            port.wait_for_readers();
        }
        self.faults.notice(time_us, &mut self.listener);
        Ok(())
    }

    fn sensors(&self, node: usize) -> Sensors {
        if node == self.guard_number() {
            let body = Some(self.body);
            return Sensors {
                supply_voltage: self.plant.sensors(0).supply_voltage,
                body,
                ..Sensors::default()
            };
        }
        let mut sensors = self.plant.sensors(node);
        self.faults.change(node, &mut sensors);
        sensors
    }

    /// Receives a node's answer: frames for the bus, the log, and the shaft, which it returns.
    fn receive(
        &mut self,
        number: usize,
        time_us: u64,
        sink: &mut dyn Sink,
    ) -> Result<Option<Shaft>, RunError> {
        let Some(node) = &mut self.nodes[number] else {
            return Ok(None);
        };
        let stepped = node.receive()?;
        for line in node.log_lines(&stepped) {
            let time_s = time_us as f64 * 1e-6;
            sink.log(&format!("{time_s:.3} {}: {line}", node.name()))?;
        }
        for frame in stepped.frames {
            self.bus.offer(number, frame)?;
        }
        if stepped.restart {
            self.restarting.push(number);
        }
        Ok(Some(stepped.shaft))
    }

    /// The simulated robot on its ground.
    pub fn plant(&self) -> &dyn Plant {
        self.plant.as_ref()
    }

    /// What the operator can read from the bus.
    pub fn view(&self) -> &View {
        self.listener.view()
    }

    /// Whether each node has power, in the robot's order.
    pub fn powered(&self) -> impl Iterator<Item = bool> {
        self.nodes.iter().map(Option::is_some)
    }

    /// Adds an event to the operator's script.
    pub fn add_event(&mut self, event: Event) {
        self.operator.add(event);
    }

    /// Adds a fault behind the others.
    pub fn add_fault(&mut self, fault: Fault) {
        self.faults.add(fault);
    }

    /// Lets the fault with this index end at this time, s.
    pub fn end_fault(&mut self, index: usize, until_s: f64) {
        self.faults.end_at(index, until_s);
    }

    /// Adds a frame to those of the scenario's client, behind those of the same time.
    pub fn add_frame(&mut self, frame: ClientFrame) {
        let place = self.frames.partition_point(|of| of.at_ms <= frame.at_ms);
        self.frames.insert(place, frame);
    }

    /// Number of events of the operator's script that have taken effect.
    pub fn events_done(&self) -> usize {
        self.operator.events_done()
    }

    /// Returns the sample of this step.
    pub fn sample(&mut self, step: u64) -> Sample {
        let mut received = self.listener.take();
        received.bus_load = self.bus.figures().window_load();
        let drive = |(motor, shaft): (usize, &Option<Shaft>)| {
            let torque = f64::from(self.plant.sensors(motor).shaft_torque);
            shaft.as_ref().map(|shaft| DriveState::new(shaft, torque))
        };
        Sample {
            time_s: (step * STEP_US) as f64 * 1e-6,
            truth: self.plant.truth().clone(),
            received,
            drives: self.shafts.iter().enumerate().map(drive).collect(),
            bodies: self.plant.poses(),
            belts: self.plant.belts(),
        }
    }

    /// Virtual times at which the operator's script changed the command, including its start, s.
    pub fn commands_s(&self) -> Vec<f64> {
        let times = self.operator.commands_us().iter();
        times.map(|time_us| *time_us as f64 * 1e-6).collect()
    }

    /// Returns the facts about a run of `steps` steps that took `wall` of wall-clock time.
    pub fn facts(&self, wall: Duration, steps: u64) -> RunFacts {
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
