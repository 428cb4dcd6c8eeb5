//! Advances the emulated board by one step of virtual time: `begin`, then `end` when the frames are
//! in the queue.

use super::inputs::INPUTS;
use super::{brake, chips, clock, log};
use crate::boards::lockstep::AttachedMotor;
use crate::bus::TRANSMIT;
use crate::current_loop;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::raw::Executor;
use tautrack::link::parts::Head;
use tautrack::link::{Shaft, Stepped};

/// Runs the PWM periods up to the step's time. Returns the motion of the output shaft.
pub(super) fn begin(head: &Head, motor: Option<&mut AttachedMotor>) -> Shaft {
    let mut shaft = Shaft::default();
    let (mut encoder, mut index) = (None, false);
    if let Some(motor) = motor {
        let interrupt = current_loop::pwm_period;
        shaft = motor.step(&head.sensors, brake::is_released(), interrupt);
        encoder = Some((motor.encoder(), motor.encoder_broken()));
        index = motor.take_index();
    }
    critical_section::with(|cs| {
        let mut inputs = INPUTS.borrow(cs).borrow_mut();
        inputs.sensors = head.sensors;
        if let Some(encoder) = encoder {
            (inputs.encoder, inputs.encoder_broken) = encoder;
        }
        inputs.index |= index;
    });
    if let Some(body) = &head.sensors.body {
        chips::measure(body);
    }

    clock::set_now(head.time_us);
    crate::serial::put(head.serial);
    shaft
}

/// Has the node follow the frames that the bus has delivered, fires the timers, and takes the
/// frames and the log of the node.
pub(super) fn end(executor: &'static Executor, stepped: &mut Stepped) {
    clock::run_until_idle(executor);
    clock::fire_timers();
    clock::run_until_idle(executor);

    stepped.restart = RESTARTS.load(Ordering::Relaxed);
    stepped.log.clear();
    take_log(&mut stepped.log);
    stepped.frames.clear();
    while !stepped.frames.is_full() {
        let Some(frame) = TRANSMIT.pop() else { break };
        let _ = stepped.frames.push(frame); // cannot fail: see the loop's condition
    }
}

/// The simulator restarts the node after this step.
static RESTARTS: AtomicBool = AtomicBool::new(false);

/// Has the simulator restart the node.
pub(super) fn restart() {
    RESTARTS.store(true, Ordering::Relaxed);
}

fn take_log<const N: usize>(bytes: &mut heapless::Vec<u8, N>) {
    let dropped = log::with(|log| {
        log.take(bytes);
        log.take_dropped()
    });
    if dropped > 0 {
        crate::logger::warn!("{} log records were lost", dropped);
    }
}
