//! What the tools ask of the cart.

mod evaluate;
mod operators;

use super::section::Cart;
use crate::scenario::Description;
use crate::tools::evaluate::Groups;
use crate::tools::robot::Tools;
use crate::tools::suite::draw::generator::Random;
use tautrack::math::Scalar;

impl Tools for Cart {
    fn operator(random: &mut Random) -> Description {
        operators::draw(random)
    }

    fn groups<S: Scalar>() -> Groups {
        vec![("cart", evaluate::functions::<S>())]
    }
}
