//! Tests how a program finds the checkout that it works on.

use std::fs;
use std::path::{Path, PathBuf};
use tautrack_setup::checkout::find;

/// Makes a folder that looks like a checkout.
fn checkout_in(parent: &Path, name: &str) -> PathBuf {
    let root = parent.join(name);
    fs::create_dir_all(root.join("shared/dictionary")).unwrap();
    fs::create_dir_all(root.join("host-tests/scenarios")).unwrap();
    fs::write(root.join("Cargo.toml"), "").unwrap();
    root.canonicalize().unwrap()
}

#[test]
fn the_checkout_is_the_first_at_or_above_the_places() {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR")).join("checkouts");
    let [first, second] = ["first", "second"].map(|name| checkout_in(&parent, name));
    let deep = second.join("host-tests/scenarios");
    let none = PathBuf::from("/nowhere/at/all");
    for (places, expected) in [
        (vec![first.clone(), second.clone()], &first),
        (vec![second.clone(), first.clone()], &second),
        (vec![none.clone(), deep.clone(), first.clone()], &second),
        (vec![deep.join("no/such/folder")], &second),
    ] {
        assert_eq!(find(places.clone()).as_ref(), Ok(expected), "{places:?}");
    }
    let error = find([none]).unwrap_err();
    assert!(error.to_string().contains("/nowhere/at/all"), "{error}");
}
