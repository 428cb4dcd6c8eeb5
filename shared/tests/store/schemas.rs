//! Changes of the schema, up and down.

use crate::flash::{Flash, PAGE, Random, TEARS};
use embedded_storage::nor_flash::NorFlash;
use std::collections::BTreeMap;
use tautrack::settings::Bounds;
use tautrack::store::{Move, Report, Schema, State, Store, StoreError};

type Values = BTreeMap<u16, i32>;

/// A setting whose name is a comment for the reader.
const fn row(key: u16, _name: &'static str, maximum: i32, default: i32) -> Bounds {
    Bounds {
        key,
        minimum: 0,
        maximum,
        default,
    }
}

/// The first version: a speed in mm/s, and two settings that never change.
const FIRST: Schema = Schema {
    version: 1,
    row: &|index| {
        let rows = [
            row(1, "id", 127, 0),
            row(2, "limit", 100, 10),
            row(3, "speed_mm_s", 1_000, 50),
        ];
        rows.get(index).copied()
    },
    moves: &[],
};

const TO_MICRO: Move = Move {
    since: 2,
    old: 3,
    new: 13,
    up: |millimetres| millimetres * 1_000,
    down: |micrometres| micrometres / 1_000,
};

/// The second version: the speed is in um/s, `limit` has wider bounds, and there is a new setting.
const SECOND: Schema = Schema {
    version: 2,
    row: &|index| {
        let rows = [
            row(1, "id", 127, 0),
            row(2, "limit", 200, 10),
            row(13, "speed_um_s", 1_000_000, 50_000),
            row(20, "new", 9, 1),
        ];
        rows.get(index).copied()
    },
    moves: &[TO_MICRO],
};

/// The third version: the speed is in nm/s.
const THIRD: Schema = Schema {
    version: 3,
    row: &|index| {
        let rows = [
            row(1, "id", 127, 0),
            row(2, "limit", 200, 10),
            row(23, "speed_nm_s", 1_000_000_000, 50_000_000),
            row(20, "new", 9, 1),
        ];
        rows.get(index).copied()
    },
    moves: &[
        TO_MICRO,
        Move {
            since: 3,
            old: 13,
            new: 23,
            up: |micrometres| micrometres * 1_000,
            down: |nanometres| nanometres / 1_000,
        },
    ],
};

fn load(flash: Flash, schema: &Schema) -> (Flash, Values, Report) {
    let mut store = Store::open(flash.restart()).expect("a store");
    let mut values: Values = schema.rows().map(|row| (row.key, row.default)).collect();
    let report = store
        .load(schema, &mut |key, value| {
            values.insert(key, value);
        })
        .expect("settings");
    (store.into_inner(), values, report)
}

fn try_save(flash: Flash, schema: &Schema, values: &Values) -> (Flash, Result<(), StoreError>) {
    let mut store = Store::open(flash).expect("a store");
    let result = store
        .save(schema, &|key| values[&key], &|_| false)
        .map(|_| ());
    (store.into_inner(), result)
}

fn save(flash: Flash, schema: &Schema, values: &Values) -> Flash {
    let (flash, result) = try_save(flash, schema, values);
    result.expect("saved");
    flash
}

fn first() -> Flash {
    save(
        Flash::new(2),
        &FIRST,
        &Values::from([(1, 5), (2, 77), (3, 120)]),
    )
}

#[test]
fn an_upgrade_converts_what_has_a_new_key_and_keeps_the_rest() {
    let (flash, values, report) = load(first(), &SECOND);
    assert_eq!(report.state(), State::Migrated);
    assert_eq!(report.stored, Some(1));
    let expected = Values::from([(1, 5), (2, 77), (13, 120_000), (20, 1)]);
    assert_eq!(values, expected);
    let (flash, values, report) = load(save(flash, &SECOND, &values), &SECOND);
    assert_eq!(report.state(), State::Loaded);
    assert_eq!(values, expected);
    // Two steps at once, and one after the other.
    for flash in [first(), flash] {
        let (_, values, _) = load(flash, &THIRD);
        assert_eq!(values[&23], 120_000_000);
    }
}

#[test]
fn a_downgrade_and_an_upgrade_keep_every_setting_that_both_know() {
    let new = Values::from([(1, 6), (2, 80), (23, 333_000_000), (20, 4)]);
    let flash = save(first(), &THIRD, &new);
    for earlier in [&FIRST, &SECOND] {
        // An earlier program finds the speed in its own unit.
        let (flash, values, report) = load(flash.clone(), earlier);
        assert_eq!(report.state(), State::Migrated);
        let speed = if earlier.version == 1 {
            (3, 333)
        } else {
            (13, 333_000)
        };
        assert_eq!((values[&1], values[&2]), (6, 80));
        assert_eq!(values[&speed.0], speed.1);
        // If it saves nothing, nothing changes. The unknown setting 20 is kept in any case.
        let (_, back, _) = load(flash.clone(), &THIRD);
        assert_eq!(back, new);
        // If it changes the speed, the later program has the change.
        let mut changed = values.clone();
        changed.insert(speed.0, speed.1 / 3);
        changed.insert(1, 9);
        let flash = save(flash, earlier, &changed);
        let (_, back, report) = load(flash, &THIRD);
        assert_eq!(report.stored, Some(earlier.version));
        assert_eq!(
            back,
            Values::from([(1, 9), (2, 80), (23, 111_000_000), (20, 4)])
        );
    }
}

