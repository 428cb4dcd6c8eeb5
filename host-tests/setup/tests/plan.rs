//! Tests the plan of a set-up: what a computer lacks is installed if that is allowed, else one line
//! names it.

use Part::{DistributionRust, ProbeRs, Qemu, Sources, Target, Wasm};
use proptest::prelude::*;
use tautrack_setup::plan::{Packages, after, plan};
use tautrack_setup::{Facts, Missing, Part, QEMU, Rights, Step, Toolchain};

const READY: Facts = Facts {
    target_library: true,
    wasm_library: true,
    library_sources: true,
    rustup: true,
    distribution_rust: false,
    distribution_wanted: false,
    qemu: true,
    probe_rs: true,
    packages: Some(Packages::Apt),
    rights: Some(Rights::Root),
    setup_allowed: true,
};

/// What emulated nodes need.
const EMULATED: [Part; 2] = [Target, Qemu];
/// What a flash image of a motor board needs.
const IMAGE: [Part; 2] = [Target, Sources];
/// Everything that a command can need.
const ALL: [Part; 5] = [Target, Sources, Wasm, Qemu, ProbeRs];

fn facts() -> impl Strategy<Value = Facts> {
    let packages = prop_oneof![
        Just(None),
        Just(Some(Packages::Apt)),
        Just(Some(Packages::Dnf))
    ];
    let rights = prop_oneof![
        Just(None),
        Just(Some(Rights::Root)),
        Just(Some(Rights::Sudo))
    ];
    (any::<[bool; 9]>(), packages, rights).prop_map(|(bits, packages, rights)| Facts {
        target_library: bits[0],
        rustup: bits[1],
        distribution_rust: bits[2],
        distribution_wanted: bits[3],
        qemu: bits[4],
        packages,
        rights,
        setup_allowed: bits[5],
        library_sources: bits[6],
        wasm_library: bits[7],
        probe_rs: bits[8],
    })
}

fn needs() -> impl Strategy<Value = Vec<Part>> {
    proptest::sample::subsequence(ALL.to_vec(), 0..=ALL.len())
}

#[test]
fn nothing_is_installed_on_a_machine_that_has_all() {
    assert_eq!(plan(&ALL, &READY), Ok((Toolchain::Current, vec![])));
}

#[test]
fn rustup_is_asked_first_for_a_missing_target_and_the_distribution_when_that_fails() {
    let bare = Facts {
        target_library: false,
        ..READY
    };
    let add = Step::Rustup(Target);
    assert_eq!(plan(&EMULATED, &bare), Ok((Toolchain::Current, vec![add])));
    let failed = after(add, false, &bare, &bare);
    let install = Step::Packages(DistributionRust, Packages::Apt, Rights::Root);
    let steps = vec![install];
    assert_eq!(
        plan(&EMULATED, &failed),
        Ok((Toolchain::Distribution, steps))
    );
    let hopeless = after(install, false, &failed, &bare);
    assert_eq!(plan(&EMULATED, &hopeless), Err(Missing(Target)));
}

#[test]
fn a_flash_image_gets_the_sources_of_the_library_and_a_simulated_node_does_not_need_them() {
    let bare = Facts {
        library_sources: false,
        ..READY
    };
    let add = Step::Rustup(Sources);
    assert_eq!(plan(&IMAGE, &bare), Ok((Toolchain::Current, vec![add])));
    assert_eq!(plan(&EMULATED, &bare), Ok((Toolchain::Current, vec![])));
    let forbidden = Facts {
        setup_allowed: false,
        ..bare
    };
    assert_eq!(plan(&IMAGE, &forbidden), Err(Missing(Sources)));
    let nothing = Facts {
        target_library: false,
        ..bare
    };
    let steps = vec![Step::Rustup(Target), add];
    assert_eq!(plan(&IMAGE, &nothing), Ok((Toolchain::Current, steps)));
    // Without a network, rustup fails, and the distribution's packages have the sources.
    let failed = after(add, false, &bare, &bare);
    let steps = vec![Step::Packages(
        DistributionRust,
        Packages::Apt,
        Rights::Root,
    )];
    assert_eq!(plan(&IMAGE, &failed), Ok((Toolchain::Distribution, steps)));
}

#[test]
fn a_missing_part_that_is_not_needed_is_neither_installed_nor_demanded() {
    let bare = Facts {
        target_library: false,
        wasm_library: false,
        library_sources: false,
        qemu: false,
        probe_rs: false,
        distribution_wanted: true,
        setup_allowed: false,
        ..READY
    };
    assert_eq!(plan(&[], &bare), Ok((Toolchain::Current, vec![])));
    for part in [Wasm, Qemu, ProbeRs] {
        assert_eq!(plan(&[part], &bare), Err(Missing(part)));
    }
}

#[test]
fn only_rustup_has_the_target_of_webassembly_nodes() {
    let bare = Facts {
        wasm_library: false,
        ..READY
    };
    let steps = vec![Step::Rustup(Wasm)];
    assert_eq!(plan(&[Wasm], &bare), Ok((Toolchain::Current, steps)));
    let no_rustup = Facts {
        rustup: false,
        ..bare
    };
    assert_eq!(plan(&[Wasm], &no_rustup), Err(Missing(Wasm)));
}

#[test]
fn the_distribution_is_taken_when_it_is_asked_for() {
    let asked = Facts {
        distribution_wanted: true,
        distribution_rust: true,
        ..READY
    };
    assert_eq!(
        plan(&EMULATED, &asked),
        Ok((Toolchain::Distribution, vec![]))
    );
    let forbidden = Facts {
        distribution_rust: false,
        setup_allowed: false,
        ..asked
    };
    assert_eq!(plan(&EMULATED, &forbidden), Err(Missing(DistributionRust)));
}

#[test]
fn commands_use_the_rights_there_are() {
    let step = Step::Packages(Qemu, Packages::Dnf, Rights::Sudo);
    assert_eq!(
        step.commands(),
        [["sudo", "-n", "dnf", "install", "-y", QEMU]]
    );
    assert!(
        step.to_string()
            .ends_with("sudo -n dnf install -y qemu-system-arm")
    );
    let step = Step::Packages(Qemu, Packages::Apt, Rights::Root);
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
    for part in [Target, Sources, DistributionRust, Wasm, Qemu] {
        let text = Missing(part).to_string();
        assert!(
            text.contains("type") && text.contains("apt-get install") && !text.contains('\n'),
            "{text}"
        );
    }
    let qemu = Missing(Qemu).to_string();
    assert!(
        qemu.contains("dnf install qemu-system-arm") && qemu.contains("brew install qemu"),
        "{qemu}"
    );
    let probe = Missing(ProbeRs).to_string();
    assert!(probe.ends_with("type: cargo install probe-rs-tools --locked"));
}

proptest! {
    #[test]
    fn nothing_is_ever_installed_when_that_is_forbidden(facts in facts(), needs in needs()) {
        let facts = Facts { setup_allowed: false, ..facts };
        if let Ok((_, steps)) = plan(&needs, &facts) {
            prop_assert_eq!(steps, vec![]);
        }
    }

    #[test]
    fn setting_up_ends_even_when_every_step_fails(facts in facts(), needs in needs()) {
        let mut now = facts;
        for _ in 0..4 {
            match plan(&needs, &now) {
                Ok((_, steps)) if !steps.is_empty() => now = after(steps[0], false, &now, &facts),
                _ => return Ok(()),
            }
        }
        prop_assert!(false, "still trying: {now:?}");
    }
}
