//! Node program of the role `guard`, for the cart.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_main)]

use tautrack_firmware::roles::{axle, guard};

tautrack_firmware::program!(guard::CART, axle::ROLE);
