//! Tests of the settings' store, with a flash in memory that loses its power.

mod cuts;
mod flash;
mod histories;
#[path = "../support/parallel.rs"]
mod parallel;
mod schemas;
#[path = "../support/sweep.rs"]
mod sweep;

use flash::Flash;
use tautrack::settings::{Setting, Settings};
use tautrack::store::{Report, SCHEMA, Saved, Store, StoreError};

/// Restores the power; returns the flash, the settings in it and the report. Flash without any
/// settings, because their first save was interrupted, is like blank flash.
fn restart(flash: Flash) -> (Flash, Settings, Report) {
    let mut store = Store::open(flash.restart()).expect("a store");
    let (settings, report) = match load(&mut store) {
        Err(StoreError::Damaged) => (Settings::default(), Report::default()),
        loaded => loaded.expect("settings"),
    };
    (store.into_inner(), settings, report)
}

fn load(store: &mut Store<Flash>) -> Result<(Settings, Report), StoreError> {
    let mut settings = Settings::default();
    let report = store.load(&SCHEMA, &mut |key, value| {
        settings.set(key, value).expect("a valid setting");
    })?;
    Ok((settings, report))
}

fn save(store: &mut Store<Flash>, settings: &Settings) -> Result<Saved, StoreError> {
    let value = |key| settings.of_key(key).expect("a setting");
    store.save(&SCHEMA, &value, &|_| false)
}

fn set(settings: &mut Settings, setting: Setting, value: i32) {
    settings
        .set(setting.description().key, value)
        .unwrap_or_else(|error| panic!("{error}"));
}

fn values(settings: &Settings) -> Vec<i32> {
    tautrack::settings::TABLE
        .iter()
        .map(|row| settings.of_key(row.key).expect("a setting"))
        .collect()
}

/// Saves `settings` into `flash`, which keeps its power.
fn saved(flash: Flash, settings: &Settings) -> Flash {
    let mut store = Store::open(flash).expect("a store");
    save(&mut store, settings).expect("saved");
    store.into_inner()
}
