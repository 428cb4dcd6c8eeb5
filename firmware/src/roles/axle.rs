//! Role `axle`: the node of one motor that follows the set-points from the bus.

use super::drive::Measurements;
use super::{Refusal, Role, Spawners, dictionary, drive, refuse, start_bus, startable};
use crate::boards::CONTROL_HZ;
use crate::bus::Received;
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;
use tautrack::settings::{Setting, Settings};

dictionary!(od, "axle.rs");
#[cfg(any(test, all(target_os = "none", feature = "cost")))]
pub(crate) use od::DICTIONARY;
drive::drive_objects!(od);

/// The role `axle`.
pub static ROLE: Role = Role {
    name: "axle",
    dictionary: od::DICTIONARY,
    check: |settings| drive::current_loop(settings).map(|_| ()),
    start,
};

fn start(spawners: Spawners, settings: &Settings) -> Result<(), Refusal> {
    drive::install_current_loop(settings)?;
    drive::HEARD.start(settings, 0);
    start_bus(
        spawners.bus,
        settings,
        od::DICTIONARY,
        None,
        received,
        |_| true,
    )?;
    let axle = create(settings)?;
    let measurements = Measurements::create(settings)?;
    let control = control(axle, measurements, settings.id(Setting::NodeId));
    spawners.control.spawn(startable(control)?);
    Ok(())
}

/// Creates the axle in a static variable: so it is neither copied into the task nor through the
/// stack.
fn create(settings: &Settings) -> Result<&'static mut Axle, Refusal> {
    static AXLE: StaticCell<Axle> = StaticCell::new();
    AXLE.try_init_with(|| Axle::new(settings))
        .ok_or_else(|| refuse("axle", "it was started before"))
}

fn received(received: Received) {
    drive::HEARD.note(&received);
}

#[embassy_executor::task]
async fn control(axle: &'static mut Axle, mut measurements: Measurements, node: u8) -> ! {
    publish_start(axle);
    let mut ticker = Ticker::every(Duration::from_hz(u64::from(CONTROL_HZ)));
    loop {
        ticker.next().await;
        let inputs = inputs(axle);
        let outputs = axle.tick(&inputs);
        finish(&mut measurements, axle, &inputs, &outputs, node);
    }
}
