//! What the page draws at a moment: the state of the run and its frames. What does not change is in
//! [`crate::results::scene`].

use super::Drive;
use crate::simulator::record::BusFrame;
use serde_json::{Value, json};

/// The state after the last step.
pub fn state(drive: &mut Drive) -> Value {
    let sample = drive.sample();
    json!({
        "sample": sample,
        "forces": drive.plant().forces(),
        "powered": drive.powered(),
        "commanded": drive.commanded(),
        "requested": drive.requested(),
        "faults": drive.active_faults(),
    })
}

/// Delivered frames: time in ms, sender, identifier and data of each.
pub fn frames(frames: &mut Vec<BusFrame>) -> Value {
    let frames = frames.drain(..);
    frames
        .map(|of| {
            json!([
                of.time_us / 1_000,
                of.sender,
                of.frame.id(),
                of.frame.data()
            ])
        })
        .collect()
}
