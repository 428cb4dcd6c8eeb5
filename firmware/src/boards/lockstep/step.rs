//! Advances a lockstep board by one step of virtual time.

use super::inputs::INPUTS;
use super::log_buffer::LOG;
use super::{POWER_STAGE, brake, chips, clock};
use crate::bus::{RECEIVED, TRANSMIT};
use crate::current_loop;
use embassy_executor::raw::Executor;
use tautrack::link::{STEP_US, Shaft, Step, Stepped};
use tautrack::motor::bridge::PowerStage;
use tautrack::motor::model::Motor;

/// Runs the PWM periods up to the step's time, then delivers the frames, then fires the timers.
pub(super) fn advance(
    step: &Step,
    executor: &'static Executor,
    motor: Option<&mut Motor>,
    stage: &mut PowerStage,
) -> Stepped {
    let mut shaft = Shaft::default();
    if let Some(motor) = motor {
        motor.set_load(step.sensors.supply_voltage, step.sensors.shaft_torque);
        motor.freeze_sensor(step.sensors.encoder_frozen);
        motor.release_brake(brake::is_released());
        for _ in 0..u64::from(POWER_STAGE.pwm_hz) * STEP_US / 1_000_000 {
            // As with preloaded compare registers, the interrupt's decision takes effect in the
            // next period.
            let next = current_loop::pwm_period(&motor.readings());
            motor.integrate(*stage);
            *stage = next;
        }
        shaft = motor.shaft();
        critical_section::with(|cs| INPUTS.borrow(cs).borrow_mut().encoder = motor.encoder());
    }
    critical_section::with(|cs| INPUTS.borrow(cs).borrow_mut().sensors = step.sensors);

    if let Some(body) = &step.sensors.body {
        chips::measure(body);
    }

    clock::set_now(step.time_us);
    // Bytes that do not fit into the pipe are lost, as on a line without handshake.
    let _ = crate::serial::RECEIVED.try_write(&step.serial);
    for frame in &step.frames {
        RECEIVED.push(*frame);
        clock::run_until_idle(executor);
    }
    clock::fire_timers();
    clock::run_until_idle(executor);

    let mut stepped = Stepped {
        shaft,
        frames: heapless::Vec::new(),
        log: heapless::Vec::new(),
    };
    take_log(&mut stepped.log);
    while !stepped.frames.is_full() {
        let Some(frame) = TRANSMIT.pop() else { break };
        let _ = stepped.frames.push(frame); // cannot fail: see the loop's condition
    }
    stepped
}

fn take_log<const N: usize>(bytes: &mut heapless::Vec<u8, N>) {
    let dropped = critical_section::with(|cs| {
        let mut log = LOG.borrow(cs).borrow_mut();
        log.take(bytes);
        log.take_dropped()
    });
    if dropped > 0 {
        crate::logger::warn!("{} log records were lost", dropped);
    }
}
