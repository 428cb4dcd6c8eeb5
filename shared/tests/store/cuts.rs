//! A power cut at every single write and erase.

use crate::flash::{Flash, PAGE, TEARS, Tear};
use crate::parallel;
use crate::{restart, save, saved, set, values};
use tautrack::settings::{Setting, Settings, TABLE};
use tautrack::store::{State, Store, StoreError};

/// A node of a robot: some forty settings that differ from their defaults.
fn node(shift: i32) -> Settings {
    let mut settings = Settings::default();
    for row in TABLE.iter().step_by(3) {
        let value = if row.default < row.maximum - shift {
            row.default + shift
        } else {
            row.minimum
        };
        settings.set(row.key, value).expect("within bounds");
    }
    settings
}

/// Cuts the power at every operation of saving `new` over `old` in `flash`, with every tear.
/// Afterwards all settings are old or all are new. Then saves again and expects `new`. Returns how
/// many operations a save has.
fn cut_everywhere(flash: &Flash, old: &Settings, new: &Settings) -> usize {
    let either = [values(old), values(new)];
    let operations = saved(flash.clone(), new).operations - flash.operations;
    assert!(operations > 0);
    for at in 0..operations {
        for tear in TEARS {
            let mut cut = flash.clone();
            cut.cut = Some((at, tear));
            let mut store = Store::open(cut).expect("a store");
            let result = save(&mut store, new);
            assert!(result.is_err(), "the power fails in operation {at}");
            let (flash, found, _) = restart(store.into_inner());
            let what = format!("cut at {at} of {operations}, {tear:?}");
            assert!(either.contains(&values(&found)), "{what}: {found:?}");
            let (_, again, report) = restart(saved(flash, new));
            assert_eq!(values(&again), either[1], "{what}: not repaired");
            assert_eq!(report.state(), State::Loaded, "{what}");
        }
    }
    operations
}

#[test]
fn every_save_survives_a_cut_at_every_operation() {
    for pages in 2..=5 {
        let mut flash = Flash::new(pages);
        let mut old = Settings::default();
        for number in 1..=4 {
            let new = node(number);
            cut_everywhere(&flash, &old, &new);
            flash = saved(flash, &new);
            old = new;
        }
    }
}

#[test]
fn a_cut_in_the_save_after_a_cut_leaves_old_or_new_settings() {
    let [old, new] = [node(5), node(6)];
    let flash = saved(saved(Flash::new(2), &node(4)), &old);
    let operations = saved(flash.clone(), &new).operations - flash.operations;
    let places: Vec<_> = (0..operations).collect();
    parallel::map(&places, |&at| {
        for tear in TEARS {
            let mut cut = flash.clone();
            cut.cut = Some((at, tear));
            let mut store = Store::open(cut).expect("a store");
            assert!(save(&mut store, &new).is_err());
            let half = store.into_inner().restart();
            for second in 0.. {
                let mut again = half.clone();
                again.cut = Some((second, TEARS[second % TEARS.len()]));
                let mut store = Store::open(again).expect("a store");
                let saved = save(&mut store, &new).is_ok();
                let (_, found, _) = restart(store.into_inner());
                let either = [&old, &new].map(values);
                assert!(either.contains(&values(&found)), "{at}, {tear:?}, {second}");
                if saved {
                    break; // there are no more operations to cut
                }
            }
        }
    });
}

#[test]
fn a_save_of_nothing_new_writes_nothing() {
    let flash = saved(Flash::new(2), &node(1));
    let again = saved(flash.clone(), &node(1));
    assert_eq!(again.operations, flash.operations);
    let mut one = node(1);
    set(&mut one, Setting::CurrentLimit, 1_234);
    let mut store = Store::open(again).expect("a store");
    assert_eq!(save(&mut store, &one).expect("saved").changed, 1);
}

/// After a cut in the first save there are no settings at all. After one in a later save, the
/// earlier settings are whole, but the person who saved must know.
#[test]
fn a_blank_flash_and_an_interrupted_save_are_reported() {
    let (_, settings, report) = restart(Flash::new(2));
    assert_eq!(report.state(), State::Blank);
    assert_eq!(values(&settings), values(&Settings::default()));
    let interrupted = |mut flash: Flash| {
        flash.cut = Some((8, Tear::Nothing));
        let mut store = Store::open(flash).expect("a store");
        assert!(save(&mut store, &node(2)).is_err());
        store.into_inner()
    };
    let mut first = Store::open(interrupted(Flash::new(2)).restart()).expect("a store");
    assert_eq!(crate::load(&mut first).err(), Some(StoreError::Damaged));
    let (_, settings, report) = restart(interrupted(saved(Flash::new(2), &node(1))));
    assert_eq!(report.state(), State::Repaired);
    assert_eq!(values(&settings), values(&node(1)));
}

/// Any single bit of any byte may be wrong: the settings are those of the last save or, with a
/// report, those of the save before it.
#[test]
fn a_damaged_copy_is_never_loaded() {
    let [before, last] = [node(1), node(2)];
    let flash = saved(saved(Flash::new(2), &before), &last);
    let mut older = 0;
    for place in 0..2 * PAGE {
        let mut damaged = flash.clone();
        damaged.flip(place, 1 << (place % 8));
        let (_, found, report) = restart(damaged);
        match report.state() {
            State::Loaded => assert_eq!(values(&found), values(&last)),
            State::Repaired => {
                let whole = [&before, &last].map(values);
                assert!(whole.contains(&values(&found)));
                older += usize::from(values(&found) == whole[0]);
            }
            state => panic!("{state:?}"),
        }
    }
    assert!(older > 400, "{older} bytes of the last save");
}

#[test]
fn a_cleared_store_is_blank_and_old_values_do_not_come_back() {
    for saves in 1..=3 {
        let mut flash = Flash::new(2);
        for number in 1..=saves {
            flash = saved(flash, &node(number));
        }
        let operations = {
            let mut store = Store::open(flash.clone()).expect("a store");
            store.clear().expect("cleared");
            store.into_inner().operations - flash.operations
        };
        for at in 0..=operations {
            for tear in TEARS {
                let mut flash = flash.clone();
                flash.cut = Some((at, tear));
                let mut store = Store::open(flash).expect("a store");
                let cleared = store.clear().is_ok();
                let (flash, settings, report) = restart(store.into_inner());
                let blank = report.state() == State::Blank;
                assert!(blank || !cleared);
                let expected = if blank {
                    Settings::default()
                } else {
                    node(saves)
                };
                assert_eq!(values(&settings), values(&expected));
                let mut one = Settings::default();
                set(&mut one, Setting::NodeId, 9);
                let (_, settings, report) = restart(saved(flash, &one));
                assert_eq!(values(&settings), values(&one));
                assert_eq!(report.state(), State::Loaded);
            }
        }
    }
}

#[test]
fn two_saves_erase_each_page_once() {
    for pages in [2, 4] {
        let mut flash = Flash::new(pages);
        for number in 1..=20 {
            flash = saved(flash, &node(number));
        }
        // The first save erases both halves.
        let (first, second) = flash.erases.split_at(pages / 2);
        assert!(first.iter().all(|erases| *erases == 10), "{first:?}");
        assert!(second.iter().all(|erases| *erases == 11), "{second:?}");
    }
}
