//! The request for bench mode (object 0x2001): how long it stands.

use crate::node::axle::Outputs;

/// State of the request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bench {
    /// Bench mode was on after the last tick.
    on: bool,
    /// Faults were latched after the last tick: bench mode begins a tick after their reset.
    faulty: bool,
    /// Ticks since the last set-point, and after how many a client is gone.
    silent: u32,
    timeout: u32,
}

impl Bench {
    /// `timeout_ms` is the time after which a client is gone, ms.
    pub fn new(timeout_ms: u32) -> Self {
        Self {
            on: false,
            faulty: false,
            silent: 0,
            timeout: timeout_ms,
        }
    }

    /// Takes the outputs of a tick, and whether a set-point came in it. Returns whether the request
    /// stands. It ends with bench mode, and with the guard. One that was made with faults latched
    /// stands until they are reset, as long as the client commands.
    pub fn stands(&mut self, outputs: &Outputs, set_point: bool, guarded: bool) -> bool {
        self.silent = if set_point {
            0
        } else {
            self.silent.saturating_add(1)
        };
        let ended = core::mem::replace(&mut self.on, outputs.bench_mode) && !outputs.bench_mode;
        let faulty = !outputs.faults.is_empty();
        let waits = core::mem::replace(&mut self.faulty, faulty) || faulty;
        let waits = waits && !ended && !guarded && self.silent <= self.timeout;
        outputs.bench_mode || waits
    }
}
