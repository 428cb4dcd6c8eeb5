//! Role `axle`: the node of one motor that follows the set-points from the bus.

use super::{Refusal, Role, dictionary, drive, start_bus};
use crate::boards::CONTROL_HZ;
use crate::bus::Received;
use core::sync::atomic::{AtomicU8, Ordering};
use embassy_executor::Spawner;
use embassy_time::{Duration, Ticker};
use tautrack::node::axle::Axle;
use tautrack::settings::{Setting, Settings};

dictionary!(od, "axle.rs");
#[cfg(any(test, all(target_os = "none", feature = "cost")))]
pub(crate) use od::DICTIONARY;
drive::drive_objects!(od);

/// The role `axle`.
pub static ROLE: Role = Role {
    name: "axle",
    start,
};

static GUARD: AtomicU8 = AtomicU8::new(0);

fn start(spawner: Spawner, settings: &Settings) -> Result<(), Refusal> {
    drive::install_current_loop(settings)?;
    GUARD.store(settings.id(Setting::GuardId), Ordering::Relaxed);
    start_bus(spawner, settings, od::DICTIONARY, None, received)?;
    super::spawn(
        spawner,
        control(Axle::new(settings), settings.id(Setting::NodeId)),
    )
}

fn received(received: Received) {
    drive::HEARD.note(&received, GUARD.load(Ordering::Relaxed), None);
}

#[embassy_executor::task]
async fn control(mut axle: Axle, node: u8) -> ! {
    od::OBJECT2010.set_value(axle.scale().code());
    od::publish_parameters(&axle.parameters());
    publish_ratings();
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        let bench_mode = bench_mode();
        if let Some(parameters) = new_parameters() {
            axle.configure(&parameters);
        }
        let outputs = axle.tick(&drive::inputs(set_point, torque_offset, bench_mode));
        drive::act(&outputs, node);
        publish(&outputs, bench_mode);
        serve_capture();
    }
}
