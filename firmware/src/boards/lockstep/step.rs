//! Advances a lockstep board by one step of virtual time: `begin`, then `end` when the frames are
//! in the queue.

use super::attached::AttachedMotor;
use super::inputs::INPUTS;
use super::{POWER_STAGE, brake, chips, clock, log_buffer};
use crate::bus::TRANSMIT;
use crate::current_loop;
use embassy_executor::raw::Executor;
use tautrack::link::parts::Head;
use tautrack::link::{STEP_US, Shaft, Stepped};
use tautrack::motor::bridge::PowerStage;

/// Runs the PWM periods up to the step's time. Returns the motion of the output shaft.
pub(super) fn begin(
    head: &Head,
    motor: Option<&mut AttachedMotor>,
    stage: &mut PowerStage,
) -> Shaft {
    let mut shaft = Shaft::default();
    let (mut encoder, mut index) = (None, false);
    if let Some(attached) = motor {
        let motor = &mut attached.motor;
        motor.set_load(head.sensors.supply_voltage, head.sensors.shaft_torque);
        motor.freeze_sensor(head.sensors.encoder_frozen);
        motor.release_brake(brake::is_released());
        run_periods(attached, stage);
        shaft = attached.motor.shaft();
        encoder = Some((attached.encoder(), attached.encoder_broken()));
        index = attached.motor.take_index().is_some();
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

/// Runs the PWM periods of one step. Not inlined: the emulator searches for the translation of the
/// code whenever the program enters another page of 1 KiB. So the code that runs most often stands
/// in as few pages as possible.
#[inline(never)]
fn run_periods(attached: &mut AttachedMotor, stage: &mut PowerStage) {
    for _ in 0..u64::from(POWER_STAGE.pwm_hz) * STEP_US / 1_000_000 {
        // As with preloaded compare registers, the interrupt's decision takes effect in the next
        // period.
        let next = current_loop::pwm_period(&attached.readings());
        attached.motor.integrate(*stage);
        *stage = next;
    }
}

/// Has the node follow the frames that the bus has delivered, fires the timers, and takes the
/// frames and the log of the node.
pub(super) fn end(executor: &'static Executor, stepped: &mut Stepped) {
    clock::run_until_idle(executor);
    clock::fire_timers();
    clock::run_until_idle(executor);

    stepped.log.clear();
    take_log(&mut stepped.log);
    stepped.frames.clear();
    while !stepped.frames.is_full() {
        let Some(frame) = TRANSMIT.pop() else { break };
        let _ = stepped.frames.push(frame); // cannot fail: see the loop's condition
    }
}

fn take_log<const N: usize>(bytes: &mut heapless::Vec<u8, N>) {
    let dropped = log_buffer::with(|log| {
        log.take(bytes);
        log.take_dropped()
    });
    if dropped > 0 {
        crate::logger::warn!("{} log records were lost", dropped);
    }
}
