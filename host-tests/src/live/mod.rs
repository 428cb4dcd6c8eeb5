//! A run that goes on while somebody watches and drives it: the simulator as the page on the web
//! uses it.
//!
//! [`Drive`] is the run with its inputs, which it records as parts of a scenario. [`Session`]
//! answers the requests of the page, which `request` lists; `scene` is what the page draws.

mod drive;
mod request;
pub mod scene;
mod session;

pub use drive::{Command, Drive};
pub use session::Session;
