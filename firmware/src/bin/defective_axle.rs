//! Program of an axle with one of several defects on purpose, for the tests of the images.
#![no_std]
#![no_main]

tautrack_firmware::program!(axle);
