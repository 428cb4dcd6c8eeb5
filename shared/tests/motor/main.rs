//! The loops of a motor against its equations.

mod cascade;
mod foc;
