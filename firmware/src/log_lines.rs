//! Writes what a node's tick has found to its log.

use tautrack::math::{to_i16, to_i32};
use tautrack::roles::drive::Ticked;
use tautrack::roles::guard::Found;
use tautrack::sensing::trust::Trust;
use tautrack::stability::parameters::Refusal;

/// Logs what a tick of a drive has found.
pub fn drive(found: Ticked) {
    if let Some(code) = found.fault {
        crate::logger::warn!("fault {:#06x}", code);
    }
    if found.restart {
        crate::logger::info!("reset by the network management");
    }
}

/// Logs what a tick of the guard has found.
pub fn guard(found: &Found) {
    if let Some((code, node)) = found.fault {
        crate::logger::warn!("fault {:#06x} of node {}", code, node);
    }
    if let Some(mismatch) = found.mismatch {
        crate::logger::warn!(
            "node {}: position scale {:#06x}, the guard counts in {:#06x}",
            mismatch.node,
            mismatch.found,
            mismatch.expected
        );
    }
    if let Some(trip) = found.trip {
        crate::logger::warn!(
            "tripped: cause {:#04x}, margin {} mm",
            trip.cause.code(),
            to_i16(trip.margins[trip.edge as usize] * 1e3)
        );
    }
    match found.refusal {
        Some(Refusal::RateAtRest { rate, bound }) => crate::logger::warn!(
            "not armed: the gyroscope reads {} mdeg/s at rest, at most {}",
            to_i32(rate.to_degrees() * 1e3),
            to_i32(bound.to_degrees() * 1e3)
        ),
        Some(refusal) => crate::logger::warn!("not armed: reason {}", refusal.code()),
        None => {}
    }
    if let Some((phase, cause)) = found.clearance {
        crate::logger::info!("clearance: {} ({})", phase.name(), cause.words());
    }
    if let Some((sensor, health)) = found.sensor {
        if let Some(Trust::Degraded(reason) | Trust::None(reason)) = Trust::from_code(health) {
            crate::logger::warn!("{}: {}", sensor.name(), reason.words());
        } else {
            crate::logger::info!("{}: believed", sensor.name());
        }
    }
}
