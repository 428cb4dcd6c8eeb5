//! A power cut at every single write and erase.

use crate::flash::{Flash, PAGE, TEARS, Tear};
use crate::parallel;
use crate::sweep::stamp_of_executable;
use crate::{restart, save, saved, set, values};
use tautrack::settings::{Setting, Settings, TABLE};
use tautrack::store::{RECORDS, State, Store};

/// Saves of one setting after which a page is erased, with four pages.
const SAVES_PER_ERASE: usize = 454;

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
/// Afterwards every setting is old or new, and so is each record as a whole. Then saves again and
/// expects `new`. Returns how many operations a save has.
fn cut_everywhere(flash: &Flash, old: &Settings, new: &Settings) -> usize {
    let (old_values, new_values) = (values(old), values(new));
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
            for ((row, found), (old, new)) in TABLE
                .iter()
                .zip(values(&found))
                .zip(old_values.iter().zip(&new_values))
            {
                assert!(
                    found == *old || found == *new,
                    "{what}: {} = {found}, neither {old} nor {new}",
                    row.name
                );
            }
            for record in RECORDS {
                let all = |other: &Settings| {
                    let mut settings = record.settings.iter();
                    settings.all(|setting| found.get(*setting) == other.get(*setting))
                };
                assert!(all(old) || all(new), "{what}: record {:#x}", record.key);
            }
            let (_, again, report) = restart(saved(flash, new));
            assert_eq!(values(&again), new_values, "{what}: not repaired");
            assert_eq!(report.state(), State::Loaded, "{what}");
        }
    }
    operations
}

#[test]
fn the_first_save_survives_a_cut_at_every_operation() {
    for pages in 2..=4 {
        cut_everywhere(&Flash::new(pages), &Settings::default(), &node(1));
    }
}

#[test]
fn a_save_that_turns_the_page_survives_a_cut_at_every_operation() {
    let Some(_stamp) =
        stamp_of_executable("a_save_that_turns_the_page_survives_a_cut_at_every_operation")
    else {
        return;
    };
    for pages in 2..=4 {
        // Fills pages until the next save has to erase one, in the first round and in a later one.
        let mut flash = saved(Flash::new(pages), &node(1));
        let mut turned = 0;
        for number in 2.. {
            let (old, new) = (node(number - 1), node(number));
            let next = saved(flash.clone(), &new);
            if next.erases != flash.erases {
                cut_everywhere(&flash, &old, &new);
                turned += 1;
                if turned == 3 {
                    break;
                }
            }
            flash = next;
        }
    }
}

#[test]
fn a_calibration_record_is_old_or_new_as_a_whole() {
    let mut old = node(1);
    for record in RECORDS {
        for setting in record.settings {
            let row = setting.description();
            set(&mut old, *setting, row.minimum);
        }
        let mut new = old.clone();
        for setting in record.settings {
            set(&mut new, *setting, setting.description().maximum);
        }
        let mut flash = saved(Flash::new(2), &old);
        cut_everywhere(&flash, &old, &new);
        // The same while the page turns.
        while saved(flash.clone(), &new).erases == flash.erases {
            flash = saved(saved(flash, &new), &old);
        }
        cut_everywhere(&flash, &old, &new);
    }
}

