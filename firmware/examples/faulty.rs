//! Node that fails in its first milliseconds, for the tests of how a run reports it. With node id 1
//! it panics, else it never answers again.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_main)]

use embassy_time::Timer;
use tautrack::settings::{Setting, Settings};
use tautrack_firmware::roles::{Refusal, Role, Spawners, axle};

static FAULTY: Role = Role {
    name: "faulty",
    table: axle::ROLE.table,
    check: |_| Ok(()),
    start,
};

#[expect(clippy::unnecessary_wraps, reason = "the type of a role's start")]
fn start(spawners: Spawners, settings: &Settings) -> Result<(), Refusal> {
    if let Ok(task) = fail(settings.id(Setting::NodeId) == 1) {
        spawners.bus.spawn(task);
    }
    Ok(())
}

#[embassy_executor::task]
async fn fail(panics: bool) {
    Timer::after_millis(2).await;
    assert!(!panics, "this node always panics");
    loop {
        core::hint::spin_loop();
    }
}

tautrack_firmware::program!(FAULTY);
