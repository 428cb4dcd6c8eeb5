//! Firmware of tautrack's nodes: everything around the control core (crate `tautrack`) that makes
//! it a program on a board.
//!
//! [`boards`] is the hardware interface and its implementations · `current_loop` the PWM interrupt
//! · [`bus`] CANopen · `serial` the serial line · [`sensors`] the chips of the sensors on the
//! robot's body · [`watchdog`] checks that all parts still run · [`storage`] settings in flash ·
//! `check` says whether a node would start, [`refusal`] why not · `log_lines` what it logs ·
//! `roles` the tasks of each kind of node · `cost` counts the instructions of the control code. A
//! binary picks one role and runs it on the selected board. Without a board, this is the library by
//! which the simulator holds nodes as values ([`boards::host`]).
#![no_std]
// The logging macros of the target (defmt) do not support inline arguments.
#![allow(clippy::uninlined_format_args)]

#[cfg(not(target_os = "none"))]
extern crate std;

pub mod boards;
#[cfg(any(test, target_os = "none"))]
pub mod bus;
mod check;
#[cfg(all(target_os = "none", feature = "cost"))]
pub mod cost;
#[cfg(target_os = "none")]
pub mod current_loop;
mod log_lines;
pub mod refusal;
#[cfg(target_os = "none")]
pub mod roles;
pub mod sensors;
#[cfg(target_os = "none")]
pub mod serial;
pub mod storage;
#[cfg(any(test, target_os = "none"))]
pub mod watchdog;

// One set of logging macros: defmt on the target (records of a few bytes, which need an ELF file),
// text elsewhere.
#[cfg(target_os = "none")]
pub(crate) use defmt as logger;
#[cfg(not(target_os = "none"))]
pub(crate) use log as logger;