#[test]
fn a_cut_in_the_repair_of_a_cut_is_repaired_too() {
    let Some(_stamp) = stamp_of_executable("a_cut_in_the_repair_of_a_cut_is_repaired_too") else {
        return;
    };
    let (old, new) = (node(5), node(6));
    let mut flash = saved(Flash::new(2), &old);
    while saved(flash.clone(), &new).erases == flash.erases {
        flash = saved(saved(flash, &new), &old);
    }
    let operations = saved(flash.clone(), &new).operations - flash.operations;
    let places: Vec<_> = (0..operations).collect();
    parallel::map(&places, |&at| {
        let mut cut = flash.clone();
        cut.cut = Some((at, Tear::Random(at as u64)));
        let mut store = Store::open(cut).expect("a store");
        assert!(save(&mut store, &new).is_err());
        let half = store.into_inner().restart();
        for second in 0.. {
            let mut again = half.clone();
            again.cut = Some((second, TEARS[second % TEARS.len()]));
            let outcome = Store::open(again.clone()).and_then(|mut store| {
                let result = save(&mut store, &new);
                again = store.into_inner();
                result
            });
            if outcome.is_ok() {
                break; // there are no more operations to cut
            }
            let (_, found, _) = restart(again);
            for (setting, found) in TABLE.iter().zip(values(&found)) {
                let either = [&old, &new].map(|settings| settings.of_key(setting.key));
                assert!(either.contains(&Some(found)), "{}", setting.name);
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
    let flash = store.into_inner();
    // Header and data of one item.
    assert_eq!(flash.written, 16 + saved(Flash::new(2), &node(1)).written);
}

#[test]
fn a_blank_flash_and_an_interrupted_save_are_reported() {
    let (_, settings, report) = restart(Flash::new(2));
    assert_eq!(report.state(), State::Blank);
    assert_eq!(values(&settings), values(&Settings::default()));
    // A first save that is interrupted leaves the node blank, a later one leaves a mixture.
    for (flash, state) in [
        (Flash::new(2), State::Blank),
        (saved(Flash::new(2), &node(1)), State::Repaired),
    ] {
        let mut flash = flash;
        flash.cut = Some((20, Tear::Nothing));
        let mut store = Store::open(flash).expect("a store");
        assert!(save(&mut store, &node(2)).is_err());
        let (_, _, report) = restart(store.into_inner());
        assert_eq!(report.state(), state);
    }
}

#[test]
fn a_cleared_store_is_blank_and_old_values_do_not_come_back() {
    let flash = saved(Flash::new(2), &node(1));
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
            let expected = if blank { Settings::default() } else { node(1) };
            assert_eq!(values(&settings), values(&expected));
            let mut one = Settings::default();
            set(&mut one, Setting::NodeId, 9);
            let (_, settings, report) = restart(saved(flash, &one));
            assert_eq!(values(&settings), values(&one));
            assert_eq!(report.state(), State::Loaded);
        }
    }
}

#[test]
fn a_page_is_erased_once_in_so_many_saves() {
    // Four pages, all settings of a drive, and one that is saved again and again. docs/settings.md
    // has this number.
    let mut settings = Settings::default();
    for row in TABLE.iter().filter(|row| (0x01..=0x37).contains(&row.key)) {
        settings.set(row.key, row.minimum).expect("within bounds");
    }
    let mut flash = saved(Flash::new(4), &settings);
    let saves = 10_000;
    for number in 0..saves {
        set(&mut settings, Setting::VelocityGain, 1_000 + number % 2);
        flash = saved(flash, &settings);
    }
    let most = *flash.erases.iter().max().expect("pages");
    assert_eq!(saves as usize / most, SAVES_PER_ERASE);
}

#[test]
fn a_flash_that_is_too_full_says_so_and_keeps_the_old_values() {
    // Two pages hold one page of items.
    let mut all = Settings::default();
    let mut flash = saved(Flash::new(2), &node(1));
    for row in TABLE {
        let value = if row.default == row.maximum {
            row.minimum
        } else {
            row.maximum
        };
        all.set(row.key, value).expect("within bounds");
    }
    let items = TABLE.len() * 16;
    let result = {
        let mut store = Store::open(flash).expect("a store");
        let result = save(&mut store, &all);
        flash = store.into_inner();
        result
    };
    assert_eq!(result.is_ok(), items < PAGE - 100, "{items} bytes");
    let (_, found, _) = restart(flash);
    for (row, found) in TABLE.iter().zip(values(&found)) {
        let either = [&node(1), &all].map(|settings| settings.of_key(row.key));
        assert!(either.contains(&Some(found)), "{}", row.name);
    }
}
