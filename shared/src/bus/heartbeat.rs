//! Heartbeat consumer (`CiA` 301, object 0x1016): is another node still there?

/// Watches the heartbeat of one node.
#[derive(Clone, Copy, Debug)]
pub struct Monitor {
    timeout_us: u64,
    /// Until when it is not lost; the end of time before it was received.
    until_us: u64,
}

impl Monitor {
    /// Monitor that calls a node lost after `timeout_us` of silence.
    pub fn new(timeout_us: u64) -> Self {
        Self {
            timeout_us,
            until_us: u64::MAX,
        }
    }

    /// The node was received at `now_us`.
    pub fn received(&mut self, now_us: u64) {
        self.until_us = now_us.saturating_add(self.timeout_us);
    }

    /// Received at least once since the start.
    pub fn seen(&self) -> bool {
        self.until_us != u64::MAX
    }

    /// Seen once, and silent for longer than the timeout. A node that was never seen is not lost: it was never there.
    pub fn lost(&self, now_us: u64) -> bool {
        now_us > self.until_us
    }

    /// Seen, and not lost.
    pub fn alive(&self, now_us: u64) -> bool {
        self.seen() && !self.lost(now_us)
    }
}

#[cfg(test)]
mod tests {
    use super::Monitor;

    #[test]
    fn a_node_is_lost_only_after_it_was_there() {
        let mut monitor = Monitor::new(100);
        assert!(!monitor.lost(1_000_000) && !monitor.alive(1_000_000));
        monitor.received(1_000_000);
        assert!(monitor.alive(1_000_100));
        assert!(monitor.lost(1_000_101));
    }
}
