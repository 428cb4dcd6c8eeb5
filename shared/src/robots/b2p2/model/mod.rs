//! The paper's equations that no node runs: kinematics, dynamics and reactions for any scalar type.

pub mod actuation;
pub mod belt;
pub mod dynamics;
pub mod jacobian;
pub mod newton_euler;
pub mod posture;
