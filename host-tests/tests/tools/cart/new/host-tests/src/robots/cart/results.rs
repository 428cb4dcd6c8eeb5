//! The results of the cart: it adds nothing.

use super::section::Cart;
use crate::results::robot::Results;

impl Results for Cart {}
