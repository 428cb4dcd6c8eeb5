//! Frames that a client on the bus sends at given times.

use crate::bounds::{Problem, contradiction, within};
use serde::{Deserialize, Serialize};
use tautrack::can::Frame;

/// A frame that a client sends.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClientFrame {
    /// Virtual time at which the client offers it to the bus, ms.
    pub at_ms: u64,
    /// Identifier.
    pub id: u16,
    /// Data, at most eight bytes.
    pub data: Vec<u8>,
}

impl ClientFrame {
    /// The frame on the bus; `None` for bad values.
    pub fn frame(&self) -> Option<Frame> {
        Frame::new(self.id, &self.data)
    }
}

/// Checks the frames and their order.
pub(super) fn check(frames: &[ClientFrame]) -> Result<(), Problem> {
    let mut earliest = 0;
    for (index, frame) in frames.iter().enumerate() {
        let key = format!("frame[{index}]");
        let id = f64::from(frame.id);
        within(&format!("{key}.id"), id, 0.0, f64::from(Frame::MAX_ID), "")?;
        let length = frame.data.len() as f64;
        within(&format!("{key}.data"), length, 0.0, 8.0, "bytes")?;
        if frame.at_ms < earliest {
            return contradiction(&format!("{key}.at_ms"), "is before the frame before it");
        }
        earliest = frame.at_ms;
    }
    Ok(())
}
