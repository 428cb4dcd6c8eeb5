//! Node program of the role `guard`, for the cart.
#![no_std]
#![no_main]

use tautrack_firmware::roles::{axle, guard};

tautrack_firmware::program!(guard::CART, axle::ROLE);
