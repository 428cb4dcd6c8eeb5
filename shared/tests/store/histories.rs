//! Random histories of saves, power cuts and restarts.

use crate::flash::{Flash, Random, Tear};
use crate::sweep::stamp_of_executable;
use crate::{load, restart, save, values};
use tautrack::settings::{Settings, TABLE};
use tautrack::store::Store;

/// Histories in all; each continues the flash of an earlier one.
const HISTORIES: u64 = 10_000;

/// Changes a few settings.
fn change(settings: &mut Settings, random: &mut Random) {
    for _ in 0..=random.below(6) {
        let row = &TABLE[random.below(TABLE.len() as u64) as usize];
        let span = (i64::from(row.maximum) - i64::from(row.minimum)).min(1_000) as u64;
        let value = row.minimum + random.below(span + 1) as i32;
        settings.set(row.key, value).expect("within bounds");
    }
}

#[test]
fn random_histories_keep_all_old_or_all_new_values() {
    let Some(_stamp) = stamp_of_executable("random_histories_keep_all_old_or_all_new_values")
    else {
        return;
    };
    let mut random = Random::new(1);
    let mut turned = 0;
    let mut cuts = 0;
    for pages in 3..=4 {
        let mut flash = Flash::new(pages);
        let mut old = Settings::default();
        for history in 0..HISTORIES / 2 {
            for _ in 0..=random.below(3) {
                let mut new = old.clone();
                change(&mut new, &mut random);
                let tear = match random.below(6) {
                    0 => Tear::Nothing,
                    1 => Tear::All,
                    2 => Tear::Ends,
                    3 => Tear::Middle,
                    _ => Tear::Random(random.below(1 << 40)),
                };
                // Most cuts fall into the save; some saves are whole.
                let until = if random.below(8) == 0 { 400 } else { 60 };
                flash.cut = Some((random.below(until) as usize, tear));
                let erases: usize = flash.erases.iter().sum();
                // The cut may also hit the repair at start.
                let whole = match Store::open(flash.clone()) {
                    Ok(mut store) => {
                        let loaded = load(&mut store).is_ok();
                        let whole = loaded && save(&mut store, &new).is_ok();
                        flash = store.into_inner();
                        whole
                    }
                    Err(_) => false,
                };
                cuts += u32::from(!whole);
                let (restarted, found, _) = restart(flash);
                flash = restarted;
                turned += flash.erases.iter().sum::<usize>() - erases;
                let what = format!("history {history}, {pages} pages, {tear:?}");
                let [found_values, old_values, new_values] = [&found, &old, &new].map(values);
                let kept = found_values == old_values && !whole;
                assert!(found_values == new_values || kept, "{what}");
                old = found;
            }
        }
    }
    assert!(turned > 1_000, "{turned} pages erased");
    assert!(cuts > 5_000, "{cuts} cuts");
}
