//! The guard's decision on a command (its verdict), and the code of the verdict on the bus.

use super::support::{EDGES, Edge};
use crate::sensing::trust::Reason;

/// What the guard did with the newest command, and because of which edge or sensor problem.
///
/// An edge is an edge of the support, the one whose margin decided.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Verdict {
    /// The command passed as commanded.
    #[default]
    Passed,
    /// The speed was scaled down to protect the margin to this edge.
    Scaled(Edge),
    /// No speed passed, to protect the margin to this edge.
    Refused(Edge),
    /// The posture is held, to protect the margin to this edge.
    PostureRefused(Edge),
    /// Nothing passed: the sensors on the body are not believed, or the guard has tripped because
    /// of them.
    Blind(Reason),
    /// Nothing passed: the operator's commands timed out, or the dead-man switch is not held.
    Unattended,
    /// Nothing passed: the guard has tripped. The edge is the one with the narrowest margin then.
    Tripped(Edge),
    /// The guard has tripped; the operator's supervised override passes at crawl speed.
    Overridden(Edge),
    /// The guard has tripped; it backs off at crawl speed, as the operator requested.
    BackingOff(Edge),
    /// At most crawl speed passed: the sensors on the body are doubted.
    Doubted(Reason),
    /// The posture motion was slowed down, to protect the margin to this edge.
    PostureScaled(Edge),
    /// Nothing passed: the emergency stop was actuated and has not been reset.
    EmergencyStopped,
}

impl Verdict {
    /// Returns the code in object 0x4001:2. The high four bits are the kind of verdict, the low
    /// four bits are the edge or the reason.
    pub fn code(self) -> u8 {
        match self {
            Self::Passed => 0x00,
            Self::Scaled(edge) => 0x10 | edge as u8,
            Self::Refused(edge) => 0x20 | edge as u8,
            Self::PostureRefused(edge) => 0x30 | edge as u8,
            Self::Blind(reason) => 0x40 | reason as u8,
            Self::Unattended => 0x50,
            Self::Tripped(edge) => 0x60 | edge as u8,
            Self::Overridden(edge) => 0x70 | edge as u8,
            Self::BackingOff(edge) => 0x80 | edge as u8,
            Self::Doubted(reason) => 0x90 | reason as u8,
            Self::PostureScaled(edge) => 0xa0 | edge as u8,
            Self::EmergencyStopped => 0xb0,
        }
    }

    /// Returns the verdict with this code, if there is one.
    pub fn from_code(code: u8) -> Option<Self> {
        let low = code & 0x0f;
        if let (4 | 9, Some(reason)) = (code >> 4, Reason::from_byte(low)) {
            let doubted = code >> 4 == 9;
            return Some(if doubted {
                Self::Doubted(reason)
            } else {
                Self::Blind(reason)
            });
        }
        let edge = *EDGES.get(usize::from(low))?;
        Some(match code >> 4 {
            0 => Self::Passed,
            1 => Self::Scaled(edge),
            2 => Self::Refused(edge),
            3 => Self::PostureRefused(edge),
            5 => Self::Unattended,
            6 => Self::Tripped(edge),
            7 => Self::Overridden(edge),
            8 => Self::BackingOff(edge),
            10 => Self::PostureScaled(edge),
            11 => Self::EmergencyStopped,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_survive_their_codes() {
        for verdict in [
            Verdict::Passed,
            Verdict::Blind(Reason::Silent),
            Verdict::Unattended,
            Verdict::EmergencyStopped,
            Verdict::Doubted(Reason::Disagreement),
        ] {
            assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
        }
        for edge in EDGES {
            for verdict in [
                Verdict::Scaled(edge),
                Verdict::Refused(edge),
                Verdict::PostureRefused(edge),
                Verdict::PostureScaled(edge),
                Verdict::Tripped(edge),
                Verdict::Overridden(edge),
                Verdict::BackingOff(edge),
            ] {
                assert_eq!(Verdict::from_code(verdict.code()), Some(verdict));
            }
        }
    }
}
