//! Tests the plan of a set-up: what a computer lacks is installed if that is allowed, else one line
//! names it.

use Part::{Browser, PageTarget, ProbeRs, Qemu, Sources, Target};
use proptest::prelude::*;
use tautrack_setup::plan::{RUSTUP, after, plan};
use tautrack_setup::{Facts, Missing, Part, Rights, Step};

const READY: Facts = Facts {
    target_library: true,
    page_library: true,
    library_sources: true,
    rustup: true,
    qemu: true,
    browser: true,
    probe_rs: true,
    apt: true,
    rights: Some(Rights::Root),
    setup_allowed: true,
};

/// What emulated nodes need.
const EMULATED: [Part; 2] = [Target, Qemu];
/// What a flash image of a motor board needs.
const IMAGE: [Part; 2] = [Target, Sources];
/// Everything that a command can need.
const ALL: [Part; 6] = [Target, PageTarget, Sources, Qemu, Browser, ProbeRs];

fn facts() -> impl Strategy<Value = Facts> {
    let rights = prop_oneof![
        Just(None),
        Just(Some(Rights::Root)),
        Just(Some(Rights::Sudo))
    ];
    (any::<[bool; 9]>(), rights).prop_map(|(bits, rights)| Facts {
        target_library: bits[0],
        rustup: bits[1],
        qemu: bits[2],
        apt: bits[6],
        rights,
        setup_allowed: bits[3],
        library_sources: bits[4],
        probe_rs: bits[5],
        page_library: bits[7],
        browser: bits[8],
    })
}

fn needs() -> impl Strategy<Value = Vec<Part>> {
    proptest::sample::subsequence(ALL.to_vec(), 0..=ALL.len())
}

#[test]
fn nothing_is_installed_on_a_machine_that_has_all() {
    assert_eq!(plan(&ALL, &READY), Ok(vec![]));
}

#[test]
fn rustup_adds_what_is_missing_and_if_it_fails_the_user_is_told() {
    let bare = Facts {
        target_library: false,
        library_sources: false,
        ..READY
    };
    for part in [Target, Sources] {
        let add = Step::Rustup(part);
        assert_eq!(plan(&[part], &bare), Ok(vec![add]));
        let failed = after(add, false, &bare, &bare);
        assert_eq!(plan(&[part], &failed), Err(Missing(part)));
    }
    let steps = vec![Step::Rustup(Target), Step::Rustup(Sources)];
    assert_eq!(plan(&IMAGE, &bare), Ok(steps));
}

#[test]
fn without_rustup_no_package_replaces_it() {
    let bare = Facts {
        target_library: false,
        rustup: false,
        ..READY
    };
    assert_eq!(plan(&EMULATED, &bare), Err(Missing(Target)));
    let complete = Facts {
        target_library: true,
        ..bare
    };
    assert_eq!(plan(&EMULATED, &complete), Ok(vec![]));
}

#[test]
fn a_missing_part_that_is_not_needed_is_neither_installed_nor_demanded() {
    let bare = Facts {
        target_library: false,
        page_library: false,
        library_sources: false,
        qemu: false,
        browser: false,
        probe_rs: false,
        setup_allowed: false,
        ..READY
    };
    assert_eq!(plan(&[], &bare), Ok(vec![]));
    for part in ALL {
        assert_eq!(plan(&[part], &bare), Err(Missing(part)));
    }
}

#[test]
fn commands_use_the_rights_there_are() {
    let step = Step::Package(Qemu, Rights::Sudo);
    for command in step.commands() {
        assert_eq!(command[..3], ["sudo", "-n", "apt-get"]);
    }
    let step = Step::Package(Qemu, Rights::Root);
    assert_eq!(
        step.to_string(),
        "installing the emulator: apt-get update && apt-get -o DPkg::Lock::Timeout=300 install -y \
         --no-install-recommends qemu-system-arm"
    );
    let step = Step::Rustup(Sources);
    assert_eq!(
        step.commands(),
        [["rustup", "component", "add", "rust-src"]]
    );
}

#[test]
fn what_is_missing_is_one_line_that_says_what_to_type() {
    for part in ALL {
        let text = Missing(part).to_string();
        assert!(text.contains("; type: ") && !text.contains('\n'), "{text}");
    }
    for (part, command) in [
        (Target, "rustup target add thumbv7em-none-eabihf"),
        (Sources, "rustup component add rust-src"),
    ] {
        let text = Missing(part).to_string();
        assert!(text.contains(&format!("type: {command} ")), "{text}");
        assert!(text.contains(RUSTUP), "{text}");
    }
    let qemu = Missing(Qemu).to_string();
    assert!(
        qemu.contains("apt-get install qemu-system-arm")
            && qemu.contains("dnf install qemu-system-arm")
            && qemu.contains("brew install qemu"),
        "{qemu}"
    );
    let probe = Missing(ProbeRs).to_string();
    assert!(probe.ends_with("type: cargo install probe-rs-tools --locked"));
}

proptest! {
    #[test]
    fn nothing_is_ever_installed_when_that_is_forbidden(facts in facts(), needs in needs()) {
        let facts = Facts { setup_allowed: false, ..facts };
        if let Ok(steps) = plan(&needs, &facts) {
            prop_assert_eq!(steps, vec![]);
        }
    }

    #[test]
    fn setting_up_ends_even_when_every_step_fails(facts in facts(), needs in needs()) {
        let mut now = facts;
        for _ in 0..ALL.len() {
            match plan(&needs, &now) {
                Ok(steps) if !steps.is_empty() => now = after(steps[0], false, &now, &facts),
                _ => return Ok(()),
            }
        }
        prop_assert!(false, "still trying: {now:?}");
    }
}