#[test]
fn a_value_out_of_bounds_is_refused_alone_and_stays_in_flash() {
    let flash = save(
        first(),
        &SECOND,
        &Values::from([(1, 6), (2, 150), (13, 1_000), (20, 4)]),
    );
    let (flash, values, report) = load(flash, &FIRST);
    assert_eq!(report.state(), State::PartlyRefused);
    assert_eq!(report.refusals, 1);
    let refused = report.refused[0];
    assert_eq!((refused.key, refused.got), (2, 150));
    assert_eq!((refused.minimum, refused.maximum), (0, 100));
    assert_eq!(values, Values::from([(1, 6), (2, 10), (3, 1)]));
    assert_eq!(
        report.to_string(),
        "schema 2, converted, 0x0002 = 150 refused, allowed 0 to 100"
    );
    // A save of the earlier program does not overwrite it, unless the setting is set.
    let flash = save(flash, &FIRST, &values);
    assert_eq!(load(flash.clone(), &SECOND).1[&2], 150);
    let mut set = values;
    set.insert(2, 60);
    assert_eq!(load(save(flash, &FIRST, &set), &SECOND).1[&2], 60);
}

#[test]
fn a_migration_survives_a_cut_at_every_operation() {
    let (older, values, _) = load(first(), &FIRST);
    // Both halves of the flash are in use.
    let mut newer = values;
    newer.insert(1, 6);
    let second = save(
        save(older, &FIRST, &newer),
        &FIRST,
        &Values::from([(1, 5), (2, 77), (3, 120)]),
    );
    for flash in [first(), second] {
        let (flash, values, _) = load(flash, &SECOND);
        let operations = save(flash.clone(), &SECOND, &values).operations - flash.operations;
        for at in 0..operations {
            for tear in TEARS {
                let mut cut = flash.clone();
                cut.cut = Some((at, tear));
                let (cut, result) = try_save(cut, &SECOND, &values);
                assert!(result.is_err());
                // Both programs read their values, in the middle of the migration.
                let (cut, found, _) = load(cut, &SECOND);
                assert_eq!(found, values, "cut at {at}, {tear:?}");
                let (cut, found, _) = load(cut, &FIRST);
                assert_eq!((found[&2], found[&3]), (77, 120), "cut at {at}, {tear:?}");
                let (_, found, report) = load(save(cut, &SECOND, &values), &SECOND);
                assert_eq!((found, report.state()), (values.clone(), State::Loaded));
            }
        }
    }
}

/// Flash of a later program, in which `limit` is 150: out of the bounds of [`FIRST`].
fn refused() -> Flash {
    let later = Values::from([(1, 6), (2, 150), (13, 1_000), (20, 4)]);
    let flash = save(first(), &SECOND, &later);
    let (flash, _, report) = load(flash, &FIRST);
    assert_eq!(report.state(), State::PartlyRefused);
    flash
}

#[test]
fn a_refused_value_whose_setting_is_set_to_its_default_is_replaced() {
    let (flash, values, _) = load(refused(), &FIRST);
    let mut store = Store::open(flash).expect("a store");
    store
        .save(&FIRST, &|key| values[&key], &|key| key == 2)
        .expect("saved");
    let (_, again, report) = load(store.into_inner(), &FIRST);
    assert_eq!((again, report.state()), (values, State::Loaded));
}

#[test]
fn a_refused_value_does_not_outlive_a_restore() {
    let mut store = Store::open(refused()).expect("a store");
    store.clear().expect("cleared");
    let new = Values::from([(1, 9), (2, 10), (3, 50)]);
    let (_, found, report) = load(save(store.into_inner(), &FIRST, &new), &FIRST);
    assert_eq!((found, report.state()), (new, State::Loaded));
}

/// Clears a store and expects that it can be used again.
fn recover(flash: Flash) {
    let mut store = Store::open(flash).expect("a store");
    store.clear().expect("cleared");
    let (flash, _, report) = load(store.into_inner(), &FIRST);
    assert_eq!(report.state(), State::Blank);
    let new = Values::from([(1, 9), (2, 20), (3, 40)]);
    let (_, found, report) = load(save(flash, &FIRST, &new), &FIRST);
    assert_eq!((found, report.state()), (new, State::Loaded));
}

#[test]
fn a_store_that_cannot_be_read_or_is_full_works_again_once_it_is_cleared() {
    // Any bytes.
    let mut damaged = 0;
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let mut flash = Flash::new(4);
        for word in 0..flash.erases.len() * PAGE / 8 {
            let bytes = [0; 8].map(|_: u8| random.below(256) as u8);
            flash.write(word as u32 * 8, &bytes).expect("written");
        }
        let mut store = Store::open(flash).expect("a store");
        damaged += u32::from(store.load(&FIRST, &mut |_, _| {}).is_err());
        recover(store.into_inner());
    }
    assert!(damaged > 20, "{damaged}");
    // More keys than fit in memory, and more than fit in flash.
    for (pages, error) in [
        (8, StoreError::TooManyKeys { maximum: 320 }),
        (2, StoreError::Full),
    ] {
        let rows: Vec<_> = (1..=400).map(|key| row(key, "row", 9, 0)).collect();
        let mut store = Store::open(Flash::new(pages)).expect("a store");
        let results = rows.chunks(80).map(|rows| {
            let row = |index| rows.get(index).copied();
            let schema = Schema { row: &row, ..FIRST };
            store.save(&schema, &|_| 9, &|_| false).map(|_| ())
        });
        assert_eq!(results.collect::<Result<(), _>>(), Err(error));
        recover(store.into_inner());
    }
}
