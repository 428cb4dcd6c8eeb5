//! Bus task of a node whose flash is blank: it sends nothing until a master gives it a node id.

use super::{RECEIVED, TRANSMIT};
use crate::boards::{Board, Selected};
use crate::roles::{Role, Spawners};
use crate::watchdog::{self, Party};
use crate::{refusal, storage};
use embassy_time::{Duration, with_timeout};
use tautrack::bus::lss::{self, Action, Slave};
use tautrack::roles::settings::Found;

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
                let saved =
                    storage::create(&mut Selected::storage(), &storage::with_id(id)).is_ok();
                if let Some(answer) = lss::stored(saved) {
                    TRANSMIT.push(answer);
                }
            }
            Some(Action::Start(id)) => {
                let settings = storage::with_id(id);
                if let Err(refusal) = (role.start)(spawners, &settings, found) {
                    crate::logger::error!("the node cannot start: {}", refusal::text(&refusal));
                }
                return;
            }
        }
    }
}
