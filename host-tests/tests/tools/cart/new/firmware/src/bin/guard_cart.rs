//! Node program of the role `guard`, for the cart.
#![cfg_attr(target_os = "none", no_std, no_main)]

tautrack_firmware::program!(guard::cart, axle);
