//! What is made of a run: the [`phases`] and the [`channel`]s in it, [`zmp`], the moments of balance, the [`summary`] of all, [`mcap`]
//! for log viewers, and the [`report`] page.

pub mod channel;
pub mod mcap;
pub mod phases;
pub mod report;
pub mod summary;
pub mod zmp;
