//! An axle: one motor that follows the set-points of the bus.

use super::{Refusal, Role, Settings, dictionary, start_bus};
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::{bus, current_loop};
use current_loop::Demand;
use embassy_executor::Spawner;
use embassy_time::{Duration, Ticker};
use tautrack::motor::current::{CurrentLoop, Winding};

dictionary!(od, "axle.rs");

/// The role of this file.
pub static ROLE: Role = Role {
    name: "axle",
    start,
};

fn start(spawner: Spawner, settings: &Settings) -> Result<(), Refusal> {
    let winding = Winding {
        resistance: 0.3,
        inductance: 2e-4,
        current_limit: 20.0,
    };
    if let Ok(current_loop) = CurrentLoop::new(&winding, 2_000.0, Selected::PWM_HZ as f32) {
        current_loop::install(current_loop);
    }
    start_bus(spawner, settings, od::DICTIONARY, None, |_| {})?;
    if let Ok(token) = control() {
        spawner.spawn(token);
    }
    crate::logger::info!("axle started");
    Ok(())
}

#[embassy_executor::task]
async fn control() -> ! {
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        od::OBJECT6064.set_value(Selected::encoder());
        od::OBJECT6078.set_value((current_loop::measured() * 1_000.0) as i16);
        current_loop::demand(
            if bus::operational() && od::OBJECT6040.get_value() & 0xf == 0xf {
                Demand::Current(f32::from(od::OBJECT6071.get_value()) * 0.02)
            } else {
                Demand::Off
            },
        );
    }
}
