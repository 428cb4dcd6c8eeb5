//! Evaluates and presents a run: [`phases`] finds climb and landing, [`channel`] names the
//! robot-specific channels, [`zmp`] computes centre of gravity and zero moment point, [`summary`]
//! computes the figures, [`mcap`] records everything for log viewers, [`report`] makes the HTML
//! page, [`scene`] is the 3-D scene of all pages. `robot` is what they ask of a robot.

pub mod channel;
#[cfg(unix)]
pub mod mcap;
pub mod phases;
pub mod report;
pub(crate) mod robot;
pub mod scene;
pub mod summary;
pub mod zmp;
