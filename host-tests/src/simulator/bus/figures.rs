//! Statistics of the bus in a run: load and latency.

use super::wire::BITS_PER_STEP;
use std::collections::BTreeMap;
use tautrack::link::STEP_US;

/// Length of the window over which the load is averaged, in steps; equals 100 ms.
pub const WINDOW_STEPS: usize = (100_000 / STEP_US) as usize;

/// Load and latency since the start of a run. All bits are counted with worst-case stuffing, so the
/// load of a real bus is lower.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Busy bits of the last [`WINDOW_STEPS`] steps; 0 for steps before the start.
    window: [u32; WINDOW_STEPS],
    window_bits: u64,
    busiest_window_bits: u64,
    busiest_step_bits: u32,
    total_bits: u64,
    steps: u64,
    worst_latency_us: BTreeMap<u16, u64>,
    frames: u64,
    lost: u64,
    collisions: u64,
    deepest_queue: usize,
}

impl Default for Figures {
    fn default() -> Self {
        Self {
            window: [0; WINDOW_STEPS],
            window_bits: 0,
            busiest_window_bits: 0,
            busiest_step_bits: 0,
            total_bits: 0,
            steps: 0,
            worst_latency_us: BTreeMap::new(),
            frames: 0,
            lost: 0,
            collisions: 0,
            deepest_queue: 0,
        }
    }
}

impl Figures {
    pub(super) fn count_step(&mut self, busy_bits: u32) {
        let slot = &mut self.window[(self.steps % WINDOW_STEPS as u64) as usize];
        self.window_bits += u64::from(busy_bits);
        self.window_bits -= u64::from(*slot);
        *slot = busy_bits;
        self.busiest_window_bits = self.busiest_window_bits.max(self.window_bits);
        self.busiest_step_bits = self.busiest_step_bits.max(busy_bits);
        self.total_bits += u64::from(busy_bits);
        self.steps += 1;
    }

    pub(super) fn count_delivery(&mut self, id: u16, latency_us: u64) {
        self.frames += 1;
        let worst = self.worst_latency_us.entry(id).or_default();
        *worst = latency_us.max(*worst);
    }

    pub(super) fn count_loss(&mut self) {
        self.lost += 1;
    }

    pub(super) fn count_collision(&mut self) {
        self.collisions += 1;
    }

    pub(super) fn count_queue(&mut self, depth: usize) {
        self.deepest_queue = self.deepest_queue.max(depth);
    }

    /// Number of steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Number of frames that were delivered.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Number of frames that were offered but not delivered: sent by a participant that was cut
    /// off, or lost on the wire.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Number of times that two participants started to send the same identifier at once; each is
    /// an error of the bus plan.
    pub fn collisions(&self) -> u64 {
        self.collisions
    }

    /// Maximum number of frames that one participant had waiting.
    pub fn deepest_queue(&self) -> usize {
        self.deepest_queue
    }

    /// Load of the bus in the last step: the fraction of the time during which it was busy, 0 to 1.
    pub fn step_load(&self) -> f64 {
        let last = (self.steps + WINDOW_STEPS as u64 - 1) % WINDOW_STEPS as u64;
        share(u64::from(self.window[last as usize]), 1)
    }

    /// Load of the bus in the last 100 ms: the fraction of the time during which it was busy, 0 to
    /// 1.
    pub fn window_load(&self) -> f64 {
        share(self.window_bits, WINDOW_STEPS as u64)
    }

    /// Maximum of [`Self::step_load`] so far.
    pub fn busiest_step_load(&self) -> f64 {
        share(u64::from(self.busiest_step_bits), 1)
    }

    /// Maximum of [`Self::window_load`] so far.
    pub fn busiest_window_load(&self) -> f64 {
        share(self.busiest_window_bits, WINDOW_STEPS as u64)
    }

    /// Load of the bus in the whole run: the fraction of the time during which it was busy, 0 to 1;
    /// 0 before the first step.
    pub fn mean_load(&self) -> f64 {
        share(self.total_bits, self.steps.max(1))
    }

    /// Maximum time from the offer of a frame to its last bit, ms; 0 without frames. A node
    /// receives the frame at the end of the step, so the time that it sees is rounded up to whole
    /// steps.
    pub fn worst_latency_ms(&self) -> f64 {
        milliseconds(self.worst_latency_us.values().copied().max().unwrap_or(0))
    }

    /// [`Self::worst_latency_ms`] of each identifier that was delivered, lowest identifier first.
    pub fn worst_latency_by_id_ms(&self) -> impl Iterator<Item = (u16, f64)> {
        self.worst_latency_us
            .iter()
            .map(|(id, us)| (*id, milliseconds(*us)))
    }
}

fn share(bits: u64, steps: u64) -> f64 {
    bits as f64 / (steps * u64::from(BITS_PER_STEP)) as f64
}

fn milliseconds(us: u64) -> f64 {
    us as f64 / 1_000.0
}
