//! Bus task of a node whose flash is blank: it sends nothing until a master gives it a node id.

use super::{RECEIVED, TRANSMIT};
use crate::boards::{Board, Selected};
use crate::roles::{Role, Spawners};
use crate::storage;
use crate::watchdog::{self, Party};
use embassy_time::{Duration, with_timeout};
use tautrack::bus::lss::{self, Action, Slave};
use tautrack::roles::settings::Found;
use tautrack::settings::{Setting, Settings, UNKNOWN_MOTOR};

/// Maximum time between two feeds of the watchdog.
const IDLE: Duration = Duration::from_millis(5);

/// Answers the layer setting services. Once the node has an id, starts `role` with it and with the
/// defaults of all other settings. `found` is what was found in flash.
#[embassy_executor::task]
pub async fn wait_for_id(spawners: Spawners, role: &'static Role, found: Found) {
    let [vendor, product, revision] = tautrack::roles::identity(role.table);
    let mut slave = Slave::new([vendor, product, revision, Selected::serial_number()]);
    loop {
        let frame = with_timeout(IDLE, RECEIVED.next()).await;
        watchdog::ran(Party::Thread);
        let Ok(frame) = frame else { continue };
        match slave.receive(&frame) {
            None => {}
            Some(Action::Answer(answer)) => TRANSMIT.push(answer),
            Some(Action::Store(id)) => {
                let saved = storage::create(&with_id(id)).is_ok();
                if let Some(answer) = lss::stored(saved) {
                    TRANSMIT.push(answer);
                }
            }
            Some(Action::Start(id)) => {
                let settings = with_id(id);
                storage::publish(&settings, found, role.check);
                if let Err(refusal) = (role.start)(spawners, &settings) {
                    crate::logger::error!(
                        "the node cannot start: {}",
                        crate::roles::text(&refusal)
                    );
                }
                return;
            }
        }
    }
}

/// The defaults with this node id, and with limits that suit an unknown motor.
fn with_id(id: u8) -> Settings {
    let mut settings = Settings::default();
    let mut set = |setting: Setting, value: i32| {
        // Cannot fail: the master's request was checked, and the limits are within their bounds.
        let _ = settings.set(setting.bounds().key, value);
    };
    set(Setting::NodeId, id.into());
    for (setting, value) in UNKNOWN_MOTOR {
        set(*setting, *value);
    }
    settings
}
