//! The cart: two driven wheels on one axle, a caster behind it, and a mast that carries a load.
//!
//! [`parameters`] has dimensions and masses, [`model`] the rates of the wheels and the contacts,
//! [`body`] the guard's interface. The origin is on the ground below the middle of the axle; x
//! forward, y left, z up.

pub mod body;
pub mod model;
pub mod parameters;

pub use body::Cart;
