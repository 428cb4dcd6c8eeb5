//! Heartbeat consumer (CiA 301, object 0x1016): detects that another node has fallen silent.

/// Monitors the heartbeat of one node.
#[derive(Clone, Copy, Debug)]
pub struct Monitor {
    timeout_us: u64,
    /// Last time, us, at which the node does not count as lost; `u64::MAX` before its first
    /// heartbeat.
    until_us: u64,
}

impl Monitor {
    /// Creates a monitor that reports the node as lost after `timeout_us` without a heartbeat.
    pub fn new(timeout_us: u64) -> Self {
        Self {
            timeout_us,
            until_us: u64::MAX,
        }
    }

    /// Records a heartbeat that was received at `now_us`.
    pub fn received(&mut self, now_us: u64) {
        self.until_us = now_us.saturating_add(self.timeout_us);
    }

    /// Returns whether a heartbeat was received since the start.
    pub fn seen(&self) -> bool {
        self.until_us != u64::MAX
    }

    /// Returns whether the node was received at least once, and has then been silent for longer
    /// than the timeout. A node that was never received is not lost.
    pub fn lost(&self, now_us: u64) -> bool {
        now_us > self.until_us
    }

    /// Returns whether the node was received and is not lost.
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
